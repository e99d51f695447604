# SPDX-License-Identifier: GPL-3.0-or-later
"""A world at one time: ray casts (MuJoCo), what a body in it touches, distances to surfaces.

World frame: that of the world file. Map frame: its origin and x axis are the drone's start pose.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from ground.sim.footprints import Array, Footprints
from ground.sim.worldfile import read_world
from ground.sim.worldspec import Obstacle, Point, WorldSpec

FLOOR_REFLECTIVITY: Final = 0.6
FLIGHT_HEIGHT_M: Final = 0.5
_PARKED_M: Final = -100.0
_STEP_UP_M: Final = 0.02
"""A body up to this much below an edge is lifted onto it."""

Number = TypeVar("Number", float, Array)


@dataclass(frozen=True, slots=True)
class Rays:
    """Result of a cast, one entry per ray; distance_m is inf without a hit."""

    distance_m: Array
    cos_incidence: Array
    reflectivity: Array


@dataclass(frozen=True, slots=True)
class Touch:
    """An overlap of body and obstacle by depth_m; the normal points from obstacle to body."""

    row: int
    name: str
    normal: tuple[float, float, float]
    depth_m: float
    velocity_mps: Point


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What is around a body, and how far it can move before that may change (slack_m)."""

    floor_m: float
    touches: tuple[Touch, ...]
    slack_m: float


class World:
    """One world; belongs to one plant, since its obstacles move with that plant's time."""

    def __init__(self, spec: WorldSpec) -> None:
        self.footprints = Footprints(spec.obstacles)
        self._furnish(spec)
        self._cos_start = math.cos(spec.start_yaw_rad)
        self._sin_start = math.sin(spec.start_yaw_rad)
        self.set_time(0.0)

    def _furnish(self, spec: WorldSpec) -> None:
        self.spec = spec
        self._model, self._mocap_of_row = _build(spec.obstacles)
        self._data = mujoco.MjData(self._model)
        self._reflectivity = np.full(self._model.ngeom, FLOOR_REFLECTIVITY)
        for row, obstacle in enumerate(spec.obstacles):
            self._reflectivity[self._model.geom(str(row)).id] = obstacle.reflectivity
        mujoco.mj_kinematics(self._model, self._data)

    def put(self, added: tuple[Obstacle, ...]) -> None:
        """Add obstacles from now on, after all others."""
        self._refurnish((*self.spec.obstacles, *added))

    def take_away(self, gone: tuple[Obstacle, ...], time_s: float) -> None:
        """Remove obstacles that put() has added."""
        self._refurnish(
            tuple(replace(o, vanishes_s=time_s) if o in gone else o for o in self.spec.obstacles)
        )

    def _refurnish(self, obstacles: tuple[Obstacle, ...]) -> None:
        self.footprints = Footprints(obstacles, self.footprints)
        self._furnish(replace(self.spec, obstacles=obstacles))

    def set_time(self, time_s: float, drone_m: Point | None = None) -> None:
        """Move obstacles to where they are at this time; absent ones are parked below the floor."""
        places = self.footprints
        rows = places.move_to(time_s, drone_m)
        for row in rows:
            z = (places.bottom_m[row] + places.top_m[row]) / 2 if places.present[row] else _PARKED_M
            self._data.mocap_pos[self._mocap_of_row[row]] = (*places.center_m[row], z)
        if rows or time_s == 0.0:
            mujoco.mj_kinematics(self._model, self._data)

    def cast(self, origin_m: tuple[float, float, float], directions: Array, limit_m: float) -> Rays:
        """Cast rays from one point along unit vectors (N x 3)."""
        count = len(directions)
        geom = np.empty(count, np.int32)
        distance = np.empty(count)
        normal = np.empty(3 * count)
        mujoco.mj_multiRay(
            self._model,
            self._data,
            np.array(origin_m),
            np.ascontiguousarray(directions).reshape(-1),
            None,
            True,
            -1,
            geom,
            distance,
            normal,
            count,
            limit_m,
        )
        cos_incidence = np.abs(np.einsum("ij,ij->i", directions, normal.reshape(-1, 3)))
        missed = geom < 0
        distance[missed] = np.inf
        cos_incidence[missed] = 0.0
        return Rays(distance, cos_incidence, self._reflectivity[geom])

    def surroundings(
        self, x_m: float, y_m: float, z_m: float, radius_m: float, height_m: float
    ) -> Surroundings:
        """Examine the surroundings of an upright cylinder that stands at x, y, z.

        As long as it and the obstacles together move less than slack_m, the floor under it stays
        the same and it touches nothing new.
        """
        places = self.footprints
        signed = places.signed_m(x_m, y_m)
        above_m, below_m = z_m - places.top_m, places.bottom_m - (z_m + height_m)
        gap_m = np.maximum(above_m, below_m)
        inside = np.minimum(-signed - radius_m, np.maximum(gap_m, 0.0))
        slack = np.where(signed > radius_m, signed - radius_m, np.maximum(inside, 0.0))
        under = (signed < 0) & (above_m > -_STEP_UP_M)
        touched = np.flatnonzero((signed < radius_m) & (gap_m < 0) & ~under)
        touches = tuple(
            self._touch(int(row), x_m, y_m, radius_m - float(signed[row]), float(-gap_m[row]))
            for row in touched
        )
        floor_m = float(np.max(places.top_m, where=under, initial=0.0))
        return Surroundings(floor_m, touches, float(np.min(slack, initial=np.inf)))

    def _touch(self, row: int, x_m: float, y_m: float, side_m: float, level_m: float) -> Touch:
        """Choose the shorter way out of an overlap: sideways, or down from under the obstacle."""
        places = self.footprints
        vx, vy = places.velocity_mps[row]
        name = places.obstacles[row].name
        if places.bottom_m[row] > 0 and level_m < side_m:
            return Touch(row, name, (0.0, 0.0, -1.0), level_m, (float(vx), float(vy)))
        nx, ny = places.normal(row, x_m, y_m)
        return Touch(row, name, (nx, ny, 0.0), side_m, (float(vx), float(vy)))

    def floor_quality(self, x_m: float, y_m: float) -> float:
        """Texture of the floor there for the flow sensor, from 0 (none) to 1 (plenty)."""
        for patch in self.spec.patches:
            (x0, y0), (x1, y1) = patch.low_m, patch.high_m
            if x0 <= x_m <= x1 and y0 <= y_m <= y1:
                return patch.quality
        return self.spec.floor_quality

    def surface_distance_m(self, points_m: Array, height_m: float = FLIGHT_HEIGHT_M) -> Array:
        """Distance of world points (N x 2) to the nearest true surface at that height, now."""
        return self.footprints.surface_distance_m(np.asarray(points_m, float), height_m)

    def to_map(self, x_m: Number, y_m: Number) -> tuple[Number, Number]:
        """Convert from the world frame to the map frame; floats or arrays."""
        dx, dy = x_m - self.spec.start_m[0], y_m - self.spec.start_m[1]
        c, s = self._cos_start, self._sin_start
        return c * dx + s * dy, c * dy - s * dx

    def to_world(self, x_m: Number, y_m: Number) -> tuple[Number, Number]:
        """Convert from the map frame to the world frame; floats or arrays."""
        c, s = self._cos_start, self._sin_start
        x0, y0 = self.spec.start_m
        return x0 + c * x_m - s * y_m, y0 + s * x_m + c * y_m


