# SPDX-License-Identifier: GPL-3.0-or-later
"""Homes drawn at random (a studio, two rooms, three rooms), how they change, and places that look
alike."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from tests.bench.slam.rooms import Block, Room, make_room

KINDS: Final = ("studio", "two", "three")
ALIKE: Final = ("bare", "twin", "loop")
_WALL_M: Final = 0.1
_SIZE_M: Final = (4.2, 5.9)
_DOOR_M: Final = (0.85, 1.05)
_AT_DOOR_M: Final = 0.75

_Rectangle = tuple[float, float, float, float]
_Point = tuple[float, float]


def _room(kind: str, size_m: _Point, blocks: list[Block]) -> Room:
    outline = Block(0.5 * size_m[0], 0.5 * size_m[1], *size_m).walls()
    walls = np.vstack([outline, *(block.walls() for block in blocks)])
    return Room(kind, walls, size_m, tuple(blocks))


def _wall(at: float, low: float, high: float, door: _Point, *, upright: bool) -> list[Block]:
    """A wall with a door in it."""
    parts = [(low, door[0]), (door[1], high)]
    middles = [(0.5 * (a + b), b - a) for a, b in parts]
    if upright:
        return [Block(at, middle, _WALL_M, length) for middle, length in middles]
    return [Block(middle, at, length, _WALL_M) for middle, length in middles]


def _door(low: float, high: float, rng: np.random.Generator) -> _Point:
    wide = rng.uniform(*_DOOR_M)
    start = rng.uniform(low + 0.1, high - 0.1 - wide)
    return start, start + wide


def _piece(room: _Rectangle, rng: np.random.Generator) -> Block:
    """Furniture along one of the walls."""
    x0, y0, x1, y1 = room
    wide = rng.uniform(0.35, min(1.1, 0.5 * (x1 - x0)))
    deep = rng.uniform(0.35, min(1.1, 0.5 * (y1 - y0)))
    x, y = rng.uniform(x0 + wide / 2, x1 - wide / 2), rng.uniform(y0 + deep / 2, y1 - deep / 2)
    x, y = (
        (x0 + wide / 2, y),
        (x1 - wide / 2, y),
        (x, y0 + deep / 2),
        (x, y1 - deep / 2),
    )[rng.integers(4)]
    return Block(x, y, wide, deep)


def _fits(piece: Block, doors: list[_Point], blocks: list[Block]) -> bool:
    def near(x: float, y: float, gap_x: float, gap_y: float) -> bool:
        return (
            abs(piece.x_m - x) < 0.5 * piece.wide_m + gap_x
            and abs(piece.y_m - y) < 0.5 * piece.deep_m + gap_y
        )

    return not (
        any(near(*door, _AT_DOOR_M, _AT_DOOR_M) for door in doors)
        or any(near(b.x_m, b.y_m, 0.5 * b.wide_m, 0.5 * b.deep_m) for b in blocks)
    )


def make_home(kind: str, rng: np.random.Generator) -> Room:
    """A home of one of KINDS; its lower left corner is the origin."""
    wide, deep = rng.uniform(*_SIZE_M, 2)
    x, y = rng.uniform(0.4, 0.6) * wide, rng.uniform(0.4, 0.6) * deep
    half = 0.5 * _WALL_M
    blocks: list[Block] = []
    doors: list[_Point] = []
    rooms: list[_Rectangle] = [(0.0, 0.0, wide, deep)]
    if kind != "studio":
        door = _door(0.0, deep, rng)
        while kind == "three" and door[0] - 0.3 < y < door[1] + 0.3:
            door = _door(0.0, deep, rng)
        blocks += _wall(x, 0.0, deep, door, upright=True)
        doors.append((x, 0.5 * sum(door)))
        rooms = [(0.0, 0.0, x - half, deep), (x + half, 0.0, wide, deep)]
    if kind == "three":
        door = _door(x + half, wide, rng)
        blocks += _wall(y, x + half, wide, door, upright=False)
        doors.append((0.5 * sum(door), y))
        rooms[1:] = [(x + half, 0.0, wide, y - half), (x + half, y + half, wide, deep)]
    fewest, most = {"studio": (4, 7), "two": (2, 4), "three": (1, 3)}[kind]
    for room in rooms:
        for _ in range(int(rng.integers(fewest, most))):
            tries = (_piece(room, rng) for _ in range(20))
            blocks += [piece for piece in tries if _fits(piece, doors, blocks)][:1]
    return _room(kind, (wide, deep), blocks)


def shut(room: Room) -> tuple[Room, float]:
    """A home of two or three rooms with its first door shut, and the x of that door's wall."""
    below, above = room.blocks[:2]
    low, high = below.y_m + 0.5 * below.deep_m, above.y_m - 0.5 * above.deep_m
    leaf = Block(below.x_m, 0.5 * (low + high), _WALL_M, high - low)
    return _room(room.kind, room.size_m, [*room.blocks, leaf]), below.x_m


def _moved(piece: Block, room: Room, others: list[Block], rng: np.random.Generator) -> Block:
    """Move the piece to a random free place, or leave it if there is none."""
    half = 0.5 * np.array([piece.wide_m, piece.deep_m])
    for _ in range(40):
        x, y = rng.uniform(half, np.array(room.size_m) - half)
        apart = (
            abs(x - other.x_m) > 0.5 * (piece.wide_m + other.wide_m) + _WALL_M / 2
            or abs(y - other.y_m) > 0.5 * (piece.deep_m + other.deep_m) + _WALL_M / 2
            for other in others
        )
        if all(apart):
            return replace(piece, x_m=x, y_m=y)
    return piece


def rearranged(room: Room, share: float, rng: np.random.Generator) -> Room:
    """The home with about this share of its furniture moved."""
    blocks = list(room.blocks)
    for i, piece in enumerate(blocks):
        is_wall = min(piece.wide_m, piece.deep_m) < 1.1 * _WALL_M
        if not is_wall and rng.random() < share:
            blocks[i] = _moved(piece, room, blocks[:i] + blocks[i + 1 :], rng)
    return _room(room.kind, room.size_m, blocks)


def make_alike(kind: str, rng: np.random.Generator) -> Room:
    """Places that look alike: a room without furniture, the same room twice, a corridor around a
    block."""
    if kind == "loop":
        return make_room("loop", rng)
    if kind == "bare":
        wide, deep = rng.uniform(3.5, 5.5, 2)
        return _room("bare", (wide, deep), [])
    wide, deep = 2.4, rng.uniform(4.2, 5.2)
    blocks = _wall(wide, 0.0, deep, (0.45 * deep - 0.45, 0.45 * deep + 0.45), upright=True)
    for at_top in (True, False):
        w, d = rng.uniform(0.4, 0.9, 2)
        y = deep - d / 2 if at_top else d / 2
        left = w / 2 if at_top else 1.2
        blocks += [Block(left, y, w, d), Block(left + wide + _WALL_M / 2, y, w, d)]
    return _room("twin", (2 * wide, deep), blocks)
