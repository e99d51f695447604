# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware's high-level commander: take off, land and go to by smooth trajectories.

After crtp_commander_high_level.c and planner.c. Not simulated: spirals and uploaded trajectories,
which are answered with an error.
"""

import struct
from collections.abc import Callable
from enum import Enum
from math import degrees, radians

from ground.sim.crtp import BadPacket, Errno, unpack
from ground.sim.model import Mode, Readings, Setpoint
from ground.sim.supervisor import Info
from ground.sim.trajectory import Motion, Straight, Trajectory, Vector, nearest_turn

_ALREADY = 1
"""What the planner answers to a take-off while not idle, or to landing while landing."""

_MASK = struct.Struct("<B")
_VERTICAL = struct.Struct("<Bff")
_VERTICAL_2 = struct.Struct("<Bff?f")
_VERTICAL_WITH_VELOCITY = struct.Struct("<Bf?f?f")
_GO_TO = struct.Struct("<BB5f")
_GO_TO_2 = struct.Struct("<BBB5f")


class State(Enum):
    """What the planner is doing."""

    IDLE = "idle"
    FLYING = "flying"
    LANDING = "landing"


class HighLevel:
    """One planner; time is firmware time, poses are in the estimator's frame."""

    def __init__(self) -> None:
        self._state = State.IDLE
        self._group_mask = 0
        self._blocked = True
        self._trajectory: Trajectory | None = None
        self._last = Motion((0.0, 0.0, 0.0, 0.0))
        self._commands: dict[int, Callable[[bytes, float], int]] = {
            0: self._set_group_mask,
            1: self._take_off,
            2: self._land,
            3: self._stop,
            4: self._go_to,
            7: self._take_off_2,
            8: self._land_2,
            9: self._take_off_with_velocity,
            10: self._land_with_velocity,
            12: self._go_to_2,
        }

    def command(self, data: bytes, now_ms: int) -> int:
        """Take one packet of the high-level port; the result is the firmware's error number."""
        if not data:
            raise BadPacket("no command")
        handler = self._commands.get(data[0])
        return handler(data[1:], now_ms / 1000) if handler else Errno.ENOEXEC

    def block(self, blocked: bool) -> None:
        """While the motors may not run every command is refused, and nothing is flown."""
        self._blocked = blocked
        if blocked:
            self.stop()

    def stop(self) -> None:
        """Let somebody else fly, or nobody."""
        self._state = State.IDLE

    def tell_state(self, readings: Readings) -> None:
        """Plan from here next, not from where the last trajectory was."""
        self._last = Motion(
            (readings.x_m, readings.y_m, readings.z_m, radians(readings.yaw_deg)),
            (readings.vx_mps, readings.vy_mps, readings.vz_mps, 0.0),
        )

    def info(self, now_ms: int) -> Info:
        """The planner's bits of supervisor.info."""
        flying = Info.HIGH_LEVEL_FLYING if self._state is not State.IDLE else Info(0)
        return flying | (Info.HIGH_LEVEL_FINISHED if self._finished(now_ms / 1000) else Info(0))

    def setpoint(self, now_ms: int, readings: Readings) -> Setpoint:
        """What the high-level commander wants now; with nothing to do, motors off."""
        now_s = now_ms / 1000
        if self._state is State.LANDING and self._finished(now_s):
            self._state = State.IDLE
        if self._state is State.IDLE or self._trajectory is None:
            self.tell_state(readings)
            return Setpoint()
        self._last = self._trajectory.at(now_s)
        x_m, y_m, z_m, yaw_rad = self._last.position
        vx_mps, vy_mps, vz_mps, yaw_rate_rps = self._last.velocity
        return Setpoint(
            mode_x=Mode.ABSOLUTE,
            mode_y=Mode.ABSOLUTE,
            mode_z=Mode.ABSOLUTE,
            mode_yaw=Mode.ABSOLUTE,
            x_m=x_m,
            y_m=y_m,
            z_m=z_m,
            vx_mps=vx_mps,
            vy_mps=vy_mps,
            vz_mps=vz_mps,
            yaw_deg=degrees(yaw_rad),
            yaw_rate_dps=degrees(yaw_rate_rps),
        )

    def _finished(self, now_s: float) -> bool:
        return self._trajectory is None or self._trajectory.finished(now_s)

    def _in_group(self, mask: int) -> bool:
        return mask == 0 or bool(mask & self._group_mask)

    def _set_group_mask(self, data: bytes, now_s: float) -> int:
        (self._group_mask,) = unpack(_MASK, data)
        return Errno.OK

    def _stop(self, data: bytes, now_s: float) -> int:
        (mask,) = unpack(_MASK, data)
        if self._in_group(mask):
            self.stop()
        return Errno.OK

    def _take_off(self, data: bytes, now_s: float) -> int:
        mask, height_m, duration_s = unpack(_VERTICAL, data)
        return self._vertical(State.FLYING, mask, height_m, 0.0, duration_s, now_s)

    def _land(self, data: bytes, now_s: float) -> int:
        mask, height_m, duration_s = unpack(_VERTICAL, data)
        return self._vertical(State.LANDING, mask, height_m, 0.0, duration_s, now_s)

    def _take_off_2(self, data: bytes, now_s: float) -> int:
        mask, height_m, yaw_rad, keep_yaw, duration_s = unpack(_VERTICAL_2, data)
        yaw_rad = self._last.position[3] if keep_yaw else yaw_rad
        return self._vertical(State.FLYING, mask, height_m, yaw_rad, duration_s, now_s)

    def _land_2(self, data: bytes, now_s: float) -> int:
        mask, height_m, yaw_rad, keep_yaw, duration_s = unpack(_VERTICAL_2, data)
        yaw_rad = self._last.position[3] if keep_yaw else yaw_rad
        return self._vertical(State.LANDING, mask, height_m, yaw_rad, duration_s, now_s)

    def _take_off_with_velocity(self, data: bytes, now_s: float) -> int:
        return self._with_velocity(State.FLYING, data, now_s)

    def _land_with_velocity(self, data: bytes, now_s: float) -> int:
        return self._with_velocity(State.LANDING, data, now_s)

    def _with_velocity(self, state: State, data: bytes, now_s: float) -> int:
        mask, height_m, relative, yaw_rad, keep_yaw, speed_mps = unpack(
            _VERTICAL_WITH_VELOCITY, data
        )
        here_m = self._last.position[2]
        if relative:
            height_m = here_m + height_m if state is State.FLYING else here_m - height_m
        if keep_yaw:
            yaw_rad = self._last.position[3]
        if speed_mps <= 0:
            speed_mps = 0.5
        duration_s = abs(height_m - here_m) / speed_mps
        return self._vertical(state, mask, height_m, yaw_rad, duration_s, now_s)

    def _vertical(
        self,
        state: State,
        mask: int,
        height_m: float,
        yaw_rad: float,
        duration_s: float,
        now_s: float,
    ) -> int:
        """Rise or sink at this place to a height."""
        if not self._in_group(mask):
            return Errno.OK
        if self._blocked:
            return Errno.EBUSY
        free = State.IDLE if state is State.FLYING else State.FLYING
        if self._state not in (State.IDLE, free):
            return _ALREADY
        x_m, y_m, _, here_rad = self._last.position
        goal = (x_m, y_m, height_m, nearest_turn(here_rad, yaw_rad))
        return self._plan(state, Trajectory, Motion(self._last.position), goal, duration_s, now_s)

    def _go_to(self, data: bytes, now_s: float) -> int:
        mask, relative, *goal, duration_s = unpack(_GO_TO, data)
        return self._fly_to(mask, relative, Trajectory, goal, duration_s, now_s)

    def _go_to_2(self, data: bytes, now_s: float) -> int:
        mask, relative, linear, *goal, duration_s = unpack(_GO_TO_2, data)
        shape = Straight if linear else Trajectory
        return self._fly_to(mask, relative, shape, goal, duration_s, now_s)

    def _fly_to(
        self,
        mask: int,
        relative: int,
        shape: type[Trajectory],
        goal: list[float],
        duration_s: float,
        now_s: float,
    ) -> int:
        if not self._in_group(mask):
            return Errno.OK
        if self._blocked:
            return Errno.EBUSY
        x_m, y_m, z_m, yaw_rad = goal
        here = self._last.position
        if relative:
            x_m, y_m, z_m, yaw_rad = here[0] + x_m, here[1] + y_m, here[2] + z_m, here[3] + yaw_rad
        there = (x_m, y_m, z_m, nearest_turn(here[3], yaw_rad))
        return self._plan(State.FLYING, shape, self._last, there, duration_s, now_s)

    def _plan(
        self,
        state: State,
        shape: type[Trajectory],
        begin: Motion,
        goal: Vector,
        duration_s: float,
        now_s: float,
    ) -> int:
        if duration_s <= 0:
            return Errno.EINVAL
        self._trajectory = shape(begin, goal, now_s, duration_s)
        self._state = state
        return Errno.OK
