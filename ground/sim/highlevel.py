# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware's high-level commander: take-off, landing and go-to along smooth trajectories.

After crtp_commander_high_level.c and planner.c. Not simulated: spirals and uploaded trajectories,
which are answered with an error.
"""

import struct
from collections.abc import Callable
from enum import Enum
from functools import partial
from math import degrees, radians

from ground.sim.crtp import BadPacket, Errno, unpack
from ground.sim.model import Readings, Setpoint
from ground.sim.supervisor import Info
from ground.sim.trajectory import Motion, Straight, Trajectory, Vector, nearest_turn

_ALREADY = 1
"""Error for a take-off unless idle, and for a landing while landing."""

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
    """The planner; times are firmware time, poses are in the estimator's frame."""

    def __init__(self) -> None:
        self._state = State.IDLE
        self._group_mask = 0
        self._blocked = True
        self._trajectory: Trajectory | None = None
        self._last = Motion((0.0, 0.0, 0.0, 0.0))
        self._commands: dict[int, Callable[[bytes, float], int]] = {
            0: self._set_group_mask,
            1: partial(self._straight, State.FLYING),
            2: partial(self._straight, State.LANDING),
            3: self._stop,
            4: self._go_to,
            7: partial(self._turning, State.FLYING),
            8: partial(self._turning, State.LANDING),
            9: partial(self._with_velocity, State.FLYING),
            10: partial(self._with_velocity, State.LANDING),
            12: self._go_to_2,
        }

    def command(self, data: bytes, now_ms: int) -> int:
        """Take a packet of the high-level port; return the firmware's error number."""
        if not data:
            raise BadPacket("no command")
        handler = self._commands.get(data[0])
        return handler(data[1:], now_ms / 1000) if handler else Errno.ENOEXEC

    def block(self, blocked: bool) -> None:
        """Refuse every command and fly nothing while the motors may not run."""
        self._blocked = blocked
        if blocked:
            self.stop()

    def stop(self) -> None:
        """Stop planning, so that something else can fly, or nothing."""
        self._state = State.IDLE

    def tell_state(self, readings: Readings) -> None:
        """Start the next trajectory from this state instead of the last trajectory's."""
        self._last = Motion(
            (readings.x_m, readings.y_m, readings.z_m, radians(readings.yaw_deg)),
            (readings.vx_mps, readings.vy_mps, readings.vz_mps, 0.0),
        )

    def info(self, now_ms: int) -> Info:
        """The planner's bits of supervisor.info."""
        flying = Info.HIGH_LEVEL_FLYING if self._state is not State.IDLE else Info(0)
        return flying | (Info.HIGH_LEVEL_FINISHED if self._finished(now_ms / 1000) else Info(0))

    def setpoint(self, now_ms: int, readings: Readings) -> Setpoint:
        """The high-level commander's setpoint; motors off if it has nothing to do."""
        now_s = now_ms / 1000
        if self._state is State.LANDING and self._finished(now_s):
            self._state = State.IDLE
        if self._state is State.IDLE or self._trajectory is None:
            self.tell_state(readings)
            return Setpoint()
        self._last = self._trajectory.at(now_s)
        x_m, y_m, z_m, yaw_rad = self._last.position
        setpoint = Setpoint.at(x_m, y_m, z_m, degrees(yaw_rad))
        setpoint.vx_mps, setpoint.vy_mps, setpoint.vz_mps, yaw_rate_rps = self._last.velocity
        setpoint.yaw_rate_dps = degrees(yaw_rate_rps)
        return setpoint

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

    def _straight(self, state: State, data: bytes, now_s: float) -> int:
        mask, height_m, duration_s = unpack(_VERTICAL, data)
        return self._vertical(state, mask, height_m, 0.0, duration_s, now_s)

    def _turning(self, state: State, data: bytes, now_s: float) -> int:
        mask, height_m, yaw_rad, keep_yaw, duration_s = unpack(_VERTICAL_2, data)
        yaw_rad = self._last.position[3] if keep_yaw else yaw_rad
        return self._vertical(state, mask, height_m, yaw_rad, duration_s, now_s)

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
        """Rise or sink to a height at the present position."""
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
