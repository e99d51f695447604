# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole flights of the core in the simulated rooms, recorded bit by bit.

A small closed loop of plant and nav_step, without radio and firmware: what goes into the core and
what came out of it here can be given to the chip's program. Same flight, same bytes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Final

from ground.core import CData, EventCode, MissionCmd, MissionState, ffi, lib
from ground.sim.model import RANGE_NONE_MM, Mode, Readings, Setpoint
from ground.sim.plant import PLANT_STEP_S, Plant
from ground.sim.world import load_world
from tests.firmware.records import HASH_RECORD, command_record, init_record, setpoint_bytes
from tests.firmware.records import tick_record as packed

TICK_S: Final = 0.02
COMMAND_AT_S: Final = 2.0
HASH_EVERY_TICKS: Final = 100
STEPS_PER_TICK: Final = round(TICK_S / PLANT_STEP_S)
READY: Final = (
    lib.NAV_HAS_FLOW
    | lib.NAV_HAS_RANGER
    | lib.NAV_ESTIMATOR_SETTLED
    | lib.NAV_CAN_FLY
    | lib.NAV_LINK_ALIVE
)


@dataclass(frozen=True, slots=True)
class Flight:
    """What to fly; the core's parameters are the defaults except for the named ones."""

    world: str
    seed: int = 1
    task: MissionCmd = MissionCmd.GOTO
    planner: int = lib.NAV_PLANNER_RRTSTAR
    slam: int = lib.NAV_SLAM_MAP
    yaw_mode: int = 0
    home: bool = False
    lost: bool = False
    limit_s: float = 180.0

    @property
    def name(self) -> str:
        words = [self.world, str(self.seed), self.task.name.lower()]
        words += ["home"] * self.home + ["lost"] * self.lost + ["by-wave"] * self.planner
        words += ["no-slam"] * (not self.slam) + [f"yaw{self.yaw_mode}"] * bool(self.yaw_mode)
        return "-".join(words)


@dataclass(slots=True)
class Recording:
    """A flight as bytes: records for flight.c, and the setpoints that it must give."""

    records: bytearray = field(default_factory=bytearray)
    setpoints: list[bytes] = field(default_factory=list)
    events: list[int] = field(default_factory=list)
    states: set[int] = field(default_factory=set)

    @property
    def ticks(self) -> int:
        return len(self.setpoints)


ALL: Final = (
    *(Flight(world, seed) for world in ("flat", "hall", "clutter", "door", "person", "empty")
      for seed in (1, 2)),
    *(Flight(world, task=MissionCmd.EXPLORE)
      for world in ("flat", "clutter", "door", "person", "empty")),
    Flight("flat", 3, home=True),
    Flight("empty", 4, lost=True),
    Flight("clutter", 3, planner=lib.NAV_PLANNER_GRID, home=True),
    Flight("empty", 3, slam=lib.NAV_SLAM_OFF, yaw_mode=1),
)  # fmt: skip
"""All rooms, all tasks, both planners, with and without SLAM; one looks for itself on the way."""

FEW: Final = (ALL[6], ALL[16], ALL[18], ALL[20])


class _Loop:
    """The core controlling a body in a room."""

    def __init__(self, flight: Flight) -> None:
        self.flight = flight
        self.record = Recording()
        self.nav = ffi.new("nav_t *")
        self._world = load_world(flight.world)
        self._plant = Plant(self._world, flight.seed)
        self._input = ffi.new("nav_input_t *")
        self._setpoint = Setpoint()
        self._event = ffi.new("wire_event_t *")
        cfg = _configuration(flight, self._world.spec.eeprom)
        lib.nav_init(self.nav, cfg)
        self.record.records += init_record(cfg)

    @property
    def state(self) -> MissionState:
        return MissionState(self.nav.mission.state)

    @property
    def time_s(self) -> float:
        return self._plant.time_s

    def command(self, cmd: MissionCmd) -> None:
        order = ffi.new("nav_command_t *")
        order.cmd = cmd
        goal = self._world.spec.demo_goal_m or (2.0, 1.0)
        order.goal_m.x, order.goal_m.y = goal
        self.record.records += command_record(order)
        lib.nav_command(self.nav, order)

    def tick(self) -> None:
        for _ in range(STEPS_PER_TICK):
            self._plant.step(self._setpoint, True)
        measure(self._plant, self._input)
        self.record.records += packed(self._input)
        wanted = lib.nav_step(self.nav, self._input)
        self.record.setpoints.append(setpoint_bytes(wanted))
        self.record.states.add(self.nav.mission.state)
        while lib.nav_take_event(self.nav, self._event):
            self.record.events.append(self._event.code)
        self._setpoint = steer(wanted)
        if self.record.ticks % HASH_EVERY_TICKS == 0:
            self.record.records += HASH_RECORD


