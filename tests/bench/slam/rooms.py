# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms drawn at random: one room with furniture, two rooms with a door, a corridor that closes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

KINDS: Final = ("single", "two", "loop")
_APART_M: Final = 1.6
"""Between the middles of two pieces of furniture: room to fly between them."""


@dataclass(frozen=True, slots=True)
class Block:
    """A solid rectangle."""

    x_m: float
    y_m: float
    wide_m: float
    deep_m: float
    yaw_rad: float = 0.0

    def walls(self) -> Array:
        """Its four sides, as rows x0 y0 x1 y1."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        half = 0.5 * np.array([self.wide_m, self.deep_m])
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        corners = corners @ np.array([[c, s], [-s, c]]) + (self.x_m, self.y_m)
        return np.hstack([corners, np.roll(corners, -1, axis=0)])


@dataclass(frozen=True, slots=True)
class Room:
    """Walls as segments (rows x0 y0 x1 y1), and the outline that encloses everything."""

    kind: str
    walls: Array
    size_m: tuple[float, float]
    blocks: tuple[Block, ...]


def gap_m(walls: Array, points: Array) -> Array:
    """Distance of each point to the nearest wall."""
    start, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    to_point = points[:, None, :] - start
    share = (to_point * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-12)
    off = to_point - np.clip(share, 0.0, 1.0)[:, :, None] * along
    gaps: Array = np.sqrt((off**2).sum(axis=2)).min(axis=1)
    return gaps


def inside_block(blocks: tuple[Block, ...], points: Array) -> NDArray[np.bool_]:
    """Which points lie within furniture or walls."""
    inside = np.zeros(len(points), dtype=bool)
    for block in blocks:
        c, s = math.cos(block.yaw_rad), math.sin(block.yaw_rad)
        local = np.abs((points - (block.x_m, block.y_m)) @ np.array([[c, -s], [s, c]]))
        inside |= (local < (0.5 * block.wide_m, 0.5 * block.deep_m)).all(axis=1)
    return inside


def _furnished(rng: np.random.Generator) -> Room:
    wide, deep = rng.uniform(5.0, 8.0), rng.uniform(5.0, 7.0)
    wanted = rng.integers(3, 6)
    blocks: list[Block] = []
    for _ in range(60):
        if len(blocks) == wanted:
            break
        w, d = rng.uniform(0.4, 1.4, 2)
        x, y = rng.uniform(w / 2, wide - w / 2), rng.uniform(d / 2, deep - d / 2)
        yaw = 0.0
        if rng.random() < 0.6:  # against a wall
            x, y = ((w / 2, y), (wide - w / 2, y), (x, d / 2), (x, deep - d / 2))[rng.integers(4)]
        else:
            yaw = rng.uniform(-0.6, 0.6)
        if all(math.hypot(x - b.x_m, y - b.y_m) > _APART_M for b in blocks):
            blocks.append(Block(x, y, w, d, yaw))
    return _room("single", wide, deep, blocks)


def _two_rooms(rng: np.random.Generator) -> Room:
    left, right = rng.uniform(3.2, 4.2, 2)
    wide, deep, thick = left + right, rng.uniform(4.0, 6.0), 0.12
    door, door_wide = rng.uniform(0.8, deep - 1.8), rng.uniform(0.9, 1.1)
    above = deep - door - door_wide
    blocks = [Block(left, door / 2, thick, door), Block(left, deep - above / 2, thick, above)]
    for x0, x1 in ((0.0, left), (left, wide)):
        for _ in range(2):
            w, d = rng.uniform(0.4, 0.9, 2)
            x = rng.uniform(x0 + w / 2 + 0.2, x1 - w / 2 - 0.2)
            x, y = (
                (x, d / 2),
                (x, deep - d / 2),
                (x0 + w / 2 if x0 == 0.0 else x1 - w / 2, rng.uniform(d / 2, deep - d / 2)),
            )[rng.integers(3)]
            in_the_way = abs(x - left) < 1.0 and door - 0.5 < y < door + door_wide + 0.5
            if not in_the_way:
                blocks.append(Block(x, y, w, d))
    return _room("two", wide, deep, blocks)


def _corridor(rng: np.random.Generator) -> Room:
    wide, deep, way = rng.uniform(6.5, 8.0), rng.uniform(5.5, 7.0), rng.uniform(1.2, 1.6)
    blocks = [Block(wide / 2, deep / 2, wide - 2 * way, deep - 2 * way)]
    for _ in range(3):
        w, d = rng.uniform(0.25, 0.6), rng.uniform(0.2, 0.35)
        x = rng.uniform(way + 0.5, wide - way - 0.5)
        blocks.append(Block(x, d / 2 if rng.random() < 0.5 else deep - d / 2, w, d))
    return _room("loop", wide, deep, blocks)


def _room(kind: str, wide: float, deep: float, blocks: list[Block]) -> Room:
    outline = Block(wide / 2, deep / 2, wide, deep).walls()
    walls = np.vstack([outline, *(block.walls() for block in blocks)])
    return Room(kind, walls, (wide, deep), tuple(blocks))


def make_room(kind: str, rng: np.random.Generator) -> Room:
    """A room of one of KINDS, 5 to 8 m wide; its lower left corner is the origin."""
    return {"single": _furnished, "two": _two_rooms, "loop": _corridor}[kind](rng)
