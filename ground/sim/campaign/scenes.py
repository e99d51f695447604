# SPDX-License-Identifier: GPL-3.0-or-later
"""Randomly drawn worlds: floor plan, furniture, start pose and the drone's settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from ground.core import GRID_SIDE_CELLS
from ground.sim.campaign.furniture import CLUTTER, IN_THE_MIDDLE, Furnishing, prism
from ground.sim.campaign.layout import Layout, Rect, hall, home, maze, office, shut
from ground.sim.campaign.truth import Bits, TrueMap, flood
from ground.sim.worldspec import Obstacle, Point, WorldSpec

CLEARANCE_M: Final = 0.17
"""The default of way.clearance."""
SURE_M: Final = 0.05
"""Places count as reachable if the drone gets there with this much extra clearance."""
START_GAP_M: Final = 0.4
_CEILING_M: Final = (2.4, 2.8)
_OUTER_M: Final = 0.2
_DOOR_TOP_M: Final = 2.0
_TURN_RAD: Final = math.radians(10.0)
_MARGIN_M: Final = 0.1
_CELL_M: Final = (0.05, 0.1)

Draw = Callable[[np.random.Generator], Layout]
STYLES: Final[Mapping[str, Draw]] = MappingProxyType(
    {"home": home, "office": office, "maze": maze, "clutter": hall}
)


@dataclass(frozen=True, slots=True)
class Scene:
    """A drawn world, with what is known from drawing it."""

    style: str
    layout: Layout
    spec: WorldSpec
    truth: TrueMap
    solid: tuple[Rect, ...]
    """Furniture whose centre cannot be reached."""
    sealed: int | None = None
    """Index of the room whose doors are shut."""

    def reachable(self) -> Bits:
        """The places that the drone can certainly reach."""
        truth = self.truth
        free = truth.solid_gap_m > CLEARANCE_M + SURE_M
        return flood(free, truth.cell(self.spec.start_m))


def draw_scene(style: str, rng: np.random.Generator, *, seal: bool = False) -> Scene:
    """Draw a world of a style; with `seal`, one room is shut if there are doors."""
    while True:
        layout = STYLES[style](rng)
        room = _to_seal(layout, rng) if seal else None
        furnishing = _furnished(style, layout, rng)
        still = [*_walls(layout, rng.uniform(*_CEILING_M)), *furnishing.obstacles]
        if room is not None:
            still += [_upright("shut door", leaf, _DOOR_TOP_M) for leaf in shut(layout, room)]
        truth = TrueMap(tuple(still), layout.outline)
        start_m = _start(layout, truth, room, rng)
        if start_m is None or (seal and layout.doors and room is None):
            continue
        spec = _spec(style, layout.outline, tuple(still), start_m, rng)
        return Scene(style, layout, spec, truth, tuple(furnishing.solid), room)


def _to_seal(layout: Layout, rng: np.random.Generator) -> int | None:
    """Choose a room with a single door, so that the others stay connected without it."""
    ends = [door.rooms for door in layout.doors]
    single = [i for i in range(len(layout.rooms)) if sum(i in pair for pair in ends) == 1]
    return int(rng.choice(single)) if len(layout.rooms) > 1 and single else None


def _furnished(style: str, layout: Layout, rng: np.random.Generator) -> Furnishing:
    furnishing = Furnishing(layout, rng)
    if style == "clutter":
        for _ in range(int(layout.outline.area_m2 * rng.uniform(0.2, 0.6))):
            furnishing.anywhere(layout.outline, CLUTTER)
    elif style != "maze":
        for room in layout.rooms:
            for _ in range(int(room.area_m2 * rng.uniform(0.1, 0.45))):
                furnishing.along_wall(room)
            for _ in range(int(room.area_m2 * rng.uniform(0.0, 0.2))):
                furnishing.anywhere(room, IN_THE_MIDDLE)
    return furnishing


def _walls(layout: Layout, top_m: float) -> list[Obstacle]:
    x0, y0, x1, y1 = layout.outline.x0, layout.outline.y0, layout.outline.x1, layout.outline.y1
    outer = (
        Rect(x0 - _OUTER_M, y0 - _OUTER_M, x1 + _OUTER_M, y0),
        Rect(x0 - _OUTER_M, y1, x1 + _OUTER_M, y1 + _OUTER_M),
        Rect(x0 - _OUTER_M, y0, x0, y1),
        Rect(x1, y0, x1 + _OUTER_M, y1),
    )
    walls = [_upright("outer wall", rect, top_m) for rect in outer]
    walls += [_upright("wall", rect, top_m) for rect in layout.walls]
    lid = Rect(x0 - _OUTER_M, y0 - _OUTER_M, x1 + _OUTER_M, y1 + _OUTER_M)
    return [*walls, prism("ceiling", lid.size_m, (top_m, top_m + 0.2), 0.8, lid.center_m)]


def _upright(name: str, rect: Rect, top_m: float) -> Obstacle:
    return prism(name, rect.size_m, (0.0, top_m), 0.8, rect.center_m)


def _start(
    layout: Layout, truth: TrueMap, sealed: int | None, rng: np.random.Generator
) -> Point | None:
    """Choose a start with room around it, in the largest connected part of the world."""
    fit = truth.solid_gap_m > START_GAP_M
    if sealed is not None:
        fit &= ~truth.within(layout.rooms[sealed])
    regions = truth.regions(fit)
    if not regions:
        return None
    places = np.argwhere(regions[0])
    return truth.place(places[int(rng.integers(len(places)))])


def _spec(
    style: str,
    outline: Rect,
    obstacles: tuple[Obstacle, ...],
    start_m: Point,
    rng: np.random.Generator,
) -> WorldSpec:
    """Start roughly along the walls; the geofence encloses the whole plan."""
    quarter, off_rad = int(rng.integers(4)) * math.pi / 2, rng.uniform(-_TURN_RAD, _TURN_RAD)
    while True:
        yaw_rad = quarter + off_rad
        low, high = _bounds(outline, start_m, yaw_rad)
        side_m = max(high[0] - low[0], high[1] - low[1])
        cell_m = max(_CELL_M[0], math.ceil(100 * side_m / GRID_SIDE_CELLS) / 100)
        if cell_m <= _CELL_M[1]:
            break
        off_rad /= 2
    eeprom = {
        "way.cell": cell_m,
        "way.areaX0": low[0],
        "way.areaY0": low[1],
        "way.areaX1": high[0],
        "way.areaY1": high[1],
    }
    quality = rng.uniform(0.6, 1.0)
    title = f"{style} of {outline.x1:.1f} x {outline.y1:.1f} m"
    return WorldSpec(style, title, start_m, yaw_rad, obstacles, quality, (), eeprom)


def _bounds(outline: Rect, start_m: Point, yaw_rad: float) -> tuple[Point, Point]:
    """The outline's bounding box in the map frame, rounded up to centimetres, with a margin."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    corners = np.array([(x, y) for x in (outline.x0, outline.x1) for y in (outline.y0, outline.y1)])
    there = (corners - start_m) @ np.array([[c, -s], [s, c]])
    low = np.floor(100 * (there.min(axis=0) - _MARGIN_M)) / 100
    high = np.ceil(100 * (there.max(axis=0) + _MARGIN_M)) / 100
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))