def load_world(name_or_path: str | Path) -> World:
    """Load worlds/NAME.toml or a file; raise WorldError if something is wrong with it."""
    return World(read_world(name_or_path))


def _build(obstacles: tuple[Obstacle, ...]) -> tuple[Any, NDArray[np.int32]]:
    """Build the MuJoCo model, a geom named by its row per obstacle, and each row's mocap index."""
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    mocap_of_row = np.full(len(obstacles), -1, np.int32)
    used = 0
    for row, obstacle in enumerate(obstacles):
        place = [*obstacle.center_m, (obstacle.bottom_m + obstacle.top_m) / 2]
        turn = [math.cos(obstacle.yaw_rad / 2), 0, 0, math.sin(obstacle.yaw_rad / 2)]
        half_height_m = (obstacle.top_m - obstacle.bottom_m) / 2
        if obstacle.radius_m > 0:
            kind, size = mujoco.mjtGeom.mjGEOM_CYLINDER, [obstacle.radius_m, half_height_m, 0]
        else:
            kind, size = mujoco.mjtGeom.mjGEOM_BOX, [*obstacle.half_m, half_height_m]
        if obstacle.changes:
            body = spec.worldbody.add_body(mocap=True, pos=place, quat=turn)
            body.add_geom(name=str(row), type=kind, size=size)
            mocap_of_row[row], used = used, used + 1
        else:
            spec.worldbody.add_geom(name=str(row), type=kind, size=size, pos=place, quat=turn)
    return spec.compile(), mocap_of_row
