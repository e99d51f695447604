# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench reloc`: drones put down somewhere in homes that they know."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from ground.checks import Check, write_report
from tests.bench.reloc.homes import ALIKE, KINDS, make_alike, make_home
from tests.bench.reloc.kidnappings import Outcome, kidnap, lost_flight, make_known
from tests.bench.reloc.on_chip import chip_figures, packed

PROFILE: Final = "real"
A_HOME: Final = 4
"""Kidnappings in one home."""

Figures = dict[str, float]


def in_homes(seed: int, kidnappings: int, out: Console) -> list[Outcome]:
    """Kidnappings in homes of all kinds in turn."""
    found: list[Outcome] = []
    homes = range(seed, seed + -(-kidnappings // A_HOME))
    for one in track(homes, "homes", console=out, transient=True, disable=not out.is_terminal):
        rng = np.random.default_rng((one, 0))
        known = make_known(make_home(KINDS[one % len(KINDS)], rng), PROFILE, rng)
        found += [kidnap(known, PROFILE, np.random.default_rng((one, k))) for k in range(1, 5)]
    return found[:kidnappings]


def in_places_alike(seed: int, count: int) -> list[Outcome]:
    """Where nobody could be sure."""
    found: list[Outcome] = []
    for one in range(seed, seed + count):
        rng = np.random.default_rng((one, 100))
        known = make_known(make_alike(ALIKE[one % len(ALIKE)], rng), PROFILE, rng)
        found.append(kidnap(known, PROFILE, rng))
    return found


def on_chip(seed: int) -> Figures:
    """One flight on the emulated chip."""
    rng = np.random.default_rng((seed, 200))
    known = make_known(make_home("three", rng), PROFILE, rng)
    flight = lost_flight(known, PROFILE, rng)
    return chip_figures(packed(known.drawn.grid, flight.odometry, flight.ranges_m))


def summary(outcomes: Sequence[Outcome]) -> Figures:
    """Figures of one group."""
    sure = [outcome for outcome in outcomes if outcome.sure]

    def of_sure(name: str, percent: float) -> float:
        values = [getattr(outcome, name) for outcome in sure]
        return float(np.percentile(values, percent)) if values else float("nan")

    return {
        "kidnappings": len(outcomes),
        "relocalised_fraction": sum(outcome.right for outcome in outcomes) / len(outcomes),
        "confidently_wrong_fraction": sum(not one.right for one in sure) / len(outcomes),
        "never_sure_fraction": 1.0 - len(sure) / len(outcomes),
        "time_median_s": of_sure("sure_s", 50),
        "time_p95_s": of_sure("sure_s", 95),
        "error_median_m": of_sure("off_m", 50),
        "error_p95_m": of_sure("off_m", 95),
        "error_p95_rad": of_sure("off_rad", 95),
        "elsewhere_fraction": sum(one.off_m > 0.5 for one in sure) / len(outcomes),
    }


def table_of(groups: dict[str, Figures]) -> Table:
    """A line for each group."""
    table = Table("group", "n", "found", "wrong", "far", "unsure", "s", "p95", "m", "p95")
    for name, row in groups.items():
        shares = ("relocalised", "confidently_wrong", "elsewhere", "never_sure")
        table.add_row(
            name,
            f"{row['kidnappings']:.0f}",
            *(f"{100 * row[f'{share}_fraction']:.1f} %" for share in shares),
            f"{row['time_median_s']:.1f}",
            f"{row['time_p95_s']:.1f}",
            f"{row['error_median_m']:.3f}",
            f"{row['error_p95_m']:.3f}",
        )
    return table


def run_reloc(json_file: Path | None, seed: int, kidnappings: int, out: Console) -> bool:
    """Print the table; True if every check holds. A quarter as many where places look alike."""
    homes = in_homes(seed, kidnappings, out)
    groups = {"homes": summary(homes)}
    for kind in KINDS:
        of_kind = [outcome for outcome in homes if outcome.kind == kind]
        if of_kind:
            groups[kind] = summary(of_kind)
    groups["alike"] = summary(in_places_alike(seed, max(3, kidnappings // 4)))
    out.print(table_of(groups))
    total = groups["homes"]
    chip = on_chip(seed)
    out.print(
        f"on the emulated chip a slice takes {chip['chip_slice_cycles_median']:,.0f} cycles, "
        f"at worst {chip['chip_slice_cycles_worst']:,.0f} (times 1.25)"
    )
    checks = [
        Check("relocalised_fraction", total["relocalised_fraction"], 0.95, ">="),
        Check("confidently_wrong_fraction", total["confidently_wrong_fraction"], 0.01, "<="),
        Check("chip_same_bits", chip["chip_same_bits"], 1.0, ">="),
    ]
    for check in checks:
        verdict = "ok  " if check.ok else "FAIL"
        out.print(f"{verdict} {check.name} {check.value:.3f} {check.sense} {check.limit}")
    if json_file:
        write_report(json_file, {**total, **chip, "groups": groups}, checks)
    return all(check.ok for check in checks)
