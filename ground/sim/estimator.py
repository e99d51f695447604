# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware's estimate from flow, gyro and height ranger: a pose that drifts.

This models the errors of the result; it is not a Kalman filter. Flow has a scale error that differs
per flight and wanders, and a slow velocity bias; the gyro has a bias; the height is the distance to
whatever is below. A profile sets their size (profiles.py); they grow on poor floor texture and
without flow. On the ground nothing drifts, but the yaw creeps back to its initial value, as the
firmware lets it.

External measurements correct it with gains from covariances that grow as the firmware's do
(kalman_core.c with a Flow deck at 0.4 m: 2.8e-4 m2/s and 1e-5 rad2/s). With flow alone, the
position's covariance stays at its upper limit, so the first position is believed as it is.
"""

import math
from typing import Final

import numpy as np

from ground.sim.controller import CONTROL_STEP_S
from ground.sim.model import Measured, PositionMeasured
from ground.sim.noise import Noise, Wander
from ground.sim.profiles import Profile
from ground.sim.vehicle import GRAVITY_MPS2, Vehicle

FLOW_MIN_QUALITY: Final = 0.1
HEIGHT_GAIN: Final = 0.12
CLIMB_GAIN: Final = 0.4
CLIMB_ERROR_MPS2: Final = 0.05
"""Upward accelerometer error; it matters while no ranger looks down."""
VARIANCE_START_M2: Final = 0.1
VARIANCE_FLOOR_M2: Final = 1e-4
VARIANCE_TAU_S: Final = 0.35
TILT_RAD2: Final = 1.2e-5
TILT_GROWTH: Final = 1e-5
"""Growth of the tilt variance; without flow, gravity turns tilt errors into velocity errors."""
VARIANCE_MAX_M2: Final = 100.0
PLACE_START_M2: Final = 100.0
YAW_START_RAD2: Final = 1e-4
YAW_GROWTH: Final = 1e-5
FLOW_VARIANCE: Final = 5.9e-4
"""Flow's velocity variance over good floor, as in kalman_core.c; the log shows the floor value."""
COUPLING_S: Final = 0.48
"""How long a velocity error lasts until flow removes it; couples velocity to position."""
HEIGHT_VARIANCE_M2: Final = 1.7e-6
HEADING_WAY_M: Final = 1.0
"""Positions this far apart give a heading."""
YAW_REVERSION: Final = 0.001
_RECOVER_S: Final = 0.3
_STEP_S: Final = CONTROL_STEP_S


