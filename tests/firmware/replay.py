# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a program on the same input here and on the chip: what differs, and what it costs there."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from functools import cache
from typing import Final

from tests.firmware.build import FLIGHT, Program, build
from tests.firmware.chip import Chip, Run
from tests.firmware.flights import FEW, Flight, Recording, record
from tests.firmware.records import first_difference, outputs

STAGES: Final = {
    "scan": "scan_step",
    "predict": "slam_predict",
    "take in": "slam_update",
    "slam": "slam_work",
    "draw": "grid_insert",
    "clearance": "clearance_refresh",
    "plan": "nav_plan_step",
    "plan: wave": "wavefront_extend",
    "plan: tree": "rrtstar_sample",
    "plan: taut": "taut_step",
    "plan: route": "route_build",
    "watch": "nav_watch",
    "look": "seen_mark",
    "intruders": "grid_classify_echo",
    "fade": "grid_fade",
    "motion": "nav_move",
    "motion: clear": "route_clear_m",
    "motion: known": "route_known_m",
}
"""Stages of a tick and the function that each of them is."""

TICK: Final = "nav_step"
RUNS: Final = (*((flight, "firmware") for flight in FEW), (FEW[0], "strict"))
"""Every flight as the real firmware is compiled; one with other flags, which change nothing."""


def part_name(part: Flight | str) -> str:
    """Name of one half of a run."""
    return part if isinstance(part, str) else part.name


@dataclass(frozen=True)
class Replay:
    """A flight on the chip; `difference` is None if every bit is the same as here."""

    recording: Recording
    run: Run
    difference: str | None


def on_this_machine(program: Program, data: bytes) -> bytes:
    """The program's output on this machine."""
    command = [str(build(program))]
    return subprocess.run(command, input=data, capture_output=True, check=True).stdout


@cache
def replay(flight: Flight, flags: str) -> Replay:
    """Fly here, then let the chip compute the same flight from the same inputs."""
    recording = record(flight)
    data = bytes(recording.records)
    here = on_this_machine(FLIGHT, data)
    run = Chip(build(FLIGHT, flags)).run(data, (TICK, *STAGES.values()))
    difference = first_difference(here, run.output)
    steered = [output.setpoint for output in outputs(here) if output.kind == "T"]
    if steered != recording.setpoints:
        difference = "this machine's own program does not repeat the flight"
    return Replay(recording, run, difference)
