# SPDX-License-Identifier: GPL-3.0-or-later
"""The body of a Crazyflie 2.1 with two decks: identified dynamics, floor contact, tumbling.

Figures: cf2x_L250, model so_rpy_rotor_drag, of drone-models 0.1.0 (Rath, Schuck, PyPI; identified
from flights with motion capture). Attitude follows its command as a second-order lag with a steady
gain of 1, since the integral part of the firmware's attitude PID removes the fit's gain error.
Yaw is counter-clockwise, pitch is positive nose up. z is 0 when the body stands on the floor.
Not modelled: ground effect, propeller wash near walls.
"""

import math
from typing import Final

import numpy as np

from ground.sim.controller import CONTROL_STEP_S, THRUST_MAX, Command
from ground.sim.noise import Noise, Wander

GRAVITY_MPS2: Final = 9.81
MASS_KG: Final = 0.0319
FORCE_MAX_N: Final = 4 * 0.12 * 0.98325003
THRUST_LAG_S: Final = 0.12116392
TILT_STIFFNESS: Final = 245.67
TILT_DAMPING: Final = 17.32
YAW_STIFFNESS: Final = 227.78
YAW_DAMPING: Final = 25.63
DRAG_XY: Final = 0.01471782 / MASS_KG
DRAG_Z: Final = 0.01277641 / MASS_KG
HOVER_THRUST: Final = MASS_KG * GRAVITY_MPS2 / FORCE_MAX_N * THRUST_MAX
FULL_FORCE_V: Final = 3.75

GUST_XY_MPS2: Final = 0.08
GUST_Z_MPS2: Final = 0.04
GUST_TAU_S: Final = 0.4

SUBSTEPS: Final = 2
FLIP_TILT_RAD: Final = math.radians(60.0)
BOUNCE: Final = 0.2
FLOOR_GRIP: Final = 0.8
REST_MPS: Final = 0.05
_FLIP_STIFFNESS: Final = 60.0
_FLIP_DAMPING: Final = 10.0


