# SPDX-License-Identifier: GPL-3.0-or-later
"""What is left in a map of people who have gone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Final

import numpy as np

from ground.sim.campaign.movers import PERSON
from ground.sim.campaign.truth import STEP_M, TrueMap
from ground.sim.footprints import Array, position_m
from ground.sim.worldspec import Obstacle, Point

_SAMPLE_S: Final = 0.1
_BESIDE_M: Final = 0.15
_SURFACE_M: Final = 0.3
_FIT_M: Final = 0.12
_TURNS_RAD: Final = tuple(math.radians(angle) for angle in range(-12, 13))
_SHIFTS_M: Final = tuple(0.1 * step for step in range(-4, 5))
_MOVED_M: Final = 1.0


def where(mover: Obstacle, time_s: float) -> Point:
    """Its middle at that time."""
    return position_m(mover, time_s - (mover.motion.start_s if mover.motion else 0.0))


def count_ghosts(drawn_m: Array, truth: TrueMap, movers: Sequence[Obstacle]) -> int:
    """Obstacles of the map where people walked and nothing stands.

    The map is laid over the world first: that it is turned as a whole is another matter.
    """
    if not len(drawn_m):
        return 0
    places = _fitted(drawn_m, truth)
    walked = np.zeros(len(places), bool)
    for person in (mover for mover in movers if mover.name == PERSON):
        times = np.arange(0.0, person.vanishes_s, _SAMPLE_S)
        way = np.array([where(person, time_s) for time_s in times])
        walked |= _nearest_m(places, way) < person.radius_m + _BESIDE_M
    for mover in (mover for mover in movers if mover.name != PERSON):
        stops = [mover.center_m, *(mover.motion.path_m if mover.motion else ())]
        walked &= _nearest_m(places, np.array(stops)) > _MOVED_M
    return int(np.sum(walked & (_gap_m(places, truth) > _SURFACE_M)))


def _nearest_m(places: Array, others: Array) -> Array:
    nearest: Array = np.hypot(*(places[:, None] - others).transpose(2, 0, 1)).min(axis=1)
    return nearest


def _gap_m(places: Array, truth: TrueMap) -> Array:
    """Room around each place; those beyond the plan have none."""
    cells = np.rint((places - truth.points_m[0, 0]) / STEP_M).astype(int)
    limits = np.array(truth.shape) - 1
    inside = ((cells >= 0) & (cells <= limits)).all(axis=1)
    gaps: Array = truth.body_gap_m[tuple(cells.clip(0, limits).T)]
    return np.where(inside, gaps, 0.0)


def _fitted(places: Array, truth: TrueMap) -> Array:
    """The places after the turn and shift with which most of them lie on something."""
    middle = places.mean(axis=0)
    best, chosen = -1.0, places
    for turn_rad in _TURNS_RAD:
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        turned = (places - middle) @ np.array([[c, s], [-s, c]]) + middle
        for shift in product(_SHIFTS_M, _SHIFTS_M):
            moved = turned + np.array(shift)
            score = float(np.mean(np.abs(_gap_m(moved, truth)) < _FIT_M))
            score -= 1e-3 * (abs(turn_rad) + abs(shift[0]) + abs(shift[1]))
            if score > best:
                best, chosen = score, moved
    return chosen