class Estimator:
    """Estimated pose in the frame set by the last reset; stepped every CONTROL_STEP_S."""

    def __init__(self, profile: Profile, rng: np.random.Generator) -> None:
        noise = Noise(rng)
        scale = rng.uniform(*profile.scale)
        if profile.scale_either_sign:
            scale *= rng.choice((-1.0, 1.0))
        skew = profile.anisotropy * noise.normal()
        self._noise = noise
        self._walk_m = profile.walk_m_per_root_s * math.sqrt(_STEP_S)
        self._jitter_mps = profile.velocity_noise_mps
        self._scale_x, self._scale_y = 1.0 + scale + skew, 1.0 + scale - skew
        self._wander_x = Wander(noise, profile.scale_wander, 12.0, _STEP_S)
        self._wander_y = Wander(noise, profile.scale_wander, 12.0, _STEP_S)
        self._bias_x = Wander(noise, profile.velocity_bias_mps, 10.0, _STEP_S)
        self._bias_y = Wander(noise, profile.velocity_bias_mps, 10.0, _STEP_S)
        bias_dps = float(rng.uniform(*profile.yaw_bias_dps) * rng.choice((-1.0, 1.0)))
        self._yaw_bias_rps = math.radians(bias_dps)
        self._yaw_wander = Wander(noise, 0.25 * abs(self._yaw_bias_rps), 60.0, _STEP_S)
        self._yaw_walk = math.radians(profile.yaw_walk_dps) * math.sqrt(_STEP_S)
        self._yaw_scale = 1.0 + profile.gyro_scale * noise.normal()
        tilt_rad = math.radians(profile.tilt_error_deg)
        self._roll_error = Wander(noise, tilt_rad, 20.0, _STEP_S)
        self._pitch_error = Wander(noise, tilt_rad, 20.0, _STEP_S)
        wrong = CLIMB_ERROR_MPS2 if profile.tilt_error_deg else 0.0
        self._climb_error_mps2 = math.copysign(wrong, bias_dps)
        self._lost_x_mps = self._lost_y_mps = self._lost_s = 0.0
        self._last: tuple[float, float, float] | None = None
        self.holds_yaw = False
        """Set in flight, or when a deck asks for it: the yaw does not creep back on the ground."""
        self.height_lost = False
        """Set while no ranger looks down."""
        self.runaway_mps2 = 0.0
        """Acceleration that drives the velocity away; flow is ignored meanwhile."""
        self.roll_error_rad = self.pitch_error_rad = 0.0
        self.reset(0.0, 0.0, 0.0, 0.0)

    def reset(self, x_m: float, y_m: float, z_m: float, yaw_rad: float) -> None:
        """Restart at this pose, with the initial variances."""
        self.x_m, self.y_m, self.z_m, self.yaw_rad = x_m, y_m, z_m, yaw_rad
        self.vx_mps = self.vy_mps = self.vz_mps = 0.0
        self.variance_m2 = VARIANCE_START_M2
        self.place_m2 = PLACE_START_M2
        self.yaw_rad2 = YAW_START_RAD2
        self._start_yaw_rad = yaw_rad
        self._coupling = 0.0
        self._pull_x_mps = self._pull_y_mps = 0.0
        self._way = (0.0, 0.0)
        self._way_from: tuple[float, float] | None = None

    def jump(self, x_m: float, y_m: float) -> None:
        """Shift the estimated position at once."""
        self.x_m += x_m
        self.y_m += y_m

    def carried(self) -> None:
        """Ignore the body's latest motion, which the sensors could not notice."""
        self._last = None

    def take(self, measured: Measured) -> None:
        """Correct the estimate by an external measurement, with a gain from the covariances."""
        if not isinstance(measured, PositionMeasured):
            self._take_yaw(measured.error_rad, measured.sd_rad)
            return
        variance = self.place_m2 + measured.sd_m**2
        gain, pull = self.place_m2 / variance, self._coupling / variance
        off_x_m, off_y_m = measured.x_m - self.x_m, measured.y_m - self.y_m
        self.x_m += gain * off_x_m
        self.y_m += gain * off_y_m
        self._pull_x_mps += pull * off_x_m
        self._pull_y_mps += pull * off_y_m
        self.place_m2 *= 1.0 - gain
        self._coupling *= 1.0 - gain
        height_gain = HEIGHT_VARIANCE_M2 / (HEIGHT_VARIANCE_M2 + measured.sd_m**2)
        self.z_m += height_gain * (measured.z_m - self.z_m)
        self._take_way(measured)

    def _take_yaw(self, error_rad: float, sd_rad: float) -> None:
        gain = self.yaw_rad2 / (self.yaw_rad2 + sd_rad**2)
        self.yaw_rad -= gain * error_rad
        self.yaw_rad2 *= 1.0 - gain

    def _take_way(self, measured: PositionMeasured) -> None:
        """Compare the direction travelled by positions and by flow, and correct the heading."""
        start, way_m = self._way_from, math.hypot(*self._way)
        if start is not None and way_m < HEADING_WAY_M:
            return
        if start is not None:
            true_rad = math.atan2(measured.y_m - start[1], measured.x_m - start[0])
            error_rad = math.remainder(math.atan2(self._way[1], self._way[0]) - true_rad, math.tau)
            self._take_yaw(error_rad, math.sqrt(2.0) * measured.sd_m / way_m + 0.02)
        self._way_from, self._way = (measured.x_m, measured.y_m), (0.0, 0.0)

    def step(self, body: Vehicle, height_m: float | None, flow_quality: float) -> None:
        """Follow the body's motion; height_m is a new height measurement, if any."""
        blind = flow_quality < FLOW_MIN_QUALITY or self.runaway_mps2 > 0.0
        lost = blind and not body.on_floor
        self._step_variance(lost, max(flow_quality, FLOW_MIN_QUALITY))
        self._step_place()
        self._step_height(body, height_m)
        moved = self._moved(body)
        if body.on_floor:
            self._rest(body, moved)
            return
        self.roll_error_rad = self._roll_error.step()
        self.pitch_error_rad = self._pitch_error.step()
        drift_rps = self._yaw_bias_rps + self._yaw_wander.step()
        self.yaw_rad += moved[2] * self._yaw_scale + drift_rps * _STEP_S
        self.yaw_rad += self._yaw_walk * self._noise.normal()
        self._step_lost(lost)
        self._step_plane(body, moved, 1.0 / max(flow_quality, FLOW_MIN_QUALITY))

    def _moved(self, body: Vehicle) -> tuple[float, float, float]:
        """True displacement (world axes) and rotation of the body since the last step."""
        now = (body.x_m, body.y_m, body.yaw_rad)
        before = self._last or now
        self._last = now
        return now[0] - before[0], now[1] - before[1], now[2] - before[2]

    def _rest(self, body: Vehicle, moved: tuple[float, float, float]) -> None:
        """On the ground nothing drifts but the yaw."""
        self.yaw_rad += moved[2]
        if not self.holds_yaw:
            back_rad = math.remainder(self._start_yaw_rad - self.yaw_rad, math.tau)
            self.yaw_rad += YAW_REVERSION * back_rad
        turn_rad = self.yaw_rad - body.yaw_rad
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        self.vx_mps = c * body.vx_mps - s * body.vy_mps
        self.vy_mps = s * body.vx_mps + c * body.vy_mps
        self.x_m += c * moved[0] - s * moved[1]
        self.y_m += s * moved[0] + c * moved[1]
        self._lost_x_mps = self._lost_y_mps = 0.0

    def _step_variance(self, lost: bool, quality: float) -> None:
        self._lost_s = self._lost_s + _STEP_S if lost else 0.0
        if lost:
            tilt_rad2 = 2.0 * TILT_RAD2 * self._lost_s + TILT_GROWTH * self._lost_s**2
            rate = GRAVITY_MPS2**2 * tilt_rad2 + 2.0 * self.runaway_mps2**2 * self._lost_s
            self.variance_m2 = min(self.variance_m2 + rate * _STEP_S, VARIANCE_MAX_M2)
        else:
            settled = VARIANCE_FLOOR_M2 / (quality * quality)
            self.variance_m2 += (settled - self.variance_m2) * _STEP_S / VARIANCE_TAU_S

    def _step_place(self) -> None:
        settled = COUPLING_S * FLOW_VARIANCE * self.variance_m2 / VARIANCE_FLOOR_M2
        self._coupling += (settled - self._coupling) * _STEP_S / COUPLING_S
        self.place_m2 = min(self.place_m2 + self._coupling * _STEP_S, PLACE_START_M2)
        self.yaw_rad2 += YAW_GROWTH * _STEP_S
        self._pull_x_mps -= self._pull_x_mps * _STEP_S / COUPLING_S
        self._pull_y_mps -= self._pull_y_mps * _STEP_S / COUPLING_S

    def _step_height(self, body: Vehicle, height_m: float | None) -> None:
        """Integrate the accelerometer to a climb; pull the height to what the ranger measures."""
        pull = self._climb_error_mps2 if self.height_lost else 2.0 * (body.vz_mps - self.vz_mps)
        self.vz_mps += (body.az_mps2 + pull) * _STEP_S
        self.z_m += self.vz_mps * _STEP_S
        if height_m is not None:
            gap_m = height_m - self.z_m
            self.z_m += HEIGHT_GAIN * gap_m
            self.vz_mps += CLIMB_GAIN * gap_m

    def _step_lost(self, lost: bool) -> None:
        """Without flow, integrate the tilt error, which looks like acceleration."""
        if lost:
            felt_mps2 = self.pitch_error_rad * GRAVITY_MPS2 + self.runaway_mps2
            self._lost_x_mps += felt_mps2 * _STEP_S
            self._lost_y_mps += self.roll_error_rad * GRAVITY_MPS2 * _STEP_S
        else:
            self._lost_x_mps -= self._lost_x_mps * _STEP_S / _RECOVER_S
            self._lost_y_mps -= self._lost_y_mps * _STEP_S / _RECOVER_S

    def _step_plane(self, body: Vehicle, moved: tuple[float, float, float], worse: float) -> None:
        """Velocity as flow measures it and the displacement that it adds up to, with errors."""
        c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
        scale_x = self._scale_x + self._wander_x.step() * worse
        scale_y = self._scale_y + self._wander_y.step() * worse
        off_x_mps = self._bias_x.step() * worse + self._lost_x_mps
        off_y_mps = self._bias_y.step() * worse + self._lost_y_mps
        vx = (c * body.vx_mps + s * body.vy_mps) * scale_x + off_x_mps
        vy = (c * body.vy_mps - s * body.vx_mps) * scale_y + off_y_mps
        normal, walk_m = self._noise.normal, self._walk_m * worse
        dx = (c * moved[0] + s * moved[1]) * scale_x + off_x_mps * _STEP_S + walk_m * normal()
        dy = (c * moved[1] - s * moved[0]) * scale_y + off_y_mps * _STEP_S + walk_m * normal()
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        self.vx_mps = c * vx - s * vy + self._pull_x_mps + self._jitter_mps * normal()
        self.vy_mps = s * vx + c * vy + self._pull_y_mps + self._jitter_mps * normal()
        dx, dy = c * dx - s * dy, s * dx + c * dy
        self.x_m += dx + self._pull_x_mps * _STEP_S
        self.y_m += dy + self._pull_y_mps * _STEP_S
        self._way = self._way[0] + dx, self._way[1] + dy