class Vehicle:
    """Pose and velocity of the body in the world frame; stepped every CONTROL_STEP_S."""

    def __init__(self, x_m: float, y_m: float, yaw_rad: float, rng: np.random.Generator) -> None:
        self.x_m, self.y_m, self.z_m = x_m, y_m, 0.0
        self.vx_mps = self.vy_mps = self.vz_mps = 0.0
        self.ax_mps2 = self.ay_mps2 = self.az_mps2 = 0.0
        self.roll_rad = self.pitch_rad = 0.0
        self.yaw_rad = yaw_rad
        self.roll_rps = self.pitch_rps = self.yaw_rps = 0.0
        self.force_n = 0.0
        self.floor_m = 0.0
        self.on_floor = True
        self.tumbled = False
        self.held = False
        noise = Noise(rng)
        self._gust_x = Wander(noise, GUST_XY_MPS2, GUST_TAU_S, CONTROL_STEP_S)
        self._gust_y = Wander(noise, GUST_XY_MPS2, GUST_TAU_S, CONTROL_STEP_S)
        self._gust_z = Wander(noise, GUST_Z_MPS2, GUST_TAU_S, CONTROL_STEP_S)

    def step(self, command: Command, yaw_error_rad: float, battery_v: float) -> None:
        """Follow the command; yaw_error_rad is commanded minus estimated yaw."""
        if self.held:
            return
        before = self.vx_mps, self.vy_mps, self.vz_mps
        fade = min(1.0, battery_v / FULL_FORCE_V) ** 2
        wanted_n = min(command.thrust / THRUST_MAX, fade) * FORCE_MAX_N
        if self.tumbled:
            wanted_n = 0.0
        gusts = self._gust_x.step(), self._gust_y.step(), self._gust_z.step()
        step_s = CONTROL_STEP_S / SUBSTEPS
        yaw_target_rad = self.yaw_rad + yaw_error_rad
        for _ in range(SUBSTEPS):
            self.force_n += (wanted_n - self.force_n) * step_s / THRUST_LAG_S
            self._turn(command, yaw_target_rad, step_s)
            if self._rests():
                continue
            self._move(gusts, step_s)
            if self.z_m <= self.floor_m:
                self._meet_floor()
            else:
                self.on_floor = False
        self.ax_mps2 = (self.vx_mps - before[0]) / CONTROL_STEP_S
        self.ay_mps2 = (self.vy_mps - before[1]) / CONTROL_STEP_S
        self.az_mps2 = (self.vz_mps - before[2]) / CONTROL_STEP_S

    def tumble(self) -> None:
        """Lose control for good: the body turns over, falls and stays on its back."""
        self.tumbled = True

    def hold(self, x_m: float, y_m: float, z_m: float) -> None:
        """Hold the body level at a place, as a hand would."""
        self.held, self.on_floor = True, False
        self.x_m, self.y_m, self.z_m = x_m, y_m, z_m
        self.vx_mps = self.vy_mps = self.vz_mps = 0.0
        self.ax_mps2 = self.ay_mps2 = self.az_mps2 = 0.0
        self.roll_rad = self.pitch_rad = 0.0
        self.roll_rps = self.pitch_rps = self.yaw_rps = 0.0

    def let_go(self, z_m: float) -> None:
        """Let go of the body at this height."""
        self.held = False
        self.z_m = z_m
        self.on_floor = z_m <= self.floor_m

    def _rests(self) -> bool:
        """Stop the body if it stands on the floor, too heavy for its lift and almost at rest."""
        slow = abs(self.vx_mps) + abs(self.vy_mps) + abs(self.vz_mps) < REST_MPS
        heavy = self.force_n < MASS_KG * GRAVITY_MPS2
        if not (self.on_floor and self.z_m == self.floor_m and heavy and slow):
            return False
        self.vx_mps = self.vy_mps = self.vz_mps = 0.0
        return True

    def _turn(self, command: Command, yaw_target_rad: float, step_s: float) -> None:
        if self.tumbled:
            over_rad = math.copysign(math.pi, self.roll_rad)
            self._lag(over_rad, 0.0, _FLIP_STIFFNESS, _FLIP_DAMPING, step_s)
        elif self.force_n > 0.05 * FORCE_MAX_N or not self.on_floor:
            powered = command.thrust > 0.0
            stiffness = TILT_STIFFNESS if powered else 0.0
            damping = TILT_DAMPING if powered else 1.0
            self._lag(command.roll_rad, command.pitch_rad, stiffness, damping, step_s)
            if powered:
                pull = YAW_STIFFNESS * (yaw_target_rad - self.yaw_rad)
                self.yaw_rps += (pull - YAW_DAMPING * self.yaw_rps) * step_s
        self.yaw_rad += self.yaw_rps * step_s

    def _lag(
        self, roll_rad: float, pitch_rad: float, stiffness: float, damping: float, step_s: float
    ) -> None:
        pull = stiffness * (roll_rad - self.roll_rad) - damping * self.roll_rps
        self.roll_rps += pull * step_s
        pull = stiffness * (pitch_rad - self.pitch_rad) - damping * self.pitch_rps
        self.pitch_rps += pull * step_s
        self.roll_rad += self.roll_rps * step_s
        self.pitch_rad += self.pitch_rps * step_s

    def _move(self, gusts: tuple[float, float, float], step_s: float) -> None:
        lift = self.force_n / MASS_KG
        sin_roll, cos_roll = math.sin(self.roll_rad), math.cos(self.roll_rad)
        forward = -lift * cos_roll * math.sin(self.pitch_rad)
        left = -lift * sin_roll
        up = lift * cos_roll * math.cos(self.pitch_rad)
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        self.vx_mps += (c * forward - s * left + gusts[0] - DRAG_XY * self.vx_mps) * step_s
        self.vy_mps += (s * forward + c * left + gusts[1] - DRAG_XY * self.vy_mps) * step_s
        self.vz_mps += (up - GRAVITY_MPS2 + gusts[2] - DRAG_Z * self.vz_mps) * step_s
        self.x_m += self.vx_mps * step_s
        self.y_m += self.vy_mps * step_s
        self.z_m += self.vz_mps * step_s

    def _meet_floor(self) -> None:
        """Land or bounce a little; a body that lands on its side turns over."""
        self.on_floor = True
        self.z_m = self.floor_m
        if self.vz_mps < 0.0:
            bounce_mps = -BOUNCE * self.vz_mps
            self.vz_mps = bounce_mps if bounce_mps > 0.1 else 0.0
        self.vx_mps *= FLOOR_GRIP
        self.vy_mps *= FLOOR_GRIP
        self.yaw_rps *= FLOOR_GRIP
        if not self.tumbled:
            if max(abs(self.roll_rad), abs(self.pitch_rad)) > FLIP_TILT_RAD:
                self.tumble()
            self.roll_rad *= FLOOR_GRIP
            self.pitch_rad *= FLOOR_GRIP
            self.roll_rps = self.pitch_rps = 0.0
