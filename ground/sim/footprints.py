# SPDX-License-Identifier: GPL-3.0-or-later
"""Plan view of a world's obstacles: where they are at a time, and distances to them."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ground.sim.worldspec import Motion, Obstacle, Point

Array = NDArray[np.float64]
CARRIED_MPS = 3.0


def position_m(obstacle: Obstacle, moving_s: float) -> Point:
    """Centre of an obstacle that has been moving for moving_s; negative: it has not started yet."""
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
    """Rectangles and discs as arrays, one row per obstacle; they move with time.

    `changes` counts appearing and vanishing obstacles, so that a remembered distance can be
    recognised as outdated.
    """

    def __init__(self, obstacles: tuple[Obstacle, ...], before: "Footprints | None" = None) -> None:
        """Make rows for obstacles; with `before`, keep its time and motions (new ones are last)."""
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
        """Move obstacles to where they are at that time; return the rows that may have changed."""
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
        """Set position and velocity of a row that something else moves (another drone)."""
        height_m = self.top_m[row] - self.bottom_m[row]
        self.center_m[row], self.velocity_mps[row] = at_m[:2], velocity_mps
        self.bottom_m[row], self.top_m[row] = at_m[2], at_m[2] + height_m
        self.fastest_mps = max(self.fastest_mps, CARRIED_MPS)

    def triggered_by(self, other: "Footprints") -> None:
        """Start motions here that the drone of another world has triggered."""
        for row, start_s in enumerate(other._starts_s[: len(self._starts_s)]):
            self._starts_s[row] = min(self._starts_s[row], start_s)

    def _start(self, row: int, motion: Motion, drone_m: Point | None) -> float:
        """When this row's motion starts; inf while it waits for the drone."""
        trigger, waits = motion.trigger, math.isinf(self._starts_s[row])
        if trigger is not None and drone_m is not None and waits:
            near = math.dist(trigger.center_m, drone_m) <= trigger.radius_m
            self._starts_s[row] = self._time_s + motion.start_s if near else math.inf
        return self._starts_s[row]

    def signed_m(self, x_m: float, y_m: float) -> Array:
        """Plan distance of a point to each outline, negative inside; inf for absent obstacles."""
        return np.where(self.present, self._signed(x_m, y_m), np.inf)

    def normal(self, row: int, x_m: float, y_m: float) -> Point:
        """Unit vector that points out of the outline of a row, towards the point."""
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
        return self._nearest(points_m, height_m, height_m, np.abs)

    def gap_m(self, points_m: Array, low_m: float, high_m: float) -> Array:
        """Distance of each point (N x 2) to obstacles between two heights, negative inside."""
        return self._nearest(points_m, low_m, high_m, np.positive)

    def _nearest(self, points_m: Array, low_m: float, high_m: float, counts: np.ufunc) -> Array:
        """Least value of `counts` of the distances to all obstacles between two heights."""
        rows = self.present & (self.bottom_m < high_m) & (low_m < self.top_m)
        nearest = np.full(len(points_m), np.inf)
        x_m, y_m = points_m.T
        for row in np.flatnonzero(rows):
            np.minimum(nearest, counts(self._signed(x_m, y_m, row)), out=nearest)
        return nearest

    def _signed(
        self, x_m: float | Array, y_m: float | Array, rows: slice | np.intp = slice(None)
    ) -> Array:
        """Distances of a point to the outlines, or of points to one of them; negative inside."""
        dx, dy = x_m - self.center_m[rows, 0], y_m - self.center_m[rows, 1]
        u = np.abs(self._cos[rows] * dx + self._sin[rows] * dy) - self._half_m[rows, 0]
        v = np.abs(self._cos[rows] * dy - self._sin[rows] * dx) - self._half_m[rows, 1]
        outside = np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0))
        signed: Array = outside + np.minimum(np.maximum(u, v), 0.0) - self._radius_m[rows]
        return signed
