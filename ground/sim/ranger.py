# SPDX-License-Identifier: GPL-3.0-or-later
"""VL53L1x rangers: cones of rays; the nearest strong return wins, weak ones are missed.

A ray returns reflectivity * cos(incidence) / distance^2, weighted by the receiver's sensitivity
across the cone. A target of 88 % reflectivity that fills the cone at 4 m is seen half of the time,
which puts one of 17 % at 1.8 m (datasheet: 4 m and 1.7 m).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ground.sim.footprints import Array
from ground.sim.model import RANGE_NONE_MM, Ranges
from ground.sim.vehicle import Vehicle
from ground.sim.world import World

MIN_RANGE_M: Final = 0.04
MAX_RANGE_M: Final = 4.0
BEAMS: Final = ("front", "back", "left", "right", "up")
SENSOR_OFFSET_M: Final = 0.016
"""Distance of each sensor from the body's centre line, along its beam."""
DECK_HEIGHT_M: Final = 0.04
BELLY_HEIGHT_M: Final = 0.015
"""Height of the downward ranger above the floor when the drone stands."""
SKEW_S: Final = (-0.004, -0.002, 0.002, 0.004, 0.0)
"""Read-out time of each beam within a set: the driver reads front, back, up, left, right."""
NOISE_RELATIVE: Final = (0.01, 0.02)
NOISE_MIN_M: Final = 0.003
DROPOUT: Final = 0.005
FALSE_SHORT: Final = 0.003
"""Share of ranges that are false: uniform between the minimum and the true range."""

_FIELD_DEG: Final = (-8.5, -3.0, 3.0, 8.5)
"""The datasheet's 27 degrees are the diagonal of a square field with sides of 19 degrees."""
_DOWN_DEG: Final = (-6.0, 0.0, 6.0)
_SENSITIVITY_DEG: Final = 9.0
_CLUSTER_M: Final = 0.4
"""Returns closer together than this merge into one."""
_STRONG_PART: Final = 0.2
_FULL_SIGNAL: Final = 0.88 / MAX_RANGE_M**2
_STEEPNESS: Final = 6.0
_AXES: Final = ((1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0), (0, -1.0, 0), (0, 0, 1.0))


@dataclass(frozen=True, slots=True)
class Cone:
    """Unit vectors about +x (N x 3) with weights that sum to 1."""

    directions: Array
    weights: Array
    stretch: float
    """Factor by which a wall square to the axis seems too far; the sensor calibrates it away."""


def make_cone(offsets_deg: tuple[float, ...] = _FIELD_DEG) -> Cone:
    """Make a square grid of rays, at each of these angles up and across."""
    tangents = [math.tan(math.radians(off)) for off in offsets_deg]
    rays = np.array([(1.0, across, up) for up in tangents for across in tangents])
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    off_axis = np.arccos(rays[:, 0]) / math.radians(_SENSITIVITY_DEG)
    weight = np.exp(-0.5 * off_axis**2)
    weight /= weight.sum()
    returned = weight * rays[:, 0] ** 3
    return Cone(rays, weight, float(np.sum(returned / rays[:, 0]) / np.sum(returned)))


def echo(distance_m: Array, strength: Array) -> tuple[Array, Array]:
    """Distance and signal of each beam's nearest strong return; at signal 1 half are detected.

    Both arguments are beams x rays; a beam without any return gets inf and 0.
    """
    rows = np.arange(len(distance_m))[:, None]
    order = distance_m.argsort(axis=1)
    gathered = strength[rows, order].cumsum(axis=1)
    first = (gathered >= _STRONG_PART * gathered[:, -1:]).argmax(axis=1)[:, None]
    nearest = distance_m[rows, order[rows, first]]
    near = (distance_m < nearest + _CLUSTER_M) & (strength > 0.0)
    part = np.where(near, strength, 0.0)
    total = part.sum(axis=1)
    weighted = (part * np.where(near, distance_m, 0.0)).sum(axis=1)
    mean = weighted / np.maximum(total, 1e-12)
    return np.where(total > 0.0, mean, np.inf), total / _FULL_SIGNAL


