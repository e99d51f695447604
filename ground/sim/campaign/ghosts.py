# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts what people who have gone left behind in the drone's map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ground.sim.campaign.movers import PERSON
from ground.sim.campaign.overlay import gap_m, lay_over
from ground.sim.campaign.truth import TrueMap
from ground.sim.footprints import Array, position_m
from ground.sim.worldspec import Obstacle, Point

_SAMPLE_S: Final = 0.1
_BESIDE_M: Final = 0.15
_SURFACE_M: Final = 0.3
_MOVED_M: Final = 1.0


def where(mover: Obstacle, time_s: float) -> Point:
    """The obstacle's centre at this time."""
    return position_m(mover, time_s - (mover.motion.start_s if mover.motion else 0.0))


def count_ghosts(drawn_m: Array, truth: TrueMap, movers: Sequence[Obstacle]) -> int:
    """Count the map's obstacles where people walked and nothing stands.

    The map is fitted to the world first, since its drift as a whole is judged elsewhere.
    """
    if not len(drawn_m):
        return 0
    places = lay_over(drawn_m, truth).laid(drawn_m)
    walked = np.zeros(len(places), bool)
    for person in (mover for mover in movers if mover.name == PERSON):
        times = np.arange(0.0, person.vanishes_s, _SAMPLE_S)
        way = np.array([where(person, time_s) for time_s in times])
        walked |= _nearest_m(places, way) < person.radius_m + _BESIDE_M
    for mover in (mover for mover in movers if mover.name != PERSON):
        stops = [mover.center_m, *(mover.motion.path_m if mover.motion else ())]
        walked &= _nearest_m(places, np.array(stops)) > _MOVED_M
    return int(np.sum(walked & (gap_m(places, truth) > _SURFACE_M)))


def _nearest_m(places: Array, others: Array) -> Array:
    nearest: Array = np.hypot(*(places[:, None] - others).transpose(2, 0, 1)).min(axis=1)
    return nearest
