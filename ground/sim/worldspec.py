# SPDX-License-Identifier: GPL-3.0-or-later
"""What a world consists of: plain frozen data in the world frame; metres, seconds, radians."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

WALL_REFLECTIVITY: Final = 0.8

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Trigger:
    """A condition that is met once the drone has come within radius_m of a place."""

    center_m: Point
    radius_m: float


@dataclass(frozen=True, slots=True)
class Motion:
    """A path through points from the obstacle's own place, at one speed, once or in a loop.

    It begins at start_s, or start_s after its trigger, and pauses for pause_s at every point.
    """

    path_m: tuple[Point, ...]
    speed_mps: float
    start_s: float = 0.0
    loop: bool = False
    trigger: Trigger | None = None
    pause_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Obstacle:
    """An upright prism from bottom_m to top_m: a rectangle, or a disc if radius_m > 0."""

    name: str
    center_m: Point
    half_m: Point
    yaw_rad: float
    radius_m: float
    bottom_m: float
    top_m: float
    reflectivity: float = WALL_REFLECTIVITY
    appears_s: float = 0.0
    vanishes_s: float = math.inf
    motion: Motion | None = None

    @property
    def changes(self) -> bool:
        """Whether it ever moves, appears or vanishes."""
        return self.motion is not None or self.appears_s > 0 or math.isfinite(self.vanishes_s)


@dataclass(frozen=True, slots=True)
class Patch:
    """A rectangle of floor with another texture quality."""

    low_m: Point
    high_m: Point
    quality: float


@dataclass(frozen=True, slots=True)
class WorldSpec:
    """Everything that a world file says."""

    name: str
    title: str
    start_m: Point
    start_yaw_rad: float
    obstacles: tuple[Obstacle, ...]
    floor_quality: float = 1.0
    patches: tuple[Patch, ...] = ()
    eeprom: Mapping[str, float] = field(default_factory=dict)
    demo_goal_m: Point | None = None
