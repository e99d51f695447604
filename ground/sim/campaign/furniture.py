# SPDX-License-Identifier: GPL-3.0-or-later
"""Randomly drawn furniture, along walls and in the middle of rooms, never in front of doors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from ground.sim.campaign.layout import Layout, Rect
from ground.sim.worldspec import Obstacle, Point

_BEFORE_DOOR_M: Final = 0.75
_APART_M: Final = 0.05
_TRIES: Final = 12


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of furniture: prisms about its centre, and the size of its footprint."""

    size_m: Point
    parts: tuple[Obstacle, ...]

    def standing(self, center_m: Point, yaw_rad: float) -> tuple[Obstacle, ...]:
        """The prisms of the piece at a place."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        return tuple(
            Obstacle(
                part.name,
                (
                    center_m[0] + c * part.center_m[0] - s * part.center_m[1],
                    center_m[1] + s * part.center_m[0] + c * part.center_m[1],
                ),
                part.half_m,
                yaw_rad + part.yaw_rad if not part.radius_m else 0.0,
                part.radius_m,
                part.bottom_m,
                part.top_m,
                part.reflectivity,
            )
            for part in self.parts
        )


def prism(
    name: str,
    size_m: Point,
    levels_m: Point,
    reflectivity: float,
    center_m: Point = (0.0, 0.0),
) -> Obstacle:
    """An upright box between two heights."""
    half = (size_m[0] / 2, size_m[1] / 2)
    return Obstacle(name, center_m, half, 0.0, 0.0, *levels_m, reflectivity)


def pole(
    name: str,
    radius_m: float,
    levels_m: Point,
    reflectivity: float,
    center_m: Point = (0.0, 0.0),
) -> Obstacle:
    """An upright cylinder between two heights."""
    return Obstacle(name, center_m, (radius_m,) * 2, 0.0, radius_m, *levels_m, reflectivity)


def _box(name: str, wide: Point, deep: Point, high: Point) -> Callable[..., Piece]:
    def draw(rng: np.random.Generator) -> Piece:
        size = (rng.uniform(*wide), rng.uniform(*deep))
        levels = (0.0, rng.uniform(*high))
        return Piece(size, (prism(name, size, levels, rng.uniform(0.3, 0.9)),))

    return draw


def _on_legs(name: str, wide: Point, deep: Point, leg_m: float) -> Callable[..., Piece]:
    def draw(rng: np.random.Generator) -> Piece:
        size = (rng.uniform(*wide), rng.uniform(*deep))
        top = rng.uniform(0.72, 0.76)
        shade = rng.uniform(0.3, 0.9)
        x, y = size[0] / 2 - leg_m, size[1] / 2 - leg_m
        legs = [
            pole(f"{name}, leg", leg_m, (0.0, top - 0.03), shade, (i * x, j * y))
            for i in (-1, 1)
            for j in (-1, 1)
        ]
        return Piece(size, (*legs, prism(name, size, (top - 0.03, top), shade)))

    return draw


def _chair(rng: np.random.Generator) -> Piece:
    """Four legs, a seat at flight height, and a back."""
    side, shade = rng.uniform(0.38, 0.45), rng.uniform(0.3, 0.9)
    seat, leg_m = rng.uniform(0.44, 0.48), rng.uniform(0.015, 0.025)
    at = side / 2 - leg_m
    legs = [
        pole("chair, leg", leg_m, (0.0, seat - 0.03), shade, (i * at, j * at))
        for i in (-1, 1)
        for j in (-1, 1)
    ]
    plate = prism("chair, seat", (side, side), (seat - 0.03, seat), shade)
    back = prism("chair, back", (side, 0.03), (seat, seat + 0.45), shade, (0.0, side / 2 - 0.015))
    return Piece((side, side), (*legs, plate, back))


def _round(name: str, radius: Point, high: Point) -> Callable[..., Piece]:
    def draw(rng: np.random.Generator) -> Piece:
        radius_m = rng.uniform(*radius)
        levels = (0.0, rng.uniform(*high))
        return Piece((2 * radius_m,) * 2, (pole(name, radius_m, levels, rng.uniform(0.3, 0.9)),))

    return draw


ALONG_WALLS: Final = (
    _box("sofa", (1.4, 2.1), (0.75, 0.95), (0.7, 0.9)),
    _box("bed", (1.2, 2.0), (0.9, 1.5), (0.5, 0.65)),
    _box("wardrobe", (0.8, 1.8), (0.5, 0.65), (1.8, 2.2)),
    _box("shelf", (0.5, 1.2), (0.25, 0.4), (0.9, 2.0)),
    _box("cabinet", (0.4, 0.9), (0.35, 0.5), (0.6, 1.1)),
    _on_legs("desk", (1.0, 1.6), (0.6, 0.8), 0.025),
    _round("plant", (0.12, 0.22), (0.6, 1.4)),
    _round("lamp", (0.02, 0.04), (1.4, 1.8)),
)
IN_THE_MIDDLE: Final = (
    _on_legs("table", (0.8, 1.6), (0.7, 0.9), 0.03),
    _chair,
    _chair,
    _box("armchair", (0.65, 0.85), (0.65, 0.85), (0.7, 0.9)),
    _box("low table", (0.6, 1.0), (0.4, 0.6), (0.15, 0.25)),
    _round("plant", (0.12, 0.22), (0.6, 1.4)),
)
CLUTTER: Final = (
    _round("pole", (0.03, 0.12), (0.8, 2.0)),
    _box("post", (0.08, 0.3), (0.08, 0.3), (0.8, 2.0)),
    _box("crate", (0.3, 0.8), (0.3, 0.6), (0.55, 1.2)),
    _chair,
)


class Furnishing:
    """Fills rooms with furniture that keeps doors free and does not overlap."""

    def __init__(self, layout: Layout, rng: np.random.Generator) -> None:
        self.obstacles: list[Obstacle] = []
        self.solid: list[Rect] = []
        """Solid pieces, whose centre cannot be reached."""
        self._rng = rng
        self._taken: list[Rect] = []
        self._kept_free = [
            Rect(x - _BEFORE_DOOR_M, y - _BEFORE_DOOR_M, x + _BEFORE_DOOR_M, y + _BEFORE_DOOR_M)
            for x, y in (door.gap.center_m for door in layout.doors)
        ]

    def along_wall(self, room: Rect) -> None:
        """Put a piece with its back to a wall of the room, if there is a place for it."""
        piece = self._draw(ALONG_WALLS)
        for _ in range(_TRIES):
            side = int(self._rng.integers(4))
            wide, deep = piece.size_m if side < 2 else piece.size_m[::-1]
            if wide > room.size_m[0] or deep > room.size_m[1]:
                continue
            x = self._rng.uniform(room.x0 + wide / 2, room.x1 - wide / 2)
            y = self._rng.uniform(room.y0 + deep / 2, room.y1 - deep / 2)
            x, y = (
                (x, room.y0 + deep / 2),
                (x, room.y1 - deep / 2),
                (room.x0 + wide / 2, y),
                (room.x1 - wide / 2, y),
            )[side]
            if self._stand(piece, (x, y), (0.0, math.pi, -math.pi / 2, math.pi / 2)[side]):
                return

    def anywhere(self, room: Rect, kinds: tuple[Callable[..., Piece], ...]) -> None:
        """Put a piece of any orientation somewhere in the room, if there is a place for it."""
        piece = self._draw(kinds)
        reach = math.hypot(*piece.size_m) / 2
        for _ in range(_TRIES):
            if 2 * reach > min(room.size_m):
                return
            x = self._rng.uniform(room.x0 + reach, room.x1 - reach)
            y = self._rng.uniform(room.y0 + reach, room.y1 - reach)
            if self._stand(piece, (x, y), self._rng.uniform(-math.pi, math.pi)):
                return

    def _draw(self, kinds: tuple[Callable[..., Piece], ...]) -> Piece:
        return kinds[int(self._rng.integers(len(kinds)))](self._rng)

    def _stand(self, piece: Piece, center_m: Point, yaw_rad: float) -> bool:
        c, s = abs(math.cos(yaw_rad)), abs(math.sin(yaw_rad))
        half_x = (c * piece.size_m[0] + s * piece.size_m[1]) / 2
        half_y = (s * piece.size_m[0] + c * piece.size_m[1]) / 2
        x, y = center_m
        place = Rect(x - half_x, y - half_y, x + half_x, y + half_y)
        if any(place.near(zone) for zone in self._kept_free):
            return False
        if any(place.near(other, _APART_M) for other in self._taken):
            return False
        self._taken.append(place)
        self.obstacles.extend(piece.standing(center_m, yaw_rad))
        if len(piece.parts) == 1 and min(piece.size_m) > 0.4 and piece.parts[0].top_m > 0.55:
            self.solid.append(place)
        return True
