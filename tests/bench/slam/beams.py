# SPDX-License-Identifier: GPL-3.0-or-later
"""What four rangers report: cones, noise, misses, false short returns, people in the way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ground.sim.ranger import DROPOUT, MAX_RANGE_M, MIN_RANGE_M, SENSOR_OFFSET_M, echo
from tests.bench.slam.rooms import Array

BEARINGS_RAD: Final = np.array([0.0, math.pi, math.pi / 2, -math.pi / 2])
NONE_M: Final = -1.0
PERSON_RADIUS_M: Final = 0.2
_RAYS: Final = 9
_NOISE_MIN_M: Final = 0.003
_REFLECTIVITY: Final = (0.5, 0.9)
_PERSON_REFLECTIVITY: Final = 0.6
_STEEPNESS: Final = 6.0
_CHUNK: Final = 512


@dataclass(frozen=True, slots=True)
class Sensor:
    """Properties of the rangers; noise is drawn from its range once per flight and beam."""

    cone_half_deg: float = 10.0
    noise_relative: tuple[float, float] = (0.01, 0.02)
    false_short: float = 0.003


def _to_walls(x: Array, y: Array, c: Array, s: Array, walls: Array) -> tuple[Array, Array, Array]:
    """For each ray: distance to its wall, the wall, and the cosine of incidence."""
    ax, ay = walls[:, 0] - x[:, None], walls[:, 1] - y[:, None]
    ex, ey = walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]
    cross = c[:, None] * ey - s[:, None] * ex
    cross = np.where(np.abs(cross) < 1e-9, 1e-9, cross)
    along = (ax * ey - ay * ex) / cross
    on_wall = (ax * s[:, None] - ay * c[:, None]) / cross
    along = np.where((along > 1e-6) & (on_wall >= 0.0) & (on_wall <= 1.0), along, np.inf)
    wall = along.argmin(axis=1)
    rows = np.arange(len(x))
    return along[rows, wall], wall, np.abs(cross[rows, wall]) / np.hypot(ex, ey)[wall]


def _to_person(x: Array, y: Array, c: Array, s: Array, person: Array) -> Array:
    """Distance along each ray to a disc at the person's place at that moment."""
    dx, dy = person[:, 0] - x, person[:, 1] - y
    ahead, aside = dx * c + dy * s, dy * c - dx * s
    reach = np.sqrt(np.maximum(PERSON_RADIUS_M**2 - aside**2, 0.0))
    met = (np.abs(aside) < PERSON_RADIUS_M) & (ahead > 0.0)
    return np.where(met, np.maximum(ahead - reach, MIN_RANGE_M), np.inf)


class Rangers:
    """Four beams in one room."""

    def __init__(self, sensor: Sensor, walls: Array, rng: np.random.Generator) -> None:
        self.sensor, self.walls, self.rng = sensor, walls, rng
        self.reflectivity = rng.uniform(*_REFLECTIVITY, len(walls))
        self.relative = rng.uniform(*sensor.noise_relative, len(BEARINGS_RAD))
        half = math.radians(sensor.cone_half_deg)
        self.off_rad = np.linspace(-half, half, _RAYS)
        self.weight = np.exp(-0.5 * (self.off_rad / (0.6 * half)) ** 2)
        self.weight /= self.weight.sum()
        returned = self.weight * np.cos(self.off_rad) ** 3
        self.stretch = float((returned / np.cos(self.off_rad)).sum() / returned.sum())

    def _cones(self, poses: Array, people: list[Array]) -> tuple[Array, Array]:
        """Nearest strong return of each beam at some poses, and its signal."""
        axis = (poses[:, 2:3] + BEARINGS_RAD).reshape(-1)
        angle = (axis[:, None] + self.off_rad).reshape(-1)
        c, s = np.cos(angle), np.sin(angle)

        def spread(values: Array) -> Array:
            return np.repeat(values, len(BEARINGS_RAD) * _RAYS, axis=0)

        x = spread(poses[:, 0]) + SENSOR_OFFSET_M * np.repeat(np.cos(axis), _RAYS)
        y = spread(poses[:, 1]) + SENSOR_OFFSET_M * np.repeat(np.sin(axis), _RAYS)
        distance, wall, incidence = _to_walls(x, y, c, s, self.walls)
        returned = self.reflectivity[wall] * incidence
        for person in people:
            nearer = _to_person(x, y, c, s, spread(person))
            returned = np.where(nearer < distance, _PERSON_REFLECTIVITY, returned)
            distance = np.minimum(nearer, distance)
        shape = (len(axis), _RAYS)
        far_m = np.maximum(distance, MIN_RANGE_M)
        strength = self.weight * (returned / far_m**2).reshape(shape)
        return echo(distance.reshape(shape), strength)

    def measure(self, poses: Array, people: list[Array]) -> Array:
        """Ranges at each pose, NONE_M without return; `people` gives a place per pose."""
        parts = [
            self._cones(poses[i : i + _CHUNK], [person[i : i + _CHUNK] for person in people])
            for i in range(0, len(poses), _CHUNK)
        ]
        shape = (len(poses), len(BEARINGS_RAD))
        range_m = np.concatenate([part[0] for part in parts]).reshape(shape) / self.stretch
        signal = np.concatenate([part[1] for part in parts]).reshape(shape)
        return self._report(range_m, signal)

    def _report(self, range_m: Array, signal: Array) -> Array:
        """Add noise, false short returns and misses; round to millimetres."""
        luck = self.rng.random((3, *range_m.shape))
        bounded_m = np.minimum(range_m, 2.0 * MAX_RANGE_M)
        noise_m = np.maximum(self.relative * bounded_m, _NOISE_MIN_M)
        noisy_m = bounded_m + noise_m * self.rng.standard_normal(range_m.shape)
        chance = (1.0 - DROPOUT) * signal**_STEEPNESS / (1.0 + signal**_STEEPNESS)
        short_m = MIN_RANGE_M + luck[2] * np.minimum(noisy_m, MAX_RANGE_M)
        noisy_m = np.where(luck[1] < self.sensor.false_short, short_m, noisy_m)
        seen = (luck[0] < chance) & (noisy_m <= MAX_RANGE_M)
        reported: Array = np.where(seen, np.maximum(noisy_m, MIN_RANGE_M).round(3), NONE_M)
        return reported
