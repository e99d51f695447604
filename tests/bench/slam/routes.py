# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths through a room over some minutes: of a drone that looks at all of it, or of people."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from tests.bench.slam.rooms import Array, Room, gap_m, inside_block

TICK_S: Final = 0.02
_LATTICE_M: Final = 0.25
_CLEAR_M: Final = 0.36
_ACCELERATION_MPS2: Final = 0.5
_STEPS = ((1, 0), (0, 1), (1, 1), (1, -1))


class Lattice:
    """Places of a room that are clear of walls, and the paths between neighbours."""

    def __init__(self, room: Room, clear_m: float = _CLEAR_M) -> None:
        self.room, self.clear_m = room, clear_m
        axes = [np.arange(clear_m, size - clear_m, _LATTICE_M) for size in room.size_m]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=2).reshape(-1, 2)
        free = (gap_m(room.walls, points) > clear_m) & ~inside_block(room.blocks, points)
        number = np.full((len(axes[0]), len(axes[1])), -1)
        number.reshape(-1)[free] = np.arange(free.sum())
        ways = self._ways(number, len(points[free]))
        _, part = connected_components(ways, directed=False)
        kept = part == np.bincount(part).argmax()
        self.points: Array = points[free][kept]
        self.ways = ways[kept][:, kept]

    @staticmethod
    def _ways(number: Array, count: int) -> csr_matrix:
        a, b, cost = [], [], []
        wide, deep = number.shape
        for dx, dy in _STEPS:
            here = number[: wide - dx, max(0, -dy) : deep - max(0, dy)]
            there = number[dx:, max(0, dy) : deep - max(0, -dy)]
            both = (here >= 0) & (there >= 0)
            a.append(here[both])
            b.append(there[both])
            cost.append(np.full(both.sum(), _LATTICE_M * math.hypot(dx, dy)))
        entries = (np.concatenate(cost), (np.concatenate(a), np.concatenate(b)))
        return coo_matrix(entries, shape=(count, count)).tocsr()

    def clear(self, a: Array, b: Array) -> bool:
        """Whether the straight path from a to b stays clear of walls."""
        steps = max(2, int(np.hypot(*(b - a)) / 0.05))
        between = a + np.linspace(0.0, 1.0, steps)[:, None] * (b - a)
        return bool((gap_m(self.room.walls, between) > self.clear_m - 0.01).all())

    def far(self, here: int) -> tuple[Array, NDArray[np.int32]]:
        """Distance from here to every place, and the previous step on each path."""
        distance, before = dijkstra(
            self.ways, directed=False, indices=here, return_predecessors=True
        )
        return distance, before

    def way(self, before: NDArray[np.int32], goal: int) -> list[Array]:
        """Corners of the path to the goal, pulled taut."""
        chain = [goal]
        while before[chain[-1]] >= 0:
            chain.append(int(before[chain[-1]]))
        corners = [self.points[i] for i in reversed(chain)]
        pulled, at = [corners[0]], 0
        while at < len(corners) - 1:
            ahead = min(len(corners) - 1, at + 24)
            while ahead > at + 1 and not self.clear(corners[at], corners[ahead]):
                ahead -= 1
            pulled.append(corners[ahead])
            at = ahead
        return pulled[1:]


