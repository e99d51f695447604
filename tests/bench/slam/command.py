# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench slam`: the core's SLAM over many simulated flights, and over a recorded one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from ground.checks import Check, Sense, write_report
from tests.bench.reloc.families import relocalised_fraction
from tests.bench.slam import peer
from tests.bench.slam.drive import Method
from tests.bench.slam.flights import PLAIN, STRESS, Variant, make_flight
from tests.bench.slam.real import judge
from tests.bench.slam.scores import Score, fly

PROFILES: Final = ("real", "low", "hard", "perfect")
KIDNAPPED: Final = "kidnapped"
GROUPS: Final = (*PROFILES, "stress", KIDNAPPED)
FLIGHTS: Final = 36
FIRST_SEED: Final = 1002
FAR_M: Final = 0.25
RELOCALISED: Final = 0.95
"""Share of kidnappings that has to be solved."""

Figures = dict[str, float]
_Limit = tuple[str, Sense, float]
LIMITS: Final[dict[str, tuple[_Limit, ...]]] = {
    "real": (
        ("aligned_ate_median_m", "<=", 0.08),
        ("aligned_ate_p90_m", "<=", 0.14),
        ("worse_than_odometry", "<=", 0.0),
        ("raw_ate_median_m", "<=", 0.15),
        ("ratio_median", ">=", 4.5),
        ("map_error_m", "<=", 0.08),
    ),
    "hard": (("ratio_median", ">=", 9.0), ("aligned_ate_max_m", "<=", 0.30)),
    "perfect": (("aligned_ate_median_m", "<=", 0.03),),
    **{
        variant.name: (("aligned_ate_median_m", "<=", 0.12), ("beyond_25cm", "<=", 0.05))
        for variant in STRESS
    },
    "peer": (("ratio", ">=", 100.0), ("chip_same_bits", "==", 1.0)),
    "recorded": (("n80_cells", "<=", 900), ("early_late_rms_m", "<=", 0.05)),
}


def summary(scores: Sequence[Score]) -> Figures:
    """Figures of one group of flights."""
    aligned = np.array([score.slam.aligned_m for score in scores])
    odometry = np.array([score.odometry.aligned_m for score in scores])
    return {
        "flights": len(scores),
        "aligned_ate_median_m": float(np.median(aligned)),
        "aligned_ate_p90_m": float(np.percentile(aligned, 90)),
        "aligned_ate_max_m": float(aligned.max()),
        "raw_ate_median_m": float(np.median([score.slam.raw_m for score in scores])),
        "odometry_aligned_ate_median_m": float(np.median(odometry)),
        "ratio_median": float(np.median([score.ratio for score in scores])),
        "worse_than_odometry": float((aligned > odometry).mean()),
        "beyond_25cm": float((aligned > FAR_M).mean()),
        "within_2_sd": float(np.mean([score.within_2_sd for score in scores])),
        "map_error_m": float(np.median([score.map_m for score in scores])),
    }


def groups(wanted: Iterable[str]) -> dict[str, tuple[str, Variant]]:
    """Profile and variant of each group to fly."""
    found: dict[str, tuple[str, Variant]] = {}
    for name in wanted:
        if name == "stress":
            found |= {variant.name: ("real", variant) for variant in STRESS}
        elif name != KIDNAPPED:
            found[name] = (name, PLAIN)
    return found


def table_of(figures: dict[str, Figures]) -> Table:
    """A line per group; in metres, except for shares and the ratio."""
    errors = ("aligned", "p90", "max", "raw", "odom", "ratio", "worse")
    table = Table("group", "n", *errors, "2 sd", "map", padding=0)
    for name, row in figures.items():
        table.add_row(
            name,
            f"{row['flights']:.0f}",
            *(f"{row[f'aligned_ate_{key}_m']:.3f}" for key in ("median", "p90", "max")),
            f"{row['raw_ate_median_m']:.3f}",
            f"{row['odometry_aligned_ate_median_m']:.3f}",
            f"{row['ratio_median']:.1f}",
            f"{100 * row['worse_than_odometry']:.0f} %",
            f"{100 * row['within_2_sd']:.0f} %",
            f"{row['map_error_m']:.3f}",
        )
    return table


def checks_of(figures: dict[str, Any]) -> list[Check]:
    """Every limit of the groups that were flown."""
    return [
        Check(f"{group}.{key}", figures[group][key], limit, sense)
        for group, limits in LIMITS.items()
        if group in figures
        for key, sense, limit in limits
    ]


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to fly."""

    seed: int = FIRST_SEED
    flights: int = FLIGHTS
    groups: Sequence[str] = GROUPS
    against: Method | None = None
    recorded: Path | None = None
    peer: Path | None = None
    """A checkout of CrazySLAM."""


def fly_groups(wanted: Wanted, method: Method, out: Console) -> dict[str, Figures]:
    """Fly every group by one method; stress variants get half as many flights."""
    figures = {}
    for name, (profile, variant) in groups(wanted.groups).items():
        count = wanted.flights if variant is PLAIN else max(1, wanted.flights // 2)
        seeds = track(
            range(wanted.seed, wanted.seed + count),
            f"{name} {method}",
            console=out,
            transient=True,
            disable=not out.is_terminal,
        )
        flown = [fly(make_flight(seed, profile, variant), method) for seed in seeds]
        figures[name] = summary(flown)
    return figures


def judge_recorded(path: Path, out: Console) -> dict[str, float]:
    """Judge a recorded flight by its held-out columns: the core against its odometry."""
    judged = judge(path)
    for name, crisp in judged.items():
        out.print(
            f"recorded, {name}: 80 % of the held-out points in {crisp.n80_cells} cells, "
            f"late to early {crisp.early_late_rms_m:.3f} m"
        )
    odometry = {f"odometry_{key}": value for key, value in asdict(judged["odometry"]).items()}
    return asdict(judged["slam"]) | odometry


def race(folder: Path, seed: int, out: Console) -> dict[str, float]:
    """Updates per second compared with CrazySLAM's."""
    found = peer.compare(folder, seed)
    out.print(
        f"updates a second with {peer.BEAMS} beams: {found['ours_hz']:,.0f} here, "
        f"{found['chip_hz']:,.0f} on the chip ({found['chip_update_cycles']:,.0f} cycles); "
        f"CrazySLAM with {peer.PARTICLES} particles here {found['peer_hz']:,.0f}: "
        f"{found['ratio']:.0f} times"
    )
    return found


def run(wanted: Wanted, json_file: Path | None, out: Console) -> bool:
    """Print the tables; True if every check holds."""
    figures: dict[str, Any] = dict(fly_groups(wanted, "slam", out))
    shown = dict(figures)
    if wanted.against:
        other = fly_groups(wanted, wanted.against, out)
        figures[wanted.against] = other
        shown |= {f"{wanted.against} {name}": row for name, row in other.items()}
    if shown:
        out.print(table_of(shown))
    if wanted.recorded:
        figures["recorded"] = judge_recorded(wanted.recorded, out)
    if wanted.peer:
        figures["peer"] = race(wanted.peer, wanted.seed, out)
    checks = checks_of(figures)
    if KIDNAPPED in wanted.groups:
        figures["relocalised_fraction"] = relocalised_fraction(wanted.seed)
        checks.append(
            Check("relocalised_fraction", figures["relocalised_fraction"], RELOCALISED, ">=")
        )
    for check in checks:
        verdict = "ok  " if check.ok else "FAIL"
        out.print(f"{verdict} {check.name} {check.value:.3f} {check.sense} {check.limit}")
    if json_file:
        write_report(json_file, figures, checks)
    return all(check.ok for check in checks)
