# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware's stock cascade: position and velocity PID, to attitude and thrust.

Source: position_controller_pid.c and controller_pid.c of bitcraze/crazyflie-firmware with the gains
of platform_defaults_cf2.h. It sees the estimate, never the truth. Attitude and rate loops are part
of the identified body, see vehicle.py. Not implemented: roll and pitch rate setpoints, which level.
"""

import math
from dataclasses import dataclass
from typing import Final

from ground.sim.model import Mode, Readings, Setpoint

CONTROL_STEP_S: Final = 0.01
TILT_MAX_DEG: Final = 20.0
TILT_MANUAL_MAX_DEG: Final = 50.0
SPEED_MAX_MPS: Final = 1.0
OVERHEAD: Final = 1.1
THRUST_BASE: Final = 36000.0
THRUST_MIN: Final = 20000.0
THRUST_MAX: Final = 65535.0
THRUST_PER_UNIT: Final = 1000.0

_ABSOLUTE, _VELOCITY, _OFF = int(Mode.ABSOLUTE), int(Mode.VELOCITY), int(Mode.OFF)


@dataclass(slots=True)
class Command:
    """Attitude and thrust for the body; thrust 0..THRUST_MAX, pitch is positive nose up."""

    roll_rad: float = 0.0
    pitch_rad: float = 0.0
    yaw_rad: float = 0.0
    thrust: float = 0.0


class Pid:
    """Proportional and integral part with a limited output."""

    __slots__ = ("_integral", "_ki", "_kp", "_limit")

    def __init__(self, kp: float, ki: float, limit: float) -> None:
        self._kp, self._ki, self._limit = kp, ki, limit
        self._integral = 0.0

    def update(self, error: float) -> float:
        self._integral += error * CONTROL_STEP_S
        return _clamp(self._kp * error + self._ki * self._integral, self._limit)

    def reset(self) -> None:
        self._integral = 0.0


class Controller:
    """From setpoint and estimate to attitude and thrust, once every CONTROL_STEP_S."""

    def __init__(self) -> None:
        speed = SPEED_MAX_MPS * OVERHEAD
        self._x, self._y = Pid(2.0, 0.0, speed), Pid(2.0, 0.0, speed)
        self._z = Pid(2.0, 0.5, speed)
        tilt = TILT_MAX_DEG * OVERHEAD
        self._vx, self._vy = Pid(25.0, 1.0, tilt), Pid(25.0, 1.0, tilt)
        self._vz = Pid(25.0, 15.0, THRUST_MAX / 2 / THRUST_PER_UNIT)
        self._yaw_rad = 0.0
        self._modes: tuple[int, ...] = ()

    def update(self, setpoint: Setpoint, estimate: Readings, armed: bool) -> Command:
        """Run the cascade; if not armed or without thrust, return motors off and reset all PIDs."""
        self._restart_if_modes_changed(setpoint)
        yaw_rad = math.radians(estimate.yaw_deg)
        self._step_yaw(setpoint)
        thrust = self._thrust(setpoint, estimate) if armed else 0.0
        if thrust <= 0.0:
            self._reset()
            self._yaw_rad = yaw_rad
            return Command(yaw_rad=yaw_rad)
        roll_deg, pitch_deg = self._tilt(setpoint, estimate, yaw_rad)
        return Command(math.radians(roll_deg), math.radians(pitch_deg), self._yaw_rad, thrust)

    def _restart_if_modes_changed(self, sp: Setpoint) -> None:
        modes = (sp.mode_x, sp.mode_y, sp.mode_z, sp.mode_roll, sp.mode_pitch, sp.mode_yaw)
        if modes != self._modes:
            self._modes = modes
            self._reset()

    def _reset(self) -> None:
        for pid in (self._x, self._y, self._z, self._vx, self._vy, self._vz):
            pid.reset()

    def _step_yaw(self, setpoint: Setpoint) -> None:
        if setpoint.mode_yaw == _VELOCITY:
            self._yaw_rad += math.radians(setpoint.yaw_rate_dps) * CONTROL_STEP_S
        elif setpoint.mode_yaw == _ABSOLUTE:
            self._yaw_rad = math.radians(setpoint.yaw_deg)

    def _thrust(self, setpoint: Setpoint, estimate: Readings) -> float:
        if setpoint.mode_z == _OFF:
            return min(max(setpoint.thrust, 0.0), THRUST_MAX)
        climb_mps = setpoint.vz_mps
        if setpoint.mode_z == _ABSOLUTE:
            climb_mps = self._z.update(setpoint.z_m - estimate.z_m)
        raw = self._vz.update(climb_mps - estimate.vz_mps)
        return min(max(raw * THRUST_PER_UNIT + THRUST_BASE, THRUST_MIN), THRUST_MAX)

    def _tilt(self, sp: Setpoint, estimate: Readings, yaw_rad: float) -> tuple[float, float]:
        """Wanted roll and pitch in degrees; horizontal control runs in yaw-aligned axes."""
        if sp.mode_x == _OFF or sp.mode_y == _OFF:
            return _manual(sp.mode_roll, sp.roll_deg), _manual(sp.mode_pitch, sp.pitch_deg)
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        vx, vy = sp.vx_mps, sp.vy_mps
        if not sp.velocity_body:
            vx, vy = c * vx + s * vy, c * vy - s * vx
        dx, dy = sp.x_m - estimate.x_m, sp.y_m - estimate.y_m
        if sp.mode_x == _ABSOLUTE:
            vx = self._x.update(c * dx + s * dy)
        if sp.mode_y == _ABSOLUTE:
            vy = self._y.update(c * dy - s * dx)
        ex = vx - (c * estimate.vx_mps + s * estimate.vy_mps)
        ey = vy - (c * estimate.vy_mps - s * estimate.vx_mps)
        pitch_deg = _clamp(-self._vx.update(ex), TILT_MAX_DEG)
        roll_deg = _clamp(-self._vy.update(ey), TILT_MAX_DEG)
        return roll_deg, pitch_deg


def _manual(mode: int, angle_deg: float) -> float:
    return _clamp(angle_deg, TILT_MANUAL_MAX_DEG) if mode == _ABSOLUTE else 0.0


def _clamp(value: float, limit: float) -> float:
    return -limit if value < -limit else limit if value > limit else value
