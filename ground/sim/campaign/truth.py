# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth about a world: clearance, connected regions, shortest paths."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ground.sim.campaign.layout import Rect
from ground.sim.footprints import Array, Footprints
from ground.sim.worldspec import Obstacle, Point

STEP_M: Final = 0.05
BODY_M: Final = (0.25, 0.6)
"""Heights at which the drone may fly; anything between them blocks it."""
SOLID_M: Final = (0.03, 1.5)
"""Heights that include low things and table tops, standing on the floor or above it."""
_SIGHT_M: Final = 0.02

Bits = NDArray[np.bool_]
Cell = tuple[int, int]
_MOVES: Final = tuple(
    (i, j, math.hypot(i, j)) for i in range(-2, 3) for j in range(-2, 3) if math.gcd(i, j) == 1
)


class TrueMap:
    """A lattice of places over a floor plan, and the clearance at each."""

    def __init__(self, obstacles: tuple[Obstacle, ...], outline: Rect) -> None:
        self._low_m = (outline.x0 + STEP_M / 2, outline.y0 + STEP_M / 2)
        self.shape = nx, ny = tuple(int(side // STEP_M) for side in outline.size_m)
        x, y = np.meshgrid(np.arange(nx, dtype=float), np.arange(ny, dtype=float), indexing="ij")
        self.points_m: Array = np.stack([x, y], axis=-1) * STEP_M + np.array(self._low_m)
        flat = self.points_m.reshape(-1, 2)
        footprints = Footprints(obstacles)
        self.body_gap_m: Array = footprints.gap_m(flat, *BODY_M).reshape(nx, ny)
        """Distance of each place to what blocks flight; negative inside."""
        self.solid_gap_m: Array = footprints.gap_m(flat, *SOLID_M).reshape(nx, ny)
        """Distance of each place to anything within SOLID_M."""

    def place(self, cell: Sequence[int] | NDArray[np.int64]) -> Point:
        """World point of a lattice place."""
        x, y = self.points_m[int(cell[0]), int(cell[1])]
        return float(x), float(y)

    def cell(self, point_m: Point) -> Cell:
        """The lattice place nearest to a point within the plan."""
        i, j = (round((point_m[k] - self._low_m[k]) / STEP_M) for k in (0, 1))
        return min(max(i, 0), self.shape[0] - 1), min(max(j, 0), self.shape[1] - 1)

    def within(self, rect: Rect) -> Bits:
        """The places in a rectangle."""
        x, y = self.points_m[..., 0], self.points_m[..., 1]
        inside: Bits = (rect.x0 < x) & (x < rect.x1) & (rect.y0 < y) & (y < rect.y1)
        return inside

    def regions(self, free: Bits) -> list[Bits]:
        """The connected parts of the free places, largest first."""
        left, parts = free.copy(), []
        while left.any():
            i, j = np.argwhere(left)[0]
            part = flood(left, (int(i), int(j)))
            left &= ~part
            parts.append(part)
        return sorted(parts, key=lambda part: -int(part.sum()))

    def way(self, start_m: Point, goal_m: Point, gap_m: float) -> list[Point]:
        """The shortest path with this clearance, except at its ends; empty if there is none.

        A* over 16 directions, then pulled taut.
        """
        free = self.body_gap_m > gap_m
        start, goal = self.cell(start_m), self.cell(goal_m)
        cells = _search(free, start, goal)
        if not cells:
            return []
        way = [start_m, *(self.place(cell) for cell in cells[1:-1]), goal_m]
        for _ in range(3):
            way = self._pulled(free, _denser(way))
        return way

    def _pulled(self, free: Bits, way: list[Point]) -> list[Point]:
        """Drop all points between two that see each other."""
        taut, at = [way[0]], 0
        while at < len(way) - 1:
            ahead = len(way) - 1
            while ahead > at + 1 and not self._sees(free, way[at], way[ahead]):
                ahead = at + 1 + (ahead - at - 1) // 2 if ahead - at > 24 else ahead - 1
            at = ahead
            taut.append(way[at])
        return taut

    def _sees(self, free: Bits, a: Point, b: Point) -> bool:
        count = 2 + int(math.dist(a, b) / _SIGHT_M)
        points = np.linspace(a, b, count)
        i, j = np.rint((points - self._low_m) / STEP_M).astype(int).T
        return bool(free[i.clip(0, self.shape[0] - 1), j.clip(0, self.shape[1] - 1)].all())


def flood(free: Bits, start: Cell) -> Bits:
    """The free places connected to the start by steps to the 4 neighbours."""
    seen = np.zeros_like(free)
    seen[start] = free[start]
    count = 0
    while (now := int(seen.sum())) > count:
        count = now
        for _ in range(8):
            wider = seen.copy()
            wider[1:] |= seen[:-1]
            wider[:-1] |= seen[1:]
            wider[:, 1:] |= seen[:, :-1]
            wider[:, :-1] |= seen[:, 1:]
            seen = wider & free
    return seen


def length_m(way: Sequence[Point]) -> float:
    """Length of a path; infinite for an empty one."""
    return sum(math.dist(a, b) for a, b in pairwise(way)) if way else math.inf


def _denser(way: list[Point]) -> list[Point]:
    parts = [way[:1]]
    for a, b in pairwise(way):
        count = 1 + int(math.dist(a, b) / (2 * STEP_M))
        parts.append([tuple(p) for p in np.linspace(a, b, count + 1)[1:].tolist()])
    return [point for part in parts for point in part]


def _search(free: Bits, start: Cell, goal: Cell) -> list[Cell]:
    """A* search; both ends count as free."""
    blocked = (~np.pad(free, 2)).tolist()
    (si, sj), (gi, gj) = ((i + 2, j + 2) for i, j in (start, goal))
    blocked[si][sj] = blocked[gi][gj] = False
    costs, parents = {(si, sj): 0.0}, {(si, sj): (si, sj)}
    queue = [(math.hypot(gi - si, gj - sj), si, sj)]
    done = set()
    while queue:
        _, i, j = heapq.heappop(queue)
        if (i, j) == (gi, gj):
            return _back(parents, (gi, gj))
        if (i, j) in done:
            continue
        done.add((i, j))
        cost = costs[i, j]
        for di, dj, step in _MOVES:
            near = (i + di, j + dj)
            if blocked[near[0]][near[1]] or blocked[i + di // 2][j + dj // 2] or near in done:
                continue
            if blocked[i - -di // 2][j - -dj // 2]:
                continue
            if cost + step < costs.get(near, math.inf):
                costs[near], parents[near] = cost + step, (i, j)
                ahead = math.hypot(gi - near[0], gj - near[1])
                heapq.heappush(queue, (cost + step + ahead, *near))
    return []


def _back(parents: dict[Cell, Cell], cell: Cell) -> list[Cell]:
    cells = [cell]
    while parents[cell] != cell:
        cell = parents[cell]
        cells.append(cell)
    return [(i - 2, j - 2) for i, j in reversed(cells)]
