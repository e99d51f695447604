# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds of maps to plan on: 128 x 128 cells of 5 cm, drawn by a seeded generator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from tests.bench.plan.drawing import SIDE, box, disc, empty_hall, inflated
from tests.bench.plan.exact import Bits, ExactMap

Draw = Callable[[np.random.Generator], Bits]
Rect = tuple[int, int, int, int]
"""x0, y0, x1, y1; the ends not included."""

ROOM_SIDE = 30
RIGHT_ANGLE = np.pi / 2


def furniture(rng: np.random.Generator) -> Bits:
    """One hall with 6 to 14 boxes and round tables, up to 1.8 m long."""
    cells = empty_hall()
    for _ in range(rng.integers(6, 15)):
        centre = tuple(rng.uniform(4, SIDE - 4, 2))
        if rng.random() < 0.35:
            disc(cells, centre, rng.uniform(3, 12))
            continue
        square = rng.random() < 0.5
        turn = RIGHT_ANGLE * rng.integers(2) if square else rng.uniform(0, np.pi)
        box(cells, centre, (rng.uniform(3, 18), rng.uniform(3, 12)), turn)
    return cells


def rooms(rng: np.random.Generator) -> Bits:
    """3 to 6 rooms, cut from larger ones, with doors of 0.8 to 1 m and some furniture."""
    while True:
        cells = empty_hall()
        parts: list[Rect] = [(2, 2, SIDE - 2, SIDE - 2)]
        walls = []
        for _ in range(rng.integers(2, 6)):
            parts.sort(key=lambda part: (part[2] - part[0]) * (part[3] - part[1]))
            cut = _cut(rng, parts[-1])
            if cut is None:
                break
            wall, halves = cut
            x0, y0, x1, y1 = wall
            cells[y0:y1, x0:x1] = True
            walls.append(wall)
            parts[-1:] = halves
        for wall in walls:
            for _ in range(1 if rng.random() < 0.7 else 2):
                _open_door(rng, cells, wall)
        for x0, y0, x1, y1 in parts:
            for _ in range(rng.integers(0, 3)):
                centre = (rng.uniform(x0, x1), rng.uniform(y0, y1))
                half = (rng.uniform(3, 9), rng.uniform(3, 7))
                box(cells, centre, half, RIGHT_ANGLE * rng.integers(2))
        if len(parts) > 2 and _mostly_connected(cells):
            return cells


def _cut(rng: np.random.Generator, part: Rect) -> tuple[Rect, list[Rect]] | None:
    """A wall of 10 to 15 cm across a room, mostly across its longer side, and the two halves."""
    x0, y0, x1, y1 = part
    longer_is_x = x1 - x0 > y1 - y0
    along_x = longer_is_x if rng.random() < 0.8 else not longer_is_x
    low, high = (x0, x1) if along_x else (y0, y1)
    thick = int(rng.integers(2, 4))
    if high - low < 2 * ROOM_SIDE + thick:
        return None
    at = int(rng.integers(low + ROOM_SIDE, high - ROOM_SIDE - thick + 1))
    if along_x:
        return (at, y0, at + thick, y1), [(x0, y0, at, y1), (at + thick, y0, x1, y1)]
    return (x0, at, x1, at + thick), [(x0, y0, x1, at), (x0, at + thick, x1, y1)]


def _open_door(rng: np.random.Generator, cells: Bits, wall: Rect) -> None:
    x0, y0, x1, y1 = wall
    width = int(rng.integers(16, 21))
    if x1 - x0 < y1 - y0:
        at = int(rng.integers(y0 + 1, y1 - width))
        cells[at : at + width, x0:x1] = False
    else:
        at = int(rng.integers(x0 + 1, x1 - width))
        cells[y0:y1, at : at + width] = False


