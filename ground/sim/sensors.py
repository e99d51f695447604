# SPDX-License-Identifier: GPL-3.0-or-later
"""All sensors of the body, each with its own rate and delay; they write one Readings."""

import math
from typing import Final

import numpy as np

from ground.sim.battery import Battery
from ground.sim.broken import Broken, spoil
from ground.sim.controller import CONTROL_STEP_S, Command
from ground.sim.estimator import HEIGHT_VARIANCE_M2, Estimator
from ground.sim.model import RANGE_NONE_MM, Ranges, Readings
from ground.sim.noise import Noise
from ground.sim.positioning import Positioning
from ground.sim.profiles import PROFILES
from ground.sim.ranger import FALSE_SHORT, HeightRanger, MultiRanger
from ground.sim.vehicle import GRAVITY_MPS2, Vehicle
from ground.sim.world import World

RANGE_PERIOD_STEPS: Final = 10
"""The Multi-ranger task publishes every 100 ms ..."""
RANGE_AGE_STEPS: Final = (7, 9)
"""... what was measured this many steps before (random between both), without the skew."""
HEIGHT_PERIOD_S: Final = 0.025
FLOW_COUNTS_PER_RAD: Final = 10.0 * 30.0 / 0.71674
GYRO_NOISE_DPS: Final = 0.1
INFO_FLYING: Final = 1 << 4
TILT_VARIANCE_RAD2: Final = 1.2e-5


class Sensors:
    """Sensors of one body in one world; stepped every CONTROL_STEP_S, after the body."""

    def __init__(
        self,
        world: World,
        profile: str,
        positioning: Positioning,
        rng: np.random.Generator,
        false_short: float = FALSE_SHORT,
    ) -> None:
        parts = rng.spawn(5)
        self.readings = Readings()
        self.broken = Broken()
        self.estimator = Estimator(PROFILES[profile], parts[0])
        self._positioning = positioning
        self._world = world
        self._ranger = MultiRanger(world, parts[1], false_short)
        self._height = HeightRanger(world, parts[2])
        self._noise = Noise(parts[3])
        self._rng = parts[4]
        self._step = int(self._rng.integers(RANGE_PERIOD_STEPS))
        self._measure_at = 0
        self._pending: Ranges | None = None
        self._height_due_s = 0.0
        self._quality = 0.0

    def step(self, body: Vehicle, command: Command, battery: Battery) -> None:
        """Update the readings."""
        self._step_ranges(body)
        height_m = self._step_height(body)
        self._quality = self._flow_quality(body)
        flying = bool(self.readings.supervisor_info & INFO_FLYING)
        self.estimator.holds_yaw = flying or self._positioning.deck_holds_yaw
        self.estimator.runaway_mps2 = self.broken.runaway_mps2
        self.estimator.step(body, height_m, self._quality)
        lost = self.broken.positioning
        self._positioning.step(body, self.estimator, self.readings, lost)
        self._write_estimate()
        self._write_inertial(body)
        self._write_flow(body)
        self._write_power(command, battery)

    def _step_ranges(self, body: Vehicle) -> None:
        """Publish the set of this period, and choose when to measure the next one."""
        phase = self._step % RANGE_PERIOD_STEPS
        self._step += 1
        if phase == 0:
            if self._pending is not None:
                before = self.readings.range_mm
                self.readings.range_mm = spoil(self._pending, before, self.broken, self._rng)
            first, last = RANGE_AGE_STEPS
            self._measure_at = RANGE_PERIOD_STEPS - int(self._rng.integers(first, last + 1))
        elif phase == self._measure_at:
            self._pending = self._ranger.measure(body)

    def _step_height(self, body: Vehicle) -> float | None:
        self._height_due_s -= CONTROL_STEP_S
        if self._height_due_s > 0.0:
            return None
        self._height_due_s += HEIGHT_PERIOD_S
        self.estimator.height_lost = self.broken.height
        if self.broken.height:
            return None
        slant_m = self._height.measure_m(body)
        if slant_m is None:
            self.readings.zrange_mm = RANGE_NONE_MM
            return None
        slant_m = max(0.0, slant_m - self.broken.step_m)
        self.readings.zrange_mm = round(1000.0 * slant_m)
        return slant_m * math.cos(body.roll_rad) * math.cos(body.pitch_rad)

    def _flow_quality(self, body: Vehicle) -> float:
        if self.broken.flow or body.tumbled:
            return 0.0
        return self._world.floor_quality(body.x_m, body.y_m)

    def _write_estimate(self) -> None:
        readings, estimate = self.readings, self.estimator
        readings.x_m, readings.y_m, readings.z_m = estimate.x_m, estimate.y_m, estimate.z_m
        readings.vx_mps, readings.vy_mps = estimate.vx_mps, estimate.vy_mps
        readings.vz_mps = estimate.vz_mps
        readings.yaw_deg = math.degrees(math.remainder(estimate.yaw_rad, math.tau))
        readings.var_velocity_m2ps2 = (estimate.variance_m2,) * 3
        readings.var_position_m2 = (estimate.place_m2, estimate.place_m2, HEIGHT_VARIANCE_M2)
        readings.var_attitude_rad2 = (TILT_VARIANCE_RAD2, TILT_VARIANCE_RAD2, estimate.yaw_rad2)

    def _write_inertial(self, body: Vehicle) -> None:
        readings, estimate, normal = self.readings, self.estimator, self._noise.normal
        turn_rad = estimate.yaw_rad - body.yaw_rad
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        readings.ax_g = (c * body.ax_mps2 - s * body.ay_mps2) / GRAVITY_MPS2
        readings.ay_g = (s * body.ax_mps2 + c * body.ay_mps2) / GRAVITY_MPS2
        readings.az_g = body.az_mps2 / GRAVITY_MPS2
        roll_rad = body.roll_rad + estimate.roll_error_rad
        readings.roll_deg = math.degrees(math.remainder(roll_rad, math.tau))
        readings.pitch_deg = math.degrees(body.pitch_rad + estimate.pitch_error_rad)
        readings.gyro_dps = (
            math.degrees(body.roll_rps) + GYRO_NOISE_DPS * normal(),
            -math.degrees(body.pitch_rps) + GYRO_NOISE_DPS * normal(),
            math.degrees(body.yaw_rps) + GYRO_NOISE_DPS * normal(),
        )

    def _write_flow(self, body: Vehicle) -> None:
        """Raw motion of the flow sensor, in tenths of a pixel per step."""
        readings = self.readings
        c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
        scale = FLOW_COUNTS_PER_RAD * CONTROL_STEP_S if self._quality > 0.0 else 0.0
        height_m = max(body.z_m - body.floor_m, 0.1)
        forward = (c * body.vx_mps + s * body.vy_mps) / height_m + body.pitch_rps
        left = (c * body.vy_mps - s * body.vx_mps) / height_m + body.roll_rps
        readings.motion_dx, readings.motion_dy = round(scale * forward), round(scale * left)
        near = min(1.0, 1.5 / max(height_m, 1.5))
        readings.motion_quality = round(100.0 * self._quality * near)

    def _write_power(self, command: Command, battery: Battery) -> None:
        readings = self.readings
        readings.battery_v = battery.voltage_v
        readings.battery_percent = battery.percent
        readings.battery_state = battery.state
        readings.motor_thrust = command.thrust
        readings.motor_pwm = (round(command.thrust),) * 4
