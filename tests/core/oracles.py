# SPDX-License-Identifier: GPL-3.0-or-later
"""Slow and obvious algorithms for what the core computes fast."""

import itertools
import math
from collections import deque
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tests.core.maps import PER_CELL, SIDE, Bits, Cell, Point, Steps


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
    """Where the segment (0..1) crosses a side between two cells, exactly; both ends included."""
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
    """Free cells only, and never between two blocked cells that touch at a corner."""
    way = cells_along(a, b)
    if any(is_blocked(blocked, cell) for cell in way):
        return False
    return not any(
        (x0 != x1 and y0 != y1) and is_blocked(blocked, (x0, y1)) and is_blocked(blocked, (x1, y0))
        for (x0, y0), (x1, y1) in itertools.pairwise(way)
    )


def distances(blocked: Bits, start: Cell) -> dict[Cell, int]:
    """Number of steps to 4 neighbours from the start to each reachable cell."""
    steps = {start: 0}
    queue = deque([start])
    while queue:
        x, y = queue.popleft()
        for cell in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if cell not in steps and not is_blocked(blocked, cell):
                steps[cell] = steps[x, y] + 1
                queue.append(cell)
    return steps


def squared_distance(a: Steps, b: Steps, cell: Cell) -> Fraction:
    """Squared distance of a segment and the closed square of a cell, in lattice steps, exactly."""
    low = [c * PER_CELL for c in cell]
    high = [side + PER_CELL for side in low]
    if meets_box(a, b, low, high):
        return Fraction(0)
    corners = itertools.product(*zip(low, high, strict=True))
    from_ends = [to_box(end, low, high) for end in (a, b)]
    return min([*map(Fraction, from_ends), *(to_segment(c, a, b) for c in corners)])


def meets_box(a: Steps, b: Steps, low: list[int], high: list[int]) -> bool:
    """Whether the segment has a point in the closed box."""
    start, end = Fraction(0), Fraction(1)
    for p, q, least, most in zip(a, b, low, high, strict=True):
        if p == q:
            if not least <= p <= most:
                return False
            continue
        enters, leaves = sorted((Fraction(least - p, q - p), Fraction(most - p, q - p)))
        start, end = max(start, enters), min(end, leaves)
    return start <= end


def to_box(p: Steps, low: list[int], high: list[int]) -> int:
    gaps = [max(lo - c, 0, c - hi) for c, lo, hi in zip(p, low, high, strict=True)]
    return sum(gap * gap for gap in gaps)


def to_segment(p: tuple[int, ...], a: Steps, b: Steps) -> Fraction:
    along = [q - o for o, q in zip(a, b, strict=True)]
    square = sum(d * d for d in along)
    dot = sum((c - o) * d for c, o, d in zip(p, a, along, strict=True))
    share = min(max(Fraction(dot, square), Fraction(0)), Fraction(1)) if square else Fraction(0)
    return sum(((c - o - share * d) ** 2 for c, o, d in zip(p, a, along, strict=True)), Fraction(0))


def waves(blocked: Bits, start: Cell) -> dict[Cell, int]:
    """The wave that reaches each cell: of 4 neighbours if odd; if even of 8, for a diagonal step
    where both cells beside it are free."""
    reached = {start: 0}
    front, wave = [start], 0
    while front:
        wave += 1
        fresh = set()
        for x, y in front:
            for dx, dy in itertools.product((-1, 0, 1), repeat=2):
                beside = [(x + dx, y), (x, y + dy), (x + dx, y + dy)]
                if dx != 0 and dy != 0 and wave % 2 == 1:
                    continue
                if not any(is_blocked(blocked, cell) for cell in beside if cell != (x, y)):
                    fresh.add((x + dx, y + dy))
        front = [cell for cell in fresh if cell not in reached]
        reached |= dict.fromkeys(front, wave)
    return reached
