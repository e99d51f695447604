# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles of an emulated Cortex-M4F as figures and tables, with their limits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from tests.firmware.chip import CLOCK_HZ, Run

TICK_LIMIT_CYCLES = 840_000
AROUND_LIMIT_CYCLES = 84_000
"""What the app may do in a period beside the tick."""
SAFETY = 1.25
"""The model's: it covers 56 of 57 programs whose cycles on hardware are published."""

Cycles = NDArray[np.uint32]


def columns(runs: Iterable[Run], stages: Mapping[str, str]) -> dict[str, Cycles]:
    """Cycles of each stage in the ticks in which it ran, over all runs; stages name functions."""
    every = list(runs)
    joined = {
        name: np.concatenate([run.cycles[function] for run in every])
        for name, function in stages.items()
    }
    return {name: cycles[cycles > 0] for name, cycles in joined.items()}


def figures(cycles: Cycles) -> dict[str, int]:
    """Median, 99th percentile and worst case, by the model and without its safety factor."""
    if len(cycles) == 0:
        return {"ticks": 0, "median": 0, "p99": 0, "worst": 0}
    return {
        "ticks": len(cycles),
        "median": int(np.median(cycles)),
        "p99": int(np.percentile(cycles, 99)),
        "worst": int(cycles.max()),
    }


def flag_figures(
    runs: Mapping[str, Iterable[Run]], stages: Mapping[str, str]
) -> dict[str, dict[str, dict[str, int]]]:
    """Figures of each stage for each set of flags."""
    return {
        flags: {name: figures(cycles) for name, cycles in columns(found, stages).items()}
        for flags, found in runs.items()
    }


def outcome(differences: Mapping[str, str | None]) -> str:
    """Which stages differed under which flags, in a few words."""
    parted = [f"{flags}: {said}" for flags, said in differences.items() if said]
    return "; ".join(parted) or "bit for bit"


def stage_table(title: str, stages: dict[str, dict[str, int]]) -> Table:
    """Stages of a tick; those with a colon are a part of the one before the colon."""
    table = Table("stage", "ticks", "median", "p99", "worst", "worst x 1.25", "ms", title=title)
    for name, row in stages.items():
        safe = SAFETY * row["worst"]
        numbers = [f"{row[key]:,}" for key in ("ticks", "median", "p99", "worst")]
        table.add_row(name, *numbers, f"{safe:,.0f}", f"{1000 * safe / CLOCK_HZ:.2f}")
    return table
