# SPDX-License-Identifier: GPL-3.0-or-later
"""Slow and obvious answers to what the core computes fast."""

import itertools
import math
from collections import deque
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tests.core.maps import SIDE, Bits

Point = tuple[float, float]
Cell = tuple[int, int]


def inflated(occupied: Bits, radius_cells: float) -> Bits:
    """Cells whose square comes nearer than the radius to the square of an occupied cell."""
    blocked: NDArray[np.bool_] = occupied.copy()
    reach = math.ceil(radius_cells) + 1
    padded = np.pad(occupied, reach)
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            gap_x, gap_y = max(abs(dx) - 1, 0), max(abs(dy) - 1, 0)
            if gap_x**2 + gap_y**2 < radius_cells**2:
                y, x = reach + dy, reach + dx
                blocked |= padded[y : y + SIDE, x : x + SIDE]
    return blocked


def crossings(a: Point, b: Point) -> list[Fraction]:
    """Where on the segment (0..1) a side between two cells is met, exactly; both ends included."""
    at = {Fraction(0), Fraction(1)}
    for start, end in zip(map(Fraction, a), map(Fraction, b), strict=True):
        low, high = min(start, end), max(start, end)
        if low != high:
            at |= {
                (side - start) / (end - start)
                for side in range(math.ceil(low), math.floor(high) + 1)
            }
    return sorted(at)


def cells_along(a: Point, b: Point) -> list[Cell]:
    """The cells of the start, of each piece between two crossings, and of the end."""
    ax, ay, bx, by = map(Fraction, (*a, *b))
    at = crossings(a, b)
    middles = [(s + t) / 2 for s, t in itertools.pairwise(at)]
    inner = [(math.floor(ax + t * (bx - ax)), math.floor(ay + t * (by - ay))) for t in middles]
    whole = [(math.floor(ax), math.floor(ay)), *inner, (math.floor(bx), math.floor(by))]
    return [cell for i, cell in enumerate(whole) if i == 0 or cell != whole[i - 1]]


def is_blocked(blocked: Bits, cell: Cell) -> bool:
    ix, iy = cell
    return not (0 <= ix < SIDE and 0 <= iy < SIDE) or bool(blocked[iy, ix])


def segment_free(blocked: Bits, a: Point, b: Point) -> bool:
    """Free cells only, and no squeezing between two blocked cells that touch at a corner."""
    way = cells_along(a, b)
    if any(is_blocked(blocked, cell) for cell in way):
        return False
    return not any(
        (x0 != x1 and y0 != y1) and is_blocked(blocked, (x0, y1)) and is_blocked(blocked, (x1, y0))
        for (x0, y0), (x1, y1) in itertools.pairwise(way)
    )


def distances(blocked: Bits, start: Cell) -> dict[Cell, int]:
    """Steps to 4 neighbours from the start to each cell that can be reached."""
    steps = {start: 0}
    queue = deque([start])
    while queue:
        x, y = queue.popleft()
        for cell in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if cell not in steps and not is_blocked(blocked, cell):
                steps[cell] = steps[x, y] + 1
                queue.append(cell)
    return steps
