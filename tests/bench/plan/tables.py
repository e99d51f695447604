# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables that a run of the planning bench prints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from ground.checks import Check
from tests.bench.plan.figures import Results, speedup
from tests.bench.plan.ratios import geometric_ratio, percentile
from tests.bench.plan.runs import OURS, Columns

WIDTH = 118
"""Columns of text: so wide that no number is broken."""


def _row(runs: Columns) -> list[str]:
    times = ("first_s", "within_105_s", "within_102_s")
    tails = [1000 * percentile(runs[time], percent) for time in times for percent in (50, 95)]
    reached = [100 * np.isfinite(runs[name]).mean() for name in ("cost", "within_102_s")]
    nodes, size = np.median(runs["nodes_end"]), np.median(runs["bytes_105"])
    return [
        *(f"{tail:.3f}" if tail < 10 else f"{tail:.1f}" for tail in tails),
        *(f"{share:.1f}" for share in reached),
        f"{percentile(runs['first_cost'] / runs['optimum'], 50):.3f}",
        f"{nodes:.0f}" if nodes > 0 else "-",
        f"{size / 1024:.1f}" if size >= 0 else "-",
    ]


def planners_table(results: Results) -> Table:
    """Medians and 95th percentiles of the times to a way and to a good one, in ms."""
    times = ("first", "p95", "<=1.05", "p95", "<=1.02", "p95")
    shares = ("solved %", "1.02 %", "1st cost", "nodes", "KiB")
    table = Table(
        box=SIMPLE_HEAD, padding=0, pad_edge=False, title="milliseconds until a way is known"
    )
    for heading in ("family", "planner"):
        table.add_column(heading, no_wrap=True)
    for heading in (*times, *shares):
        table.add_column(heading, no_wrap=True, justify="right", min_width=7)
    for family in (None, *results.plans[OURS]):
        for planner in results.plans:
            table.add_row(family or "all", planner, *_row(results.of(planner, family)))
        table.add_section()
    return table


def _short(ratio: float) -> str:
    return f"{ratio:.2f}" if ratio < 10 else f"{ratio:.1f}" if ratio < 100 else f"{ratio:.0f}"


def speedups_table(results: Results, name: str, title: str) -> Table:
    """Geometric means by family, and over all with the interval."""
    families = list(results.plans[OURS])
    table = Table(box=SIMPLE_HEAD, padding=0, pad_edge=False, title=title)
    table.add_column("opponent", no_wrap=True)
    for heading in ("all", *families):
        table.add_column(heading, no_wrap=True, justify="right", min_width=7)
    for other in results.plans:
        if other == OURS:
            continue
        whole = speedup(results, other, name, geometric_ratio)
        parts = [speedup(results, other, name, geometric_ratio, family) for family in families]
        ratios = [(ratio.value, ratio.low) for ratio in (whole, *parts)]
        table.add_row(other, *(f"{_short(value)} ({_short(low)})" for value, low in ratios))
    return table


def print_tables(results: Results, checks: Sequence[Check], out: Console) -> None:
    """Planners by family, how many times as fast ours is, and what of it is checked."""
    out = Console(file=out.file, width=max(out.width, WIDTH), highlight=False)
    out.print(planners_table(results))
    if len(results.plans) > 1:
        for name, what in (
            ("first_s", "the first way"),
            ("within_105_s", "1.05 x optimum"),
            ("within_102_s", "1.02 x optimum"),
        ):
            title = f"times as fast to {what}, with the lower 95 % bound"
            out.print(speedups_table(results, name, title))
    for check in checks:
        verdict = "ok  " if check.ok else "FAIL"
        value = "not reached" if check.value is None else f"{check.value:.4g}"
        out.print(f"{verdict} {check.name} {value} {check.sense} {check.limit:.4g}")