def rotation(roll_rad: float, pitch_rad: float, yaw_rad: float) -> tuple[float, ...]:
    """Rotation matrix from body to world, row by row; pitch is positive nose up."""
    cr, sr = math.cos(roll_rad), math.sin(roll_rad)
    cp, sp = math.cos(pitch_rad), -math.sin(pitch_rad)
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    return (
        *(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        *(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        *(-sp, cp * sr, cp * cr),
    )


class MultiRanger:
    """The Multi-ranger deck: five cones fixed to the body; measure() gives one published set."""

    def __init__(
        self, world: World, rng: np.random.Generator, false_short: float = FALSE_SHORT
    ) -> None:
        self._world, self._rng = world, rng
        self._false_short = false_short
        self._cone = make_cone()
        self._relative = rng.uniform(*NOISE_RELATIVE, size=len(BEAMS))
        self._body_rays = np.stack([_about(axis, self._cone.directions) for axis in _AXES])

    def measure(self, body: Vehicle) -> Ranges:
        """Range of each of BEAMS in millimetres, RANGE_NONE_MM without return."""
        turns = np.array(
            [
                rotation(
                    body.roll_rad + body.roll_rps * skew_s,
                    body.pitch_rad + body.pitch_rps * skew_s,
                    body.yaw_rad + body.yaw_rps * skew_s,
                )
                for skew_s in SKEW_S
            ]
        ).reshape(-1, 3, 3)
        rays = np.matmul(self._body_rays, turns.transpose(0, 2, 1))
        origin = (body.x_m, body.y_m, body.z_m + DECK_HEIGHT_M)
        seen = self._world.cast(origin, rays.reshape(-1, 3), MAX_RANGE_M + 0.5)
        distance = seen.distance_m.reshape(len(BEAMS), -1)
        far_m = np.maximum(distance, MIN_RANGE_M)
        strength = self._cone.weights * (
            (seen.reflectivity * seen.cos_incidence).reshape(distance.shape) / far_m**2
        )
        range_m, signal = echo(distance, strength)
        approach_m = self._approach_m(body, turns)
        return self._publish(range_m / self._cone.stretch - approach_m, signal)

    def _approach_m(self, body: Vehicle, turns: Array) -> Array:
        """How much nearer each target is, because of the sensor's place and later read-out."""
        velocity = np.array((body.vx_mps, body.vy_mps, body.vz_mps))
        axes = np.einsum("bij,bj->bi", turns, np.array(_AXES))
        approach: Array = SENSOR_OFFSET_M + axes @ velocity * np.array(SKEW_S)
        return approach

    def _publish(self, range_m: Array, signal: Array) -> Ranges:
        """Add noise, misses and false short returns; round to millimetres."""
        luck = self._rng.random((3, len(BEAMS)))
        noise_m = np.maximum(self._relative * np.minimum(range_m, MAX_RANGE_M), NOISE_MIN_M)
        noisy_m = range_m + noise_m * self._rng.standard_normal(len(BEAMS))
        chance = (1.0 - DROPOUT) * signal**_STEEPNESS / (1.0 + signal**_STEEPNESS)
        short_m = MIN_RANGE_M + luck[2] * np.minimum(noisy_m, MAX_RANGE_M)
        noisy_m = np.where(luck[1] < self._false_short, short_m, noisy_m)
        valid = (luck[0] < chance) & (noisy_m <= MAX_RANGE_M)
        front, back, left, right, up = (
            round(1000.0 * max(float(r), MIN_RANGE_M)) if ok else RANGE_NONE_MM
            for r, ok in zip(noisy_m, valid, strict=True)
        )
        return front, back, left, right, up


class HeightRanger:
    """The flow deck's downward ranger, with fewer rays than the Multi-ranger's beams."""

    def __init__(self, world: World, rng: np.random.Generator) -> None:
        self._world, self._rng = world, rng
        self._cone = make_cone(_DOWN_DEG)
        self._body_rays = _about((0.0, 0.0, -1.0), self._cone.directions)

    def measure_m(self, body: Vehicle) -> float | None:
        """Height of the body's underside above what is below, along the body axis, or None."""
        turn = np.array(rotation(body.roll_rad, body.pitch_rad, body.yaw_rad)).reshape(3, 3)
        origin = (body.x_m, body.y_m, body.z_m + DECK_HEIGHT_M)
        seen = self._world.cast(origin, self._body_rays @ turn.T, MAX_RANGE_M + 0.5)
        strength = self._cone.weights * seen.cos_incidence / np.maximum(seen.distance_m, 0.01) ** 2
        range_m, _ = echo(seen.distance_m[None, :], strength[None, :])
        below_m = float(range_m[0]) / self._cone.stretch - DECK_HEIGHT_M + BELLY_HEIGHT_M
        if not below_m < MAX_RANGE_M:
            return None
        noise_m = 0.002 + 0.004 * below_m
        return max(0.0, below_m + noise_m * float(self._rng.standard_normal()))


def _about(axis: tuple[float, float, float], directions: Array) -> Array:
    """Turn a cone about +x to point along this axis."""
    x, y, z = axis
    if z:
        return np.stack([-directions[:, 2] * z, directions[:, 1], directions[:, 0] * z], axis=1)
    return np.stack(
        [
            x * directions[:, 0] - y * directions[:, 1],
            y * directions[:, 0] + x * directions[:, 1],
            directions[:, 2],
        ],
        axis=1,
    )
