# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench reloc`: drones put down somewhere in homes that they know."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from rich.console import Console
from rich.table import Table

from ground.checks import Check, write_report
from tests.bench.reloc.families import FAMILIES, HOMES, NOWHERE, PROFILE, kidnapped
from tests.bench.reloc.homes import KINDS, make_home
from tests.bench.reloc.kidnappings import Outcome, lost_flight, make_known, plain
from tests.bench.reloc.on_chip import chip_figures, packed

Figures = dict[str, float]
_QUANTILE: Final = 1.96
"""Of the normal distribution, for bounds that hold 95 % of the time."""


def wilson(count: int, of: int) -> tuple[float, float]:
    """Bounds of a share that was counted in so many cases (Wilson 1927)."""
    z2 = _QUANTILE**2 / of
    share = count / of
    middle = share + 0.5 * z2
    half = math.sqrt(z2 * (share * (1.0 - share) + 0.25 * z2))
    return max(0.0, (middle - half) / (1.0 + z2)), min(1.0, (middle + half) / (1.0 + z2))


def on_chip(seed: int) -> Figures:
    """Run one flight on the emulated chip."""
    rng = np.random.default_rng((seed, 200))
    known = make_known(make_home("three", rng), PROFILE, rng)
    flight = lost_flight(plain(known.room), PROFILE, rng)
    return chip_figures(packed(known.drawn.grid, flight.odometry, flight.ranges_m))


def summary(outcomes: Sequence[Outcome]) -> Figures:
    """Figures of one group."""
    sure = [outcome for outcome in outcomes if outcome.sure]
    right = sum(outcome.right for outcome in outcomes)
    wrong = len(sure) - right

    def of_sure(name: str, percent: float) -> float:
        values = [getattr(outcome, name) for outcome in sure if math.isfinite(outcome.off_m)]
        return float(np.percentile(values, percent)) if values else float("nan")

    return {
        "kidnappings": len(outcomes),
        "relocalised_fraction": right / len(outcomes),
        "relocalised_at_least": wilson(right, len(outcomes))[0],
        "confidently_wrong_fraction": wrong / len(outcomes),
        "confidently_wrong_at_most": wilson(wrong, len(outcomes))[1],
        "never_sure_fraction": 1.0 - len(sure) / len(outcomes),
        "time_median_s": of_sure("sure_s", 50),
        "time_p95_s": of_sure("sure_s", 95),
        "error_median_m": of_sure("off_m", 50),
        "error_p95_m": of_sure("off_m", 95),
        "error_p95_rad": of_sure("off_rad", 95),
        "elsewhere_fraction": sum(one.off_m > 0.5 for one in sure) / len(outcomes),
    }


def table_of(groups: dict[str, Figures]) -> Table:
    """A line for each group: shares in percent, with bounds that hold 95 % of the time."""
    heads = ("group", "n", "found (>=)", "wrong (<=)", "far", "unsure", "s", "p95", "m", "p95")
    table = Table(*heads, box=None, padding=(0, 1, 0, 0))

    def share(row: Figures, key: str) -> str:
        return f"{100 * row[key]:.1f}"

    for name, row in groups.items():
        found = share(row, "relocalised_fraction"), share(row, "relocalised_at_least")
        wrong = share(row, "confidently_wrong_fraction"), share(row, "confidently_wrong_at_most")
        table.add_row(
            name,
            f"{row['kidnappings']:.0f}",
            f"{found[0]} ({found[1]})",
            f"{wrong[0]} ({wrong[1]})",
            share(row, "elsewhere_fraction"),
            share(row, "never_sure_fraction"),
            f"{row['time_median_s']:.1f}",
            f"{row['time_p95_s']:.1f}",
            f"{row['error_median_m']:.3f}",
            f"{row['error_p95_m']:.3f}",
        )
    return table


def _measured(figures: Figures) -> Figures:
    """The figures that are not NaN, since JSON has none."""
    return {name: value for name, value in figures.items() if not math.isnan(value)}


def run_reloc(json_file: Path | None, seed: int, kidnappings: int, out: Console) -> bool:
    """Print the table; true if every check holds. Families other than homes get half as many."""
    groups: dict[str, Figures] = {}
    nowhere: list[Outcome] = []
    for family in FAMILIES:
        count = kidnappings if family == HOMES else max(4, kidnappings // 2)
        with out.status(family):
            outcomes = kidnapped(family, seed, count)
        groups[family] = summary(outcomes)
        nowhere += outcomes if family in NOWHERE else []
        for kind in KINDS if family == HOMES else ():
            of_kind = [outcome for outcome in outcomes if outcome.kind == kind]
            groups |= {kind: summary(of_kind)} if of_kind else {}
    groups["nowhere"] = summary(nowhere)
    out.print(table_of(groups))
    total = groups[HOMES]
    chip = on_chip(seed)
    out.print(
        f"on the emulated chip a slice takes {chip['chip_slice_cycles_median']:,.0f} cycles, "
        f"at worst {chip['chip_slice_cycles_worst']:,.0f} (times 1.25)"
    )
    wrong = "confidently_wrong_fraction"
    checks = [
        Check("relocalised_fraction", total["relocalised_fraction"], 0.95, ">="),
        Check(wrong, total[wrong], 0.01, "<="),
        Check(f"nowhere.{wrong}", groups["nowhere"][wrong], 0.05, "<="),
        Check("chip_same_bits", chip["chip_same_bits"], 1.0, ">="),
    ]
    for check in checks:
        verdict = "ok  " if check.ok else "FAIL"
        out.print(f"{verdict} {check.name} {check.value:.3f} {check.sense} {check.limit}")
    if json_file:
        told = {name: _measured(row) for name, row in groups.items()}
        write_report(json_file, {**_measured(total), **chip, "groups": told}, checks)
    return all(check.ok for check in checks)
