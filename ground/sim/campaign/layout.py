# SPDX-License-Identifier: GPL-3.0-or-later
"""Randomly drawn floor plans: rooms, the walls between them, and doors that connect them all."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from ground.sim.worldspec import Point

WALL_M: Final = 0.1
DOOR_M: Final = (0.7, 1.0)
_BESIDE_DOOR_M: Final = 0.15
_OFFICE_M: Final = 2.3
"""Depth of the rooms of an office; a little less where its outline leaves no more."""


@dataclass(frozen=True, slots=True)
class Rect:
    """An axis-aligned rectangle."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def size_m(self) -> Point:
        return self.x1 - self.x0, self.y1 - self.y0

    @property
    def center_m(self) -> Point:
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    @property
    def area_m2(self) -> float:
        return self.size_m[0] * self.size_m[1]

    def near(self, other: Rect, gap_m: float = 0.0) -> bool:
        """Whether they overlap, or the gap between them is below gap_m on both axes."""
        return (
            self.x0 < other.x1 + gap_m
            and other.x0 < self.x1 + gap_m
            and self.y0 < other.y1 + gap_m
            and other.y0 < self.y1 + gap_m
        )


@dataclass(frozen=True, slots=True)
class Door:
    """A gap in the wall between two rooms, which are given by index."""

    gap: Rect
    rooms: tuple[int, int]
    upright: bool
    """Whether its wall runs along y."""

    @property
    def width_m(self) -> float:
        return self.gap.size_m[1 if self.upright else 0]


@dataclass(frozen=True, slots=True)
class Layout:
    """A floor plan; walls are the inner walls without their doors."""

    outline: Rect
    rooms: tuple[Rect, ...]
    walls: tuple[Rect, ...]
    doors: tuple[Door, ...] = ()


