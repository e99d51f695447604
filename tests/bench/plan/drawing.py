# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes on a square of cells, and the drone's width around them."""

from __future__ import annotations

import numpy as np

from tests.bench.plan.exact import Bits

SIDE = 128
CELL_M = 0.05
RADIUS_CELLS = 3

_Y, _X = np.mgrid[0:SIDE, 0:SIDE] + 0.5


def empty_hall(wall: int = 2) -> Bits:
    """A hall that is free except for its outer walls."""
    cells = np.ones((SIDE, SIDE), bool)
    cells[wall:-wall, wall:-wall] = False
    return cells


def box(cells: Bits, centre: tuple[float, float], half: tuple[float, float], turn: float) -> None:
    """A rectangle, turned by an angle in radians."""
    dx, dy = _X - centre[0], _Y - centre[1]
    along = np.cos(turn) * dx + np.sin(turn) * dy
    across = np.cos(turn) * dy - np.sin(turn) * dx
    cells |= (abs(along) <= half[0]) & (abs(across) <= half[1])


def disc(cells: Bits, centre: tuple[float, float], radius: float) -> None:
    cells |= np.hypot(_X - centre[0], _Y - centre[1]) <= radius


def inflated(cells: Bits, radius: int = RADIUS_CELLS) -> Bits:
    """Block every cell whose centre is within the radius of a blocked cell's; the rim too."""
    framed = np.pad(cells, radius, constant_values=True)
    height, width = cells.shape
    wide = np.zeros_like(cells)
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            if dx * dx + dy * dy <= radius * radius:
                y, x = radius + dy, radius + dx
                wide |= framed[y : y + height, x : x + width]
    return wide


def least_clearance(radius: int = RADIUS_CELLS) -> float:
    """Least distance in cells that inflation leaves between a free place and an obstacle."""
    beyond = [
        np.hypot(max(dx - 1, 0), max(dy - 1, 0))
        for dx in range(radius + 2)
        for dy in range(radius + 2)
        if dx * dx + dy * dy > radius * radius
    ]
    return float(min(beyond))
