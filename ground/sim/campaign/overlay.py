# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the drone's map onto the true world, so that its contents can be judged apart from its
drift as a whole."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from ground.sim.campaign.truth import STEP_M, TrueMap
from ground.sim.footprints import Array

_FIT_M: Final = 0.12
_TURNS_RAD: Final = tuple(math.radians(angle) for angle in range(-16, 17))
_SHIFTS_M: Final = tuple(0.1 * step for step in range(-4, 5))
_SMALLER: Final = 1e-3


@dataclass(frozen=True, slots=True)
class Overlay:
    """A rotation about a place and a shift, in the world frame."""

    turn_rad: float
    about_m: Array
    shift_m: Array

    def laid(self, drawn_m: Array) -> Array:
        """Move places of the map to where they are in the world."""
        return (drawn_m - self.about_m) @ self._turn() + self.about_m + self.shift_m

    def lifted(self, true_m: Array) -> Array:
        """Move places of the world to where they are in the map."""
        return (true_m - self.shift_m - self.about_m) @ self._turn().T + self.about_m

    def _turn(self) -> Array:
        c, s = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return np.array([[c, s], [-s, c]])


def lay_over(drawn_m: Array, truth: TrueMap) -> Overlay:
    """Find the smallest overlay that puts most of the map's obstacles (world frame) on surfaces."""
    about_m = drawn_m.mean(axis=0) if len(drawn_m) else np.zeros(2)
    best, chosen = -1.0, Overlay(0.0, about_m, np.zeros(2))
    for turn_rad, x_m, y_m in product(_TURNS_RAD, _SHIFTS_M, _SHIFTS_M) if len(drawn_m) else ():
        overlay = Overlay(turn_rad, about_m, np.array((x_m, y_m)))
        score = float(np.mean(np.abs(gap_m(overlay.laid(drawn_m), truth)) < _FIT_M))
        score -= _SMALLER * (abs(turn_rad) + abs(x_m) + abs(y_m))
        if score > best:
            best, chosen = score, overlay
    return chosen


def gap_m(places_m: Array, truth: TrueMap) -> Array:
    """Distance of each place to the nearest surface; 0 outside the plan."""
    cells = np.rint((places_m - truth.points_m[0, 0]) / STEP_M).astype(int)
    limits = np.array(truth.shape) - 1
    inside = ((cells >= 0) & (cells <= limits)).all(axis=1)
    gaps: Array = truth.body_gap_m[tuple(cells.clip(0, limits).T)]
    return np.where(inside, gaps, 0.0)