def home(rng: np.random.Generator) -> Layout:
    """One to six rooms within 4 to 9 m, connected by doors."""
    while True:
        outline = Rect(0.0, 0.0, rng.uniform(4.0, 9.0), rng.uniform(4.0, 8.0))
        wanted = int(rng.integers(1, 2 + min(5, int(outline.area_m2 // 9))))
        rooms, walls = _split(rng, [outline], [], wanted, 2.0)
        layout = _with_doors(rng, outline, rooms, walls, 0.25)
        if layout is not None:
            return layout


def office(rng: np.random.Generator) -> Layout:
    """A corridor with rooms on both sides, 7 to 12 m long."""
    while True:
        outline = Rect(0.0, 0.0, rng.uniform(7.0, 12.0), rng.uniform(6.5, 11.0))
        wide = rng.uniform(1.2, 1.8)
        most = outline.y1 - wide - _OFFICE_M - 2 * WALL_M
        low = rng.uniform(_OFFICE_M, max(_OFFICE_M, most))
        high = low + wide + 2 * WALL_M
        walls = [
            Rect(0.0, low, outline.x1, low + WALL_M),
            Rect(0.0, high - WALL_M, outline.x1, high),
        ]
        rooms = [Rect(0.0, low + WALL_M, outline.x1, high - WALL_M)]
        for y0, y1 in ((0.0, low), (high, outline.y1)):
            strip = [Rect(0.0, y0, outline.x1, y1)]
            parts, between = _split(rng, strip, [], int(outline.x1 // 3), 2.2, along_x=True)
            rooms, walls = rooms + parts, walls + between
        layout = _with_doors(rng, outline, rooms, walls, 0.1, first=0)
        if layout is not None:
            return layout


def maze(rng: np.random.Generator) -> Layout:
    """Corridors 0.85 to 1.1 m wide, by depth-first search with a few loops, within 4 to 8 m."""
    wide, wall = rng.uniform(0.85, 1.1), rng.uniform(0.05, 0.1)
    step = wide + wall
    columns, rows = (int(rng.uniform(4.0, 8.0) // step) for _ in range(2))
    open_to: set[frozenset[Point]] = set()
    seen, stack = {(0, 0)}, [(0, 0)]
    while stack:
        x, y = stack[-1]
        beside = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
        fresh = [p for p in beside if p not in seen and 0 <= p[0] < columns and 0 <= p[1] < rows]
        if not fresh:
            stack.pop()
            continue
        onward = fresh[int(rng.integers(len(fresh)))]
        open_to.add(frozenset(((x, y), onward)))
        seen.add(onward)
        stack.append(onward)
    outline = Rect(0.0, 0.0, columns * step - wall, rows * step - wall)
    walls = []
    for x in range(columns):
        for y in range(rows):
            left, low = x * step, y * step
            sides = (
                ((x + 1, y), Rect(left + wide, low - wall, left + step, low + step)),
                ((x, y + 1), Rect(left - wall, low + wide, left + step, low + step)),
            )
            for cell, side in sides:
                inside = cell[0] < columns and cell[1] < rows
                is_open = frozenset(((x, y), cell)) in open_to or rng.random() < 0.06
                if inside and not is_open:
                    walls.append(side)
    cells = tuple(
        Rect(x * step, y * step, x * step + wide, y * step + wide)
        for x in range(columns)
        for y in range(rows)
    )
    return Layout(outline, cells, tuple(walls))


def hall(rng: np.random.Generator) -> Layout:
    """One room of 4 to 10 m."""
    outline = Rect(0.0, 0.0, rng.uniform(4.0, 10.0), rng.uniform(4.0, 8.0))
    return Layout(outline, (outline,), ())


def shut(layout: Layout, room: int) -> tuple[Rect, ...]:
    """The door leaves that close all doors of a room."""
    return tuple(door.gap for door in layout.doors if room in door.rooms)


def _split(
    rng: np.random.Generator,
    rooms: list[Rect],
    walls: list[Rect],
    wanted: int,
    least_m: float,
    along_x: bool | None = None,
) -> tuple[list[Rect], list[Rect]]:
    """Cut the largest room until there are enough, or until it is too small to cut."""
    while len(rooms) < wanted:
        rooms = sorted(rooms, key=lambda room: room.area_m2)
        room = rooms.pop()
        wide, deep = room.size_m
        across = along_x if along_x is not None else wide > deep * rng.uniform(0.7, 1.4)
        low, high = (room.x0, room.x1) if across else (room.y0, room.y1)
        if high - low < 2 * least_m + WALL_M:
            return [*rooms, room], walls
        at = rng.uniform(low + least_m, high - least_m - WALL_M)
        if across:
            walls = [*walls, Rect(at, room.y0, at + WALL_M, room.y1)]
            halves = (
                Rect(room.x0, room.y0, at, room.y1),
                Rect(at + WALL_M, room.y0, room.x1, room.y1),
            )
        else:
            walls = [*walls, Rect(room.x0, at, room.x1, at + WALL_M)]
            halves = (
                Rect(room.x0, room.y0, room.x1, at),
                Rect(room.x0, at + WALL_M, room.x1, room.y1),
            )
        rooms = [*rooms, *halves]
    return rooms, walls


def _with_doors(
    rng: np.random.Generator,
    outline: Rect,
    rooms: list[Rect],
    walls: list[Rect],
    more: float,
    first: int | None = None,
) -> Layout | None:
    """Add doors that connect all rooms, and some more; pairs with room `first` are tried first."""
    pairs = list(combinations(range(len(rooms)), 2))
    rng.shuffle(pairs)
    if first is not None:
        pairs.sort(key=lambda pair: first not in pair)
    joined = list(range(len(rooms)))
    doors: list[Door] = []
    for a, b in pairs:
        if joined[a] == joined[b] and rng.random() >= more:
            continue
        door = _door(rng, rooms, int(a), int(b))
        if door is None or any(door.gap.near(other.gap, 0.3) for other in doors):
            continue
        doors.append(door)
        joined = [joined[a] if group == joined[b] else group for group in joined]
    if len(set(joined)) > 1:
        return None
    for door in doors:
        walls = [piece for wall in walls for piece in _cut_out(wall, door.gap)]
    return Layout(outline, tuple(rooms), tuple(walls), tuple(doors))


def _door(rng: np.random.Generator, rooms: list[Rect], a: int, b: int) -> Door | None:
    """Draw a door in the wall that two rooms share, if they share enough of one."""
    width = rng.uniform(*DOOR_M)
    one, two = rooms[a], rooms[b]
    for upright in (True, False):
        near, far = sorted((one, two), key=lambda room: room.x0 if upright else room.y0)
        wall = (near.x1, far.x0) if upright else (near.y1, far.y0)
        low = max((one.y0, two.y0) if upright else (one.x0, two.x0)) + _BESIDE_DOOR_M
        high = min((one.y1, two.y1) if upright else (one.x1, two.x1)) - _BESIDE_DOOR_M
        if abs(wall[1] - wall[0] - WALL_M) < 1e-6 and high - low > width:
            at = rng.uniform(low, high - width)
            gap = (
                Rect(wall[0], at, wall[1], at + width)
                if upright
                else Rect(at, wall[0], at + width, wall[1])
            )
            return Door(gap, (a, b), upright)
    return None


def _cut_out(wall: Rect, gap: Rect) -> list[Rect]:
    """The parts of a wall beside a gap that goes through it."""
    if not wall.near(gap, -1e-6):
        return [wall]
    upright = wall.size_m[1] > wall.size_m[0]
    if upright:
        parts = [Rect(wall.x0, wall.y0, wall.x1, gap.y0), Rect(wall.x0, gap.y1, wall.x1, wall.y1)]
    else:
        parts = [Rect(wall.x0, wall.y0, gap.x0, wall.y1), Rect(gap.x1, wall.y0, wall.x1, wall.y1)]
    return [part for part in parts if min(part.size_m) > 1e-3]