@dataclass
class Traveller:
    """Collects a pose per tick."""

    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    poses: list[tuple[float, float, float]] = field(default_factory=list)

    def hover(self, seconds: float) -> None:
        self.poses += [(self.x_m, self.y_m, self.yaw_rad)] * round(seconds / TICK_S)

    def turn(self, angle_rad: float, rate_dps: float) -> None:
        """Turn, with a smooth start and end."""
        ticks = max(1, round(abs(angle_rad) / math.radians(rate_dps) / TICK_S))
        share = np.arange(1, ticks + 1) / ticks
        turned = self.yaw_rad + angle_rad * share * share * (3.0 - 2.0 * share)
        self.poses += [(self.x_m, self.y_m, float(yaw)) for yaw in turned]
        self.yaw_rad += angle_rad

    def face(self, to: Array, rate_dps: float) -> None:
        wanted = math.atan2(to[1] - self.y_m, to[0] - self.x_m)
        off = math.remainder(wanted - self.yaw_rad, math.tau)
        if abs(off) > math.radians(5.0):
            self.turn(off, rate_dps)

    def go(self, to: Array) -> None:
        """Fly straight, from rest to rest."""
        dx, dy = float(to[0]) - self.x_m, float(to[1]) - self.y_m
        length = math.hypot(dx, dy)
        if length < 1e-6:
            return
        done, speed = 0.0, 0.0
        while done < length - 1e-3:
            braking = math.sqrt(2.0 * _ACCELERATION_MPS2 * (length - done)) + 0.02
            speed = min(self.speed_mps, speed + _ACCELERATION_MPS2 * TICK_S, braking)
            done = min(length, done + speed * TICK_S)
            share = done / length
            self.poses.append((self.x_m + share * dx, self.y_m + share * dy, self.yaw_rad))
        self.x_m, self.y_m = float(to[0]), float(to[1])


def wobble(ticks: int, sigma: float, tau_s: float, rng: np.random.Generator) -> Array:
    """The motion that remains of gusts and control: an Ornstein-Uhlenbeck process."""
    keep = math.exp(-TICK_S / tau_s)
    kicks = rng.standard_normal(ticks) * sigma * math.sqrt(1.0 - keep * keep)
    wobble: Array = lfilter([1.0], [1.0, -keep], kicks)
    return wobble


def drone_route(room: Room, seconds: float, rng: np.random.Generator) -> Array:
    """Poses (x, y, yaw) per tick: to unseen places, nearest first, then again."""
    lattice = Lattice(room)
    count = len(lattice.points)
    facing = bool(rng.random() < 0.5)
    here = int(rng.integers(count))
    yaw = rng.uniform(-math.pi, math.pi) if facing else rng.uniform(-0.35, 0.35)
    drone = Traveller(*lattice.points[here], yaw, rng.uniform(0.3, 0.5))
    drone.hover(1.0)
    if rng.random() < 0.7:
        drone.turn(math.copysign(math.tau, rng.random() - 0.5), 50.0)
    fresh = np.ones(count, dtype=bool)
    while len(drone.poses) * TICK_S < seconds:
        distance, before = lattice.far(here)
        fresh &= np.hypot(*(lattice.points - lattice.points[here]).T) > 0.55
        if not fresh.any():
            fresh[:] = distance > 0.55
        if rng.random() < 0.8:
            here = int(np.where(fresh, distance + rng.uniform(0.0, 1.0, count), np.inf).argmin())
        else:
            here = int(rng.integers(count))
        for corner in lattice.way(before, here):
            if facing:
                drone.face(corner, 70.0)
            drone.go(corner)
        if rng.random() < 0.15:
            angle = math.pi / 2 if rng.random() < 0.6 else math.tau
            drone.turn(math.copysign(angle, rng.random() - 0.5), 50.0)
    poses = np.array(drone.poses[: round(seconds / TICK_S)])
    for column, (sigma, tau_s) in enumerate(((0.015, 0.8), (0.015, 0.8), (math.radians(1), 0.6))):
        poses[:, column] += wobble(len(poses), sigma, tau_s, rng)
    return poses


def walker_route(room: Room, ticks: int, drone: Array, rng: np.random.Generator) -> Array:
    """Places (x, y) per tick of a person who walks about, and waits while the drone is near."""
    lattice = Lattice(room, 0.3)
    here = int(np.hypot(*(lattice.points - drone[0, :2]).T).argmax())
    walker = Traveller(*lattice.points[here], 0.0, rng.uniform(0.5, 1.0))
    while len(walker.poses) < ticks:
        _, before = lattice.far(here)
        here = int(rng.integers(len(lattice.points)))
        for corner in lattice.way(before, here):
            walker.go(corner)
        walker.hover(rng.exponential(4.0))
    planned = np.array(walker.poses)[:, :2]
    taken, at = np.empty((ticks, 2)), 0
    for tick in range(ticks):
        if np.hypot(*(planned[at + 1] - drone[tick, :2])) > 0.7:
            at += 1
        taken[tick] = planned[at]
    return taken
