# SPDX-License-Identifier: GPL-3.0-or-later
"""Replays a recorded flight of the app on the chip: what differs, and what its task costs."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import cache
from typing import Final

from tests.firmware.app_flights import Flown, record
from tests.firmware.build import APP, build
from tests.firmware.chip import Chip, Run
from tests.firmware.flights import Flight
from tests.firmware.replay import TICK

PERIOD: Final = "coroutine_resume"
"""From the end of one sleep of the app's task to the beginning of the next."""

APP_STAGES: Final = {
    "sensors": "app_sensors_read",
    "parameters": "app_params_apply",
    "tick": TICK,
    "setpoint": "app_setpoint_send",
    "receive": "app_link_receive",
    "send": "app_link_send",
    "map": "app_map_refill",
    "status": "app_status_show",
}
"""Stages of a period and the function that each of them is."""


@dataclass(frozen=True)
class AppReplay:
    """A flight of the app on the chip; `difference` is None if every bit is the same as here."""

    flown: Flown
    run: Run
    difference: str | None
    stack_bytes: int


@cache
def replay_app(flight: Flight, flags: str) -> AppReplay:
    """Fly here, then make the same calls to the app on the chip."""
    flown = record(flight)
    run = Chip(build(APP, flags)).run(bytes(flown.recording.calls), (PERIOD, *APP_STAGES.values()))
    there, stack = run.output[:-4], run.output[-4:]
    difference = flown.recording.first_difference(there)
    return AppReplay(flown, run, difference, *struct.unpack("<I", stack))