def _configuration(flight: Flight, kept: Mapping[str, float]) -> CData:
    """Defaults, the room's area and the flight's choices."""
    cfg = ffi.new("nav_config_t *")
    lib.nav_config_default(cfg)
    for corner, suffix in ((cfg.area_min_m, "0"), (cfg.area_max_m, "1")):
        corner.x = kept.get(f"way.areaX{suffix}", corner.x)
        corner.y = kept.get(f"way.areaY{suffix}", corner.y)
    cfg.cell_m = kept.get("way.cell", cfg.cell_m)
    cfg.seed, cfg.planner, cfg.slam = flight.seed, flight.planner, flight.slam
    cfg.follower.yaw_mode = flight.yaw_mode
    return cfg


def measure(plant: Plant, given: CData) -> None:
    """Convert the firmware's variables as app_sensors.c does."""
    seen: Readings = plant.readings
    odometry = given.odometry
    odometry.time_ms = round(plant.time_s * 1000)
    odometry.pose.x_m, odometry.pose.y_m = seen.x_m, seen.y_m
    odometry.pose.yaw_rad = math.radians(seen.yaw_deg)
    odometry.height_m = seen.z_m
    odometry.roll_rad, odometry.pitch_rad = (
        math.radians(seen.roll_deg),
        math.radians(seen.pitch_deg),
    )
    given.velocity_mps.x, given.velocity_mps.y = seen.vx_mps, seen.vy_mps
    given.yaw_rate_rps = math.radians(seen.gyro_dps[2])
    for beam, range_mm in enumerate(seen.range_mm):
        given.range_m[beam] = range_mm / 1000 if 0 < range_mm < RANGE_NONE_MM // 4 else -1.0
    given.battery_v = seen.battery_v
    given.flags = READY | (0 if plant.on_floor else lib.NAV_IS_FLYING)
    given.flags |= lib.NAV_TUMBLED if plant.tumbled else 0


def steer(wanted: CData) -> Setpoint:
    """Convert the core's command as app_setpoint.c does."""
    if not wanted.motors:
        return Setpoint()
    return Setpoint(
        mode_x=Mode.VELOCITY,
        mode_y=Mode.VELOCITY,
        mode_z=Mode.ABSOLUTE,
        mode_yaw=Mode.VELOCITY,
        velocity_body=True,
        vx_mps=wanted.velocity_body_mps.x,
        vy_mps=wanted.velocity_body_mps.y,
        z_m=wanted.height_m,
        yaw_rate_dps=math.degrees(wanted.yaw_rate_rps),
    )


@cache
def record(flight: Flight) -> Recording:
    """Fly until the drone stands on the floor again, or the time is over."""
    loop = _Loop(flight)
    while loop.time_s < COMMAND_AT_S:
        loop.tick()
    loop.command(flight.task)
    loop.tick()
    due = [MissionCmd.RELOCALISE] * flight.lost + [MissionCmd.HOME] * flight.home
    while loop.time_s < flight.limit_s and (loop.state.airborne or loop.time_s < 2 * COMMAND_AT_S):
        loop.tick()
        if loop.state == MissionState.HOVER:
            loop.command(due.pop(0) if due else MissionCmd.LAND)
    loop.record.records += HASH_RECORD
    return loop.record


def arrived(recording: Recording) -> bool:
    """Whether it reached its goal, or explored everything that can be reached."""
    return bool({EventCode.ARRIVED, EventCode.EXPLORED} & set(recording.events))
