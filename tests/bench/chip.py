# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of whole flights on an emulated Cortex-M4F, and whether it decides as this machine.

`wayflie bench chip`. The cycle model is described in tests/firmware/m4_decode.h and m4_cost.h.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rich.console import Console

from ground.checks import write_json
from tests.bench import chip_app
from tests.bench.cycles import SAFETY, TICK_LIMIT_CYCLES, flag_figures, outcome, stage_table
from tests.firmware.build import FLAG_SETS
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


def fly(flights: Iterable[Flight], out: Console) -> dict[str, list[Replay]]:
    """Fly all flights under both sets of flags, and print a line for each."""
    done: dict[str, list[Replay]] = {flags: [] for flags in FLAG_SETS}
    for flight in flights:
        for flags, replays in done.items():
            replays.append(replay(flight, flags))
        differences = {flags: replays[-1].difference for flags, replays in done.items()}
        ticks = done["firmware"][-1].recording.ticks
        out.print(f"{flight.name:28} {ticks:6} ticks  {outcome(differences)}")
    return done


def report(done: dict[str, list[Replay]]) -> dict[str, Any]:
    """The report as JSON; costs are those with the firmware's own flags."""
    names = {"tick": TICK} | STAGES
    runs = {flags: [replayed.run for replayed in replays] for flags, replays in done.items()}
    stages = flag_figures(runs, names)
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
    out.print("the core, replayed")
    found = report(fly(ALL[:flights], out))
    out.print("the app, replayed")
    found["app"] = chip_app.report(chip_app.fly(ALL[:flights], out))
    found["checks"] |= found["app"].pop("checks")
    for flags, stages in found["stages"].items():
        out.print(stage_table(f"ticks of the core, {flags}", stages))
    for flags, stages in found["app"]["stages"].items():
        out.print(stage_table(f"periods of the app, {flags}", stages))
    out.print(chip_app.sentence(found["app"]))
    for name, holds in found["checks"].items():
        out.print(f"{'ok  ' if holds else 'FAIL'} {name}")
    if json_file:
        write_json(json_file, found)
    return all(found["checks"].values())
