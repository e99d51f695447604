# SPDX-License-Identifier: GPL-3.0-or-later
"""The app on the chip, for `wayflie bench chip`: periods of its task, its stack, its output."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from rich.console import Console

from tests.bench.cycles import AROUND_LIMIT_CYCLES, SAFETY, flag_figures, outcome
from tests.firmware.app_flights import MANY
from tests.firmware.app_replay import APP_STAGES, PERIOD, AppReplay, replay_app
from tests.firmware.build import FLAG_SETS
from tests.firmware.flights import Flight
from tests.firmware.replay import TICK
from tests.tools.gates import STACK_LIMIT_BYTES


def fly(flights: Iterable[Flight], out: Console) -> dict[str, list[AppReplay]]:
    """Fly those of these flights that the app flies too, under both sets of flags."""
    done: dict[str, list[AppReplay]] = {flags: [] for flags in FLAG_SETS}
    for flight in (flight for flight in flights if flight in MANY):
        for flags, replays in done.items():
            replays.append(replay_app(flight, flags))
        differences = {flags: replays[-1].difference for flags, replays in done.items()}
        calls = len(done["firmware"][-1].flown.recording.outcomes)
        out.print(f"{flight.name:28} {calls:6} calls  {outcome(differences)}")
    return done


def around(done: AppReplay) -> int:
    """The most cycles that a period took besides its tick."""
    period, tick = (done.run.cycles[name].astype(np.int64) for name in (PERIOD, TICK))
    return int((period - tick)[tick > 0].max())


def report(done: dict[str, list[AppReplay]]) -> dict[str, Any]:
    """The report as JSON; costs are those with the firmware's own flags."""
    names = {"period": PERIOD} | APP_STAGES
    runs = {flags: [replayed.run for replayed in replays] for flags, replays in done.items()}
    stages = flag_figures(runs, names)
    pairs = list(zip(*done.values(), strict=True))
    alike = sum(all(replayed.difference is None for replayed in pair) for pair in pairs)
    stack = max(replayed.stack_bytes for replayed in done["firmware"])
    beside = max(map(around, done["firmware"]))
    return {
        "flights": len(pairs),
        "flights_bit_identical": alike,
        "stack_bytes": stack,
        "median_period_cycles": stages["firmware"]["period"]["median"],
        "worst_period_cycles": stages["firmware"]["period"]["worst"],
        "worst_around_tick_cycles": beside,
        "stages": stages,
        "checks": {
            "app_flights_bit_identical": alike == len(pairs),
            "app_stack": stack <= STACK_LIMIT_BYTES,
            "app_around_tick": SAFETY * beside <= AROUND_LIMIT_CYCLES,
        },
    }


def sentence(found: dict[str, Any]) -> str:
    """A sentence with what no table shows."""
    return (
        f"stack of the app's task: {found['stack_bytes']:,} bytes of {STACK_LIMIT_BYTES:,}; "
        f"beside the tick at most {found['worst_around_tick_cycles']:,} cycles"
    )
