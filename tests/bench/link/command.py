# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench link`: what the link between drone and ground costs, and what gets lost on it."""

from __future__ import annotations

import asyncio
from pathlib import Path

from rich.console import Console
from rich.table import Table

from ground.checks import Check, write_report
from ground.progress import waiting
from tests.bench.link.parts import Figures, breaking, commanding, fetching, healing, lasting

NOTICED_S = 2.0
MEMORY_GROWTH_MB = 10.0


def run_link(json_file: Path | None, seed: int, minutes: float, out: Console) -> bool:
    """Run all measurements. @return every check held"""
    figures: Figures = {}
    for title, part in (
        ("a fresh client fetches the map", fetching(seed)),
        ("loss, duplication and reordering", healing(seed)),
        ("commands over that way", commanding(seed)),
        ("silent, dead, restarted", breaking(seed)),
        (f"four drones for {minutes:g} minutes", lasting(seed, minutes)),
    ):
        out.print(f"[dim]{title}[/]")
        with waiting(out, title):
            figures |= asyncio.run(part)
    checks = checks_of(figures)
    out.print(table_of(figures, checks))
    if json_file:
        write_report(json_file, figures, checks)
    return all(check.ok for check in checks)


def checks_of(figures: Figures) -> list[Check]:
    """The checks of the link."""
    growth_mb = (figures["memory_end_mb"] or 0.0) - (figures["memory_start_mb"] or 0.0)
    return [
        Check("full_map_s", figures["full_map_s"], 3.0, "<="),
        Check("wire_bytes", figures["wire_bytes"], 12_000, "<="),
        Check("healed_after_loss_s", figures["healed_after_loss_s"], 10.0, "<="),
        Check("events_missing", figures["events_missing"], 0, "=="),
        Check("commands_executed_twice", figures["commands_executed_twice"], 0, "=="),
        Check("commands_lost", figures["commands_lost"], 0, "=="),
        Check("noticed_silent_s", figures["noticed_silent_s"], NOTICED_S, "<="),
        Check("noticed_dead_s", figures["noticed_dead_s"], NOTICED_S, "<="),
        Check("noticed_restarted_s", figures["noticed_restarted_s"], NOTICED_S, "<="),
        Check("mission_state_right", figures["mission_state_right"], 1, "=="),
        Check("station_cpu_share", figures["station_cpu_share"], 0.4, "<="),
        Check("memory_growth_mb", growth_mb, MEMORY_GROWTH_MB, "<="),
        Check("dropped_messages", figures["dropped_messages"], 0, "=="),
    ]


def table_of(figures: Figures, checks: list[Check]) -> Table:
    """A line for each figure."""
    limits = {check.name: check for check in checks}
    table = Table("figure", "measured", "limit", box=None, padding=(0, 2, 0, 0))
    for name, value in figures.items():
        check = limits.get(name)
        limit = f"{check.sense} {check.limit:g}" if check else ""
        colour = "" if check is None or check.ok else "[red]"
        words = "none" if value is None else f"{value:.4g}" if value < 1e5 else f"{value:.0f}"
        table.add_row(name, f"{colour}{words}", limit)
    return table
