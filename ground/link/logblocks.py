# SPDX-License-Identifier: GPL-3.0-or-later
"""The log blocks that the ground requests, and how their values become messages.

A block holds at most 26 bytes and 9 variables: more would need a second packet to set it up, and
losing that one would leave a block of another shape.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ground.core import MissionReason, MissionState, SelfTest, Source
from ground.link.wire import is_map_piece
from ground.model import (
    Health,
    LogMessage,
    MapPacket,
    Odometry,
    Point,
    Pose,
    Positioned,
    Ranges,
    Telemetry,
)

Values = Mapping[str, float]
MAP_WORDS = tuple(f"waymap.m{i}" for i in range(7))
RANGE_NONE_MM = 32767


@dataclass(frozen=True, slots=True)
class LogBlock:
    """One block; decode(drone_ms, values) returns None if the values make no sense."""

    name: str
    period_ms: int
    variables: tuple[tuple[str, str], ...]
    decode: Callable[[int, Values], LogMessage | None]
    required: bool = True


def decode_telemetry(drone_ms: int, values: Values) -> Telemetry | None:
    """Decode the block `state`."""
    numbers = [float(values[name]) for name, _ in TELEMETRY_VARIABLES]
    if not all(map(math.isfinite, numbers)):
        return None
    x_m, y_m, yaw_deg, z_m, goal_x_m, goal_y_m, state, fault, confidence = numbers
    try:
        return Telemetry(
            drone_ms=drone_ms,
            pose=Pose(x_m, y_m, z_m, math.radians(yaw_deg)),
            goal=Point(goal_x_m, goal_y_m),
            state=MissionState(int(state)),
            fault=MissionReason(int(fault)),
            confidence_percent=int(confidence),
        )
    except ValueError:  # a state or reason that a newer app has added
        return None


def decode_health(drone_ms: int, values: Values) -> Health | None:
    """Decode the block `health`."""
    if not all(map(math.isfinite, values.values())):
        return None
    if values["way.selfState"] not in list(SelfTest):  # added by a newer app
        return None
    return Health(
        drone_ms=drone_ms,
        battery_v=float(values["pm.vbat"]),
        path_m=float(values["way.pathLen"]),
        plan_us=int(values["way.planUs"]),
        plan_nodes=int(values["way.planNodes"]),
        known_cells=int(values["way.known"]),
        tick_us=int(values["way.tickUs"]),
        drops=int(values["way.drops"]),
        supervisor=int(values["supervisor.info"]),
        self_test=SelfTest(int(values["way.selfState"])),
    )


def decode_ranges(drone_ms: int, values: Values) -> Ranges:
    """Decode the block `ranges`: millimetres, 32767 without return, 0 before the first range."""
    metres = [
        None if values[name] in (0, RANGE_NONE_MM) else values[name] / 1000
        for name, _ in RANGE_VARIABLES
    ]
    return Ranges(drone_ms, *metres)


def decode_odometry(drone_ms: int, values: Values) -> Odometry | None:
    """Decode the block `odometry`."""
    numbers = [float(values[name]) for name, _ in ODOMETRY_VARIABLES]
    if not all(map(math.isfinite, numbers)):
        return None
    x_m, y_m, yaw_deg, z_m, vx_mps, vy_mps, roll_deg, pitch_deg, gyro_dps = numbers
    return Odometry(
        drone_ms=drone_ms,
        pose=Pose(x_m, y_m, z_m, math.radians(yaw_deg)),
        roll_rad=math.radians(roll_deg),
        pitch_rad=math.radians(pitch_deg),
        vx_mps=vx_mps,
        vy_mps=vy_mps,
        yaw_rate_rps=math.radians(gyro_dps),
    )


def decode_source(drone_ms: int, values: Values) -> Positioned | None:
    """Decode the block `source`."""
    source = values["way.source"]
    return Positioned(drone_ms, Source(int(source))) if source in list(Source) else None


def decode_map(drone_ms: int, values: Values) -> LogMessage | None:
    """Decode the block `map`."""
    words = [int(values[name]) for name in MAP_WORDS]
    try:
        data = struct.pack("<6IH", *words)
    except struct.error:  # a variable has another type in this build of the app
        return None
    return MapPacket(drone_ms, data) if is_map_piece(data) else None


TELEMETRY_VARIABLES = (
    ("way.x", "float"),
    ("way.y", "float"),
    ("way.yaw", "FP16"),
    ("stateEstimate.z", "FP16"),
    ("way.goalX", "float"),
    ("way.goalY", "float"),
    ("way.state", "uint8_t"),
    ("way.fault", "uint8_t"),
    ("way.conf", "uint8_t"),
)
HEALTH_VARIABLES = (
    ("pm.vbat", "FP16"),
    ("way.pathLen", "float"),
    ("way.planUs", "uint32_t"),
    ("way.planNodes", "uint16_t"),
    ("way.known", "uint16_t"),
    ("way.tickUs", "uint32_t"),
    ("way.drops", "uint16_t"),
    ("supervisor.info", "uint16_t"),
    ("way.selfState", "uint8_t"),
)
RANGE_VARIABLES = tuple(
    (f"range.{side}", "uint16_t") for side in ("front", "back", "left", "right", "up")
)
ODOMETRY_VARIABLES = (
    ("stateEstimate.x", "float"),
    ("stateEstimate.y", "float"),
    ("stateEstimate.yaw", "float"),
    *((f"stateEstimate.{name}", "FP16") for name in ("z", "vx", "vy", "roll", "pitch")),
    ("gyro.z", "FP16"),
)
ODOMETRY_PERIOD_MS = 20  # the app's tick, so that the core can be run again on a recording
SOURCE_VARIABLES = (("way.source", "uint8_t"),)
MAP_VARIABLES = (*((name, "uint32_t") for name in MAP_WORDS[:6]), (MAP_WORDS[6], "uint16_t"))


def log_blocks(map_period_ms: int) -> tuple[LogBlock, ...]:
    """All blocks of a session; periods are multiples of 10 ms from 10 to 2540."""
    return (
        LogBlock("state", 50, TELEMETRY_VARIABLES, decode_telemetry),
        LogBlock("map", map_period_ms, MAP_VARIABLES, decode_map),
        LogBlock("health", 500, HEALTH_VARIABLES, decode_health),
        LogBlock("ranges", 100, RANGE_VARIABLES, decode_ranges, required=False),
        LogBlock(
            "odometry", ODOMETRY_PERIOD_MS, ODOMETRY_VARIABLES, decode_odometry, required=False
        ),
        LogBlock("source", 500, SOURCE_VARIABLES, decode_source, required=False),
    )