def largest_region(blocked: Bits) -> Bits:
    """The largest set of free cells that are connected by steps to the 4 neighbours."""
    exact = ExactMap(blocked)
    left, largest = ~blocked, np.zeros_like(blocked)
    while left.sum() > largest.sum():
        y, x = np.argwhere(left)[0]
        region = exact.reachable(int(x), int(y))
        left &= ~region
        if region.sum() > largest.sum():
            largest = region
    return largest


def _mostly_connected(cells: Bits) -> bool:
    """Whether most rooms are connected: a door may end at another wall, so that a room is lost."""
    blocked = inflated(cells)
    return bool(largest_region(blocked).sum() > 0.9 * (~blocked).sum())


def worth_planning(blocked: Bits) -> bool:
    """Whether the map is neither nearly full nor nearly empty, nor all fragments."""
    free = (~blocked).mean()
    return bool(0.25 <= free <= 0.85 and largest_region(blocked).mean() >= 0.2)


def maze(rng: np.random.Generator) -> Bits:
    """Corridors of 0.8 to 1 m by depth-first search, with a few loops."""
    wide, wall = int(rng.integers(16, 21)), 2
    side = (SIDE - wall) // (wide + wall)
    margin = (SIDE - side * (wide + wall) - wall) // 2 + wall
    cells = np.ones((SIDE, SIDE), bool)

    def clear(a: tuple[int, int], b: tuple[int, int]) -> None:
        (x0, y0), (x1, y1) = sorted((a, b))
        low_x, low_y = (margin + k * (wide + wall) for k in (x0, y0))
        high_x, high_y = (margin + k * (wide + wall) + wide for k in (x1, y1))
        cells[low_y:high_y, low_x:high_x] = False

    seen, stack = {(0, 0)}, [(0, 0)]
    while stack:
        x, y = stack[-1]
        beside = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
        fresh = [p for p in beside if p not in seen and min(p) >= 0 and max(p) < side]
        if not fresh:
            stack.pop()
            continue
        next_place = fresh[int(rng.integers(len(fresh)))]
        clear((x, y), next_place)
        seen.add(next_place)
        stack.append(next_place)
    for _ in range(rng.integers(0, side + 1)):
        x, y = int(rng.integers(side - 1)), int(rng.integers(side))
        clear(*(((x, y), (x + 1, y)) if rng.random() < 0.5 else ((y, x), (y, x + 1))))
    return cells


def clutter(rng: np.random.Generator) -> Bits:
    """45 to 100 poles, round and square, 10 to 24 cm wide."""
    cells = empty_hall()
    for _ in range(rng.integers(45, 101)):
        centre = tuple(rng.uniform(3, SIDE - 3, 2))
        size = rng.uniform(1.0, 2.4)
        if rng.random() < 0.5:
            disc(cells, centre, size)
        else:
            box(cells, centre, (size, size), 0.0)
    return cells


def caverns(rng: np.random.Generator) -> Bits:
    """Caves as computer games have them, in place of maps taken from games: a cellular automaton
    on cells of 10 to 20 cm leaves ragged halls, pillars and necks."""
    coarse = int(rng.choice([2, 4]))
    small = SIDE // coarse
    while True:
        rock = rng.random((small, small)) < rng.uniform(0.40, 0.46)
        for _ in range(int(rng.integers(4, 7))):
            rock = _neighbours(rock) >= 5
        cells = np.kron(rock, np.ones((coarse, coarse), bool)).astype(bool)
        cells |= empty_hall()
        if worth_planning(inflated(cells)):
            return cells


def _neighbours(rock: Bits) -> np.ndarray:
    """How many of the 3 x 3 cells around each are rock; everything outside is."""
    framed = np.pad(rock, 1, constant_values=True).astype(int)
    height, width = rock.shape
    return sum(framed[y : y + height, x : x + width] for y in range(3) for x in range(3))


DRAWN: Mapping[str, Draw] = MappingProxyType(
    {draw.__name__: draw for draw in (furniture, rooms, maze, clutter, caverns)}
)
