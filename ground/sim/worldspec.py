# SPDX-License-Identifier: GPL-3.0-or-later
"""What a world is made of: plain frozen data, world frame, metres, seconds, radians."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

WALL_REFLECTIVITY: Final = 0.8

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Trigger:
    """Something happens once the drone has come within radius_m of a place."""

    center_m: Point
    radius_m: float


@dataclass(frozen=True, slots=True)
class Motion:
    """A way along points, from the obstacle's own place, at one speed, once or round and round.

    It begins at start_s, or that long after its trigger, and rests for pause_s at every point.
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
        """True unless it stands where it is for ever."""
        return self.motion is not None or self.appears_s > 0 or math.isfinite(self.vanishes_s)


@dataclass(frozen=True, slots=True)
class Patch:
    """A rectangle of floor with another texture quality."""

    low_m: Point
    high_m: Point
    quality: float


@dataclass(frozen=True, slots=True)
class WorldSpec:
    """All that a world file says."""

    name: str
    title: str
    start_m: Point
    start_yaw_rad: float
    obstacles: tuple[Obstacle, ...]
    floor_quality: float = 1.0
    patches: tuple[Patch, ...] = ()
    eeprom: Mapping[str, float] = field(default_factory=dict)
    demo_goal_m: Point | None = None
