# SPDX-License-Identifier: GPL-3.0-or-later
"""Goals that a drone can reach, drawn one after the other from the true world."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from ground.model import Point
from ground.sim.campaign.truth import flood
from ground.sim.footprints import Array
from ground.sim.world import World

_STEP_M: Final = 0.05
_HEIGHTS_M: Final = (0.3, 0.4, 0.5, 0.73)
"""Under, at and above the height of the flight: no goal is under a table."""
_WAY_M: Final = 0.3
_GOAL_M: Final = 0.45
_APART_M: Final = 1.5


def _places(world: World) -> tuple[Array, Array]:
    """A lattice of world points within the outer walls, and the distance of each to a surface."""
    places = world.footprints
    standing = places.bottom_m < _HEIGHTS_M[-1]
    low = places.center_m[standing].min(axis=0)
    high = places.center_m[standing].max(axis=0)
    x, y = np.meshgrid(*(np.arange(low[i], high[i], _STEP_M) for i in (0, 1)), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel()])
    gaps = [np.abs(world.surface_distance_m(points, height)) for height in _HEIGHTS_M]
    outside = [places.signed_m(*point)[standing].min() > 0 for point in points]
    gap_m = np.where(outside, np.min(gaps, axis=0), 0.0)
    return points.reshape(*x.shape, 2), gap_m.reshape(x.shape)


def goals(world: World, seed: int) -> Iterator[Point]:
    """An endless series of goals in the map frame, each far from the last one and from walls."""
    points, gap_m = _places(world)
    gap_to_start = np.hypot(*(points[..., i] - world.spec.start_m[i] for i in (0, 1)))
    start = np.unravel_index(np.argmin(gap_to_start), gap_to_start.shape)
    reachable = flood(gap_m > _WAY_M, (int(start[0]), int(start[1])))
    fit = points[reachable & (gap_m > _GOAL_M)]
    rng = np.random.default_rng(seed)
    last = world.spec.start_m
    while True:
        place = fit[rng.integers(len(fit))]
        if math.dist(place, last) >= _APART_M:
            last = (float(place[0]), float(place[1]))
            yield Point(*world.to_map(*last))
