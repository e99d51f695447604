# SPDX-License-Identifier: GPL-3.0-or-later
"""The plan view of all obstacles of a world: where they are at a time, how far away they are."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ground.sim.worldspec import Motion, Obstacle, Point

Array = NDArray[np.float64]
CARRIED_MPS = 3.0


def position_m(obstacle: Obstacle, moving_s: float) -> Point:
    """Centre of the obstacle when it has been on its way that long; before that, negative."""
    motion = obstacle.motion
    if motion is None or moving_s <= 0.0:
        return obstacle.center_m
    stops = _stops(obstacle, motion)
    left_s = moving_s
    if motion.loop:
        round_m = sum(math.dist(a, b) for a, b in pairwise(stops))
        left_s %= round_m / motion.speed_mps + motion.pause_s * (len(stops) - 1)
    for a, b in pairwise(stops):
        leg_s = math.dist(a, b) / motion.speed_mps
        if left_s < leg_s:
            part = left_s / leg_s
            return a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])
        left_s -= leg_s
        if left_s < motion.pause_s:
            return b
        left_s -= motion.pause_s
    return stops[-1]


def _start_s(motion: Motion | None) -> float:
    return math.inf if motion is None or motion.trigger else motion.start_s


def _stops(obstacle: Obstacle, motion: Motion) -> tuple[Point, ...]:
    way = (obstacle.center_m, *motion.path_m)
    return (*way, obstacle.center_m) if motion.loop else way


class Footprints:
    """Rectangles and discs as arrays, one row an obstacle; moves with time.

    changes counts every appearing and vanishing, so that who remembers a distance knows when to
    forget it.
    """

    def __init__(self, obstacles: tuple[Obstacle, ...], before: "Footprints | None" = None) -> None:
        """Or go on from what was before, with other obstacles at the end."""
        self.obstacles = obstacles
        self.center_m = np.array([o.center_m for o in obstacles], float).reshape(-1, 2)
        self.velocity_mps = np.zeros_like(self.center_m)
        self.present = np.ones(len(obstacles), bool)
        self.bottom_m = np.array([o.bottom_m for o in obstacles])
        self.top_m = np.array([o.top_m for o in obstacles])
        self.changes = 0
        self.fastest_mps = max((o.motion.speed_mps for o in obstacles if o.motion), default=0.0)
        self._radius_m = np.array([o.radius_m for o in obstacles])
        half = np.array([o.half_m for o in obstacles], float).reshape(-1, 2)
        self._half_m = np.where(self._radius_m[:, None] > 0, 0.0, half)
        yaw = np.array([o.yaw_rad for o in obstacles])
        self._cos, self._sin = np.cos(yaw), np.sin(yaw)
        self._dynamic = [i for i, o in enumerate(obstacles) if o.changes]
        self._time_s = 0.0
        self._starts_s = [_start_s(o.motion) for o in obstacles]
        if before is not None:
            known = before._starts_s[: len(obstacles)]
            self._starts_s[: len(known)] = known
            self.changes = before.changes + 1
            self._time_s = before._time_s
        self.move_to(self._time_s, None)

    def move_to(self, time_s: float, drone_m: Point | None) -> list[int]:
        """Put everything where it is at that time; return the rows that may have changed."""
        elapsed_s = time_s - self._time_s
        self._time_s = time_s
        for i in self._dynamic:
            obstacle = self.obstacles[i]
            present = obstacle.appears_s <= time_s < obstacle.vanishes_s
            if present != self.present[i]:
                self.present[i] = present
                self.changes += 1
            if obstacle.motion:
                center = position_m(obstacle, time_s - self._start(i, obstacle.motion, drone_m))
                if elapsed_s > 0:
                    self.velocity_mps[i] = (center - self.center_m[i]) / elapsed_s
                self.center_m[i] = center
        return self._dynamic

    def carry(self, row: int, at_m: tuple[float, float, float], velocity_mps: Point) -> None:
        """Something else moves this row: where its foot is, and how fast it goes."""
        height_m = self.top_m[row] - self.bottom_m[row]
        self.center_m[row], self.velocity_mps[row] = at_m[:2], velocity_mps
        self.bottom_m[row], self.top_m[row] = at_m[2], at_m[2] + height_m
        self.fastest_mps = max(self.fastest_mps, CARRIED_MPS)

    def triggered_by(self, other: "Footprints") -> None:
        """What waits for the drone of another world moves here as well."""
        for row, start_s in enumerate(other._starts_s[: len(self._starts_s)]):
            self._starts_s[row] = min(self._starts_s[row], start_s)

    def _start(self, row: int, motion: Motion, drone_m: Point | None) -> float:
        """When this row starts to move; inf as long as it waits for the drone."""
        trigger, waits = motion.trigger, math.isinf(self._starts_s[row])
        if trigger is not None and drone_m is not None and waits:
            near = math.dist(trigger.center_m, drone_m) <= trigger.radius_m
            self._starts_s[row] = self._time_s + motion.start_s if near else math.inf
        return self._starts_s[row]

    def signed_m(self, x_m: float, y_m: float) -> Array:
        """Plan distance of a point to each outline, negative inside; inf where absent."""
        dx = x_m - self.center_m[:, 0]
        dy = y_m - self.center_m[:, 1]
        u = np.abs(self._cos * dx + self._sin * dy) - self._half_m[:, 0]
        v = np.abs(self._cos * dy - self._sin * dx) - self._half_m[:, 1]
        outside = np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0))
        signed = outside + np.minimum(np.maximum(u, v), 0.0) - self._radius_m
        return np.where(self.present, signed, np.inf)

    def normal(self, row: int, x_m: float, y_m: float) -> Point:
        """Unit direction from outline row towards the point, pointing out of it."""
        step_m = 1e-4
        d = [
            self.signed_m(x, y)[row]
            for x, y in (
                (x_m + step_m, y_m),
                (x_m - step_m, y_m),
                (x_m, y_m + step_m),
                (x_m, y_m - step_m),
            )
        ]
        nx, ny = float(d[0] - d[1]), float(d[2] - d[3])
        length = math.hypot(nx, ny)
        return (nx / length, ny / length) if length > 0 else (1.0, 0.0)

    def surface_distance_m(self, points_m: Array, height_m: float) -> Array:
        """Distance of each point (N x 2) to the nearest outline that exists at that height."""
        rows = self.present & (self.bottom_m < height_m) & (height_m < self.top_m)
        nearest = np.full(len(points_m), np.inf)
        for row in np.flatnonzero(rows):
            np.minimum(nearest, np.abs(self._signed_to(row, points_m)), out=nearest)
        return nearest

    def gap_m(self, points_m: Array, low_m: float, high_m: float) -> Array:
        """Distance of each point (N x 2) to what stands between two heights, negative inside."""
        rows = self.present & (self.bottom_m < high_m) & (low_m < self.top_m)
        nearest = np.full(len(points_m), np.inf)
        for row in np.flatnonzero(rows):
            np.minimum(nearest, self._signed_to(row, points_m), out=nearest)
        return nearest

    def _signed_to(self, row: np.intp, points_m: Array) -> Array:
        """Distance of each point to one outline, negative inside."""
        dx, dy = (points_m - self.center_m[row]).T
        u = np.abs(self._cos[row] * dx + self._sin[row] * dy) - self._half_m[row, 0]
        v = np.abs(self._cos[row] * dy - self._sin[row] * dx) - self._half_m[row, 1]
        outside = np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0))
        signed: Array = outside + np.minimum(np.maximum(u, v), 0.0) - self._radius_m[row]
        return signed
