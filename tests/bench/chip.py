# SPDX-License-Identifier: GPL-3.0-or-later
"""What whole flights cost on an emulated Cortex-M4F, and whether it decides as this machine does.

`wayflie bench chip`. The cycle model is described in tests/firmware/m4_decode.h and m4_cost.h.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from tests.firmware.build import FLAG_SETS
from tests.firmware.chip import CLOCK_HZ
from tests.firmware.flights import ALL, Flight
from tests.firmware.replay import STAGES, TICK, Replay, replay
from tests.tools.gates import (
    FLASH_LIMIT_BYTES,
    RAM_LIMIT_BYTES,
    STACK_LIMIT_BYTES,
    flash_bytes,
    ram_bytes,
    stack_bytes,
)
from tests.tools.objects import CHIP, compile_tree

TICK_LIMIT_CYCLES = 840_000
SAFETY = 1.25
"""The model's: it covers 56 of 57 programs whose cycles on hardware are published."""

Cycles = NDArray[np.uint32]


def columns(replays: Iterable[Replay]) -> dict[str, Cycles]:
    """Cycles of each stage in the ticks in which it ran, over all flights."""
    runs = [done.run for done in replays]
    names = {"tick": TICK} | STAGES
    joined = {
        name: np.concatenate([run.cycles[function] for run in runs])
        for name, function in names.items()
    }
    return {name: cycles[cycles > 0] for name, cycles in joined.items()}


def figures(cycles: Cycles) -> dict[str, int]:
    """Median, 99 of 100, worst; as the model says, without the factor."""
    if len(cycles) == 0:
        return {"ticks": 0, "median": 0, "p99": 0, "worst": 0}
    return {
        "ticks": len(cycles),
        "median": int(np.median(cycles)),
        "p99": int(np.percentile(cycles, 99)),
        "worst": int(cycles.max()),
    }


def stage_table(flags: str, stages: dict[str, dict[str, int]]) -> Table:
    """Stages of a tick; those with a colon are a part of the one before the colon."""
    table = Table("stage", "ticks", "median", "p99", "worst", "worst x 1.25", "ms", title=flags)
    for name, row in stages.items():
        safe = SAFETY * row["worst"]
        numbers = [f"{row[key]:,}" for key in ("ticks", "median", "p99", "worst")]
        table.add_row(name, *numbers, f"{safe:,.0f}", f"{1000 * safe / CLOCK_HZ:.2f}")
    return table


def fly(flights: Iterable[Flight], out: Console) -> dict[str, list[Replay]]:
    """All flights under both sets of flags, a line for each."""
    done: dict[str, list[Replay]] = {flags: [] for flags in FLAG_SETS}
    for flight in flights:
        for flags, replays in done.items():
            replays.append(replay(flight, flags))
        differences = {flags: replays[-1].difference for flags, replays in done.items()}
        parted = [f"{flags}: {said}" for flags, said in differences.items() if said]
        ticks = done["firmware"][-1].recording.ticks
        out.print(f"{flight.name:24} {ticks:6} ticks  {'; '.join(parted) or 'bit for bit'}")
    return done


def report(done: dict[str, list[Replay]]) -> dict[str, Any]:
    """Everything that is measured, as JSON; costs are those of the firmware's own flags."""
    stages = {
        flags: {name: figures(cycles) for name, cycles in columns(replays).items()}
        for flags, replays in done.items()
    }
    pairs = list(zip(*done.values(), strict=True))
    alike = sum(all(replayed.difference is None for replayed in pair) for pair in pairs)
    with tempfile.TemporaryDirectory() as folder:
        objects = compile_tree(CHIP, Path(folder))
        ram, flash, stack = ram_bytes(objects), flash_bytes(objects), stack_bytes(objects)
    measured = max(max(replayed.run.stack_bytes.values()) for replayed in done["firmware"])
    worst = stages["firmware"]["tick"]["worst"]
    return {
        "flights": len(pairs),
        "flights_bit_identical": alike,
        "worst_tick_cycles": worst,
        "worst_tick_cycles_safe": round(SAFETY * worst),
        "ram_bytes": ram,
        "stack_bytes": stack,
        "stack_of_nav_step_bytes": measured,
        "flash_bytes": flash,
        "stages": stages,
        "checks": {
            "flights_bit_identical": alike == len(pairs),
            "worst_tick": SAFETY * worst <= TICK_LIMIT_CYCLES,
            "ram": ram <= RAM_LIMIT_BYTES,
            "stack": measured <= stack <= STACK_LIMIT_BYTES,
            "flash": flash <= FLASH_LIMIT_BYTES,
        },
    }


def run_chip(json_file: Path | None, flights: int, out: Console) -> bool:
    """Print the tables; True if every check holds."""
    found = report(fly(ALL[:flights], out))
    for flags, stages in found["stages"].items():
        out.print(stage_table(flags, stages))
    for name, holds in found["checks"].items():
        out.print(f"{'ok  ' if holds else 'FAIL'} {name}")
    if json_file:
        json_file.write_text(json.dumps(found, indent=2) + "\n")
    return all(found["checks"].values())
