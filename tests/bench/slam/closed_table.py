# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench slam --closed-loop`: goals by the corrected pose and by odometry alone."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.table import Table

from ground.checks import Check, write_report
from ground.progress import waiting
from ground.sim.profiles import PROFILES
from tests.bench.slam.closed_loop import Flown, Plan, fly_closed
from tests.bench.slam.closed_plot import plot_flights

GROUPS: Final = tuple(PROFILES)
SHOWN: Final = ("real", "hard")
FLIGHTS: Final = 5
FIRST_SEED: Final = 1
MODES: Final = {1: "slam", 2: "slam 2", 0: "odometry alone"}
"""By what `way.slam` says."""
_KEYS: Final = {1: "slam", 2: "slam_2", 0: "odometry"}

Figures = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to fly, and where to write plots of the first flights."""

    groups: Sequence[str] = SHOWN
    seed: int = FIRST_SEED
    flights: int = FLIGHTS
    minutes: float = 10.0
    plots: Path | None = None


def summary(flights: Sequence[Flown]) -> Figures:
    """Figures of the flights of one profile and mode."""
    given = sum(len(flown.legs) for flown in flights)
    errors_m = np.concatenate([flown.errors_m for flown in flights])
    at_goals_m = [
        float(error_m)
        for flown in flights
        for leg, error_m in zip(flown.legs, flown.leg_errors_m, strict=True)
        if leg.arrived
    ]
    return {
        "flights": len(flights),
        "minutes": sum(flown.believed[-1, 0] - flown.believed[0, 0] for flown in flights) / 60,
        "touches": sum(len(flown.touches) for flown in flights),
        "goals": given,
        "arrived": sum(flown.arrived for flown in flights) / given,
        "truly_there": sum(flown.truly_there for flown in flights) / given,
        "lost": sum(flown.lost for flown in flights),
        "goal_error_median_m": statistics.median(at_goals_m) if at_goals_m else float("nan"),
        "error_median_m": float(np.median(errors_m)),
        "error_max_m": float(errors_m.max()),
        "error_end_m": statistics.median(float(flown.errors_m[-1]) for flown in flights),
        "aligned_median_m": float(
            np.median(np.concatenate([flown.aligned_errors_m for flown in flights]))
        ),
        "map_error_m": statistics.median(flown.map_m for flown in flights),
    }


def table_of(figures: dict[str, dict[str, Figures]]) -> Table:
    """A line per profile and mode; errors of estimated pose and map in metres."""
    table = Table("", "touches", "goals", "there", "lost", "error", "max", "aligned", "map")
    keys = ("error_median_m", "error_max_m", "aligned_median_m", "map_error_m")
    for profile, modes in figures.items():
        for mode, row in modes.items():
            table.add_row(
                f"{profile}, {mode}",
                str(row["touches"]),
                str(row["goals"]),
                f"{100 * row['truly_there']:.0f} %",
                f"{row['lost']} of {row['flights']}",
                *(f"{row[key]:.3f}" for key in keys),
            )
    return table


def checks_of(figures: dict[str, dict[str, Figures]]) -> list[Check]:
    """Checks: no contact and no lost flight; by odometry alone flights would get lost."""
    return [
        check
        for profile, modes in figures.items()
        for check in (
            *(
                Check(f"{profile}.{mode}.{key}", modes[mode][key], 0, "==")
                for mode in ("slam", "slam_2")
                for key in ("touches", "lost")
            ),
            Check(
                f"{profile}.odometry.lost",
                modes["odometry"]["lost"],
                modes["slam"]["flights"],
                "==",
            ),
        )
    ]


def sentence(flown: Flown) -> str:
    """The result of a flight in one line, with the seed to fly it again."""
    plan = flown.plan
    said = [f"{flown.truly_there} of {len(flown.legs)} goals"]
    said += [f"{touch['time_s']:.0f} s: touched {touch['obstacle']}" for touch in flown.touches]
    missed = Counter(leg.sentence for leg in flown.legs if not leg.arrived)
    for reason, times in missed.items():
        first = next(leg for leg in flown.legs if leg.sentence == reason)
        said.append(f"{first.end_s:.0f} s: {reason}" + (f" ({times} times)" if times > 1 else ""))
    return f"{plan.profile}, {MODES[plan.slam]}, seed {plan.seed}: {'; '.join(said)}"


def run(wanted: Wanted, json_file: Path | None, out: Console) -> bool:
    """Print the table; True if every check holds."""
    figures: dict[str, dict[str, Figures]] = {}
    for profile in wanted.groups:
        figures[profile] = {}
        for mode in MODES:
            flights = []
            for seed in range(wanted.seed, wanted.seed + wanted.flights):
                with waiting(out, f"{profile}, {MODES[mode]}, seed {seed}"):
                    flights.append(fly_closed(Plan(profile, mode, seed, wanted.minutes)))
                out.print(sentence(flights[-1]))
            figures[profile][_KEYS[mode]] = summary(flights)
            if wanted.plots:
                plot_flights(flights, wanted.plots / f"closed_loop_{profile}_{_KEYS[mode]}.png")
    out.print(table_of(figures))
    checks = checks_of(figures)
    for check in checks:
        verdict = "ok  " if check.ok else "FAIL"
        out.print(f"{verdict} {check.name} {check.value} {check.sense} {check.limit}")
    if json_file:
        write_report(json_file, {"closed_loop": figures}, checks)
    return all(check.ok for check in checks)
