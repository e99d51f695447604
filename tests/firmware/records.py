# SPDX-License-Identifier: GPL-3.0-or-later
"""Records that flight.c reads and writes: little-endian, without gaps."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from ground.core import MAP_BYTES, CData

_INIT = struct.Struct("<6fI3B")
_TICK = struct.Struct("<I15f2B")
_COMMAND = struct.Struct("<B2f")
_SETPOINT = struct.Struct("<4f")
_STATUS = struct.Struct("<6f2I4B")
_EVENT = struct.Struct("<2I2B2f")


def init_record(cfg: CData) -> bytes:
    """The part of a nav_config_t that flights vary."""
    low, high = cfg.area_min_m, cfg.area_max_m
    numbers = (low.x, low.y, high.x, high.y, cfg.cell_m, cfg.clearance_m, cfg.seed)
    choices = (cfg.planner, cfg.slam, cfg.follower.yaw_mode)
    return b"I" + _INIT.pack(*numbers, *choices)


def tick_record(given: CData) -> bytes:
    """A nav_input_t."""
    odometry, velocity = given.odometry, given.velocity_mps
    pose = odometry.pose
    floats = (pose.x_m, pose.y_m, pose.yaw_rad, odometry.height_m, odometry.roll_rad)
    floats += (odometry.pitch_rad, velocity.x, velocity.y, given.yaw_rate_rps)
    floats += (*given.range_m, given.battery_v)
    return b"T" + _TICK.pack(odometry.time_ms, *floats, given.flags, given.positioning)


def command_record(command: CData) -> bytes:
    """A nav_command_t."""
    return b"C" + _COMMAND.pack(command.cmd, command.goal_m.x, command.goal_m.y)


HASH_RECORD = b"H"


def setpoint_bytes(setpoint: CData) -> bytes:
    """What flight.c writes for a nav_setpoint_t."""
    if not setpoint.motors:
        return b"\0"
    velocity = setpoint.velocity_body_mps
    floats = (setpoint.height_m, velocity.x, velocity.y, setpoint.yaw_rate_rps)
    return b"\1" + _SETPOINT.pack(*floats)


@dataclass(frozen=True, slots=True)
class Output:
    """The output for one record, cut into its parts."""

    kind: str
    setpoint: bytes = b""
    status: bytes = b""
    events: bytes = b""
    rest: bytes = b""


def outputs(data: bytes) -> Iterator[Output]:
    """All that flight.c has written."""
    at = 0

    def take(size: int) -> bytes:
        nonlocal at
        at += size
        return data[at - size : at]

    while at < len(data):
        kind = chr(take(1)[0])
        if kind != "T":
            yield Output(kind, rest=take({"I": 1, "C": 1, "H": 4}[kind]))
            continue
        setpoint = take(1)
        setpoint += take(_SETPOINT.size) if setpoint[0] else b""
        status, count = take(_STATUS.size), take(1)[0]
        yield Output(kind, setpoint, status, take(count * _EVENT.size), take(MAP_BYTES))


def first_difference(here: bytes, there: bytes) -> str | None:
    """Describe where two outputs begin to differ; None if they are the same."""
    if here == there:
        return None
    for number, (ours, theirs) in enumerate(zip(outputs(here), outputs(there), strict=False)):
        for part in Output.__slots__:
            a, b = getattr(ours, part), getattr(theirs, part)
            if a != b:
                shown = (a, b) if part == "kind" else (a.hex(), b.hex())
                return f"record {number} ({ours.kind}): {part} {shown[0]} here, {shown[1]} there"
    return f"{len(here)} bytes here, {len(there)} there"
