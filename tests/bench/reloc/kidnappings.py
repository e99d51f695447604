# SPDX-License-Identifier: GPL-3.0-or-later
"""A map from an earlier flight, a drone put down somewhere in it, and the pose that it finds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from tests.bench.reloc.drive import BUDGET, Drawn, be_lost, draw
from tests.bench.slam.beams import BEARINGS_RAD, NONE_M, Rangers, Sensor
from tests.bench.slam.flights import publish
from tests.bench.slam.odometry import drifting
from tests.bench.slam.rooms import Array, Room
from tests.bench.slam.routes import (
    TICK_S,
    Lattice,
    Traveller,
    drone_route,
    walker_route,
    wobble,
)

LIMIT_S: Final = 30.0
NEAR_M: Final = 0.15
NEAR_RAD: Final = math.radians(6.0)
_MAPPING_S: Final = (180.0, 300.0)
_SPEED_MPS: Final = 0.25
_RATE_DPS: Final = 45.0
_LOOK_RAD: Final = math.radians(200.0)
_STEP_M: Final = 0.8
_ROOM_M: Final = 0.45
_GUARD_M: Final = 0.22
_NO_ECHO_M: Final = 1.2
_AROUND_M: Final = 1.0
_WOBBLES: Final = ((0.015, 0.8), (0.015, 0.8), (math.radians(1.0), 0.6))


@dataclass(frozen=True, slots=True)
class Known:
    """A room with its map, and how the map lies in the room."""

    room: Room
    drawn: Drawn
    truth: Array
    """The mapping flight in the room's frame, a pose a tick."""

    def in_map(self, poses: Array) -> Array:
        """Poses of the room in the map's frame. The map is bent, so the rigid motion is taken that
        fits the mapping flight, and what remained of its error around the place."""
        a, b = self.truth[:, :2], self.drawn.poses[:, :2]
        turn_rad, turn = _fit(a, b)
        moved = (a - a.mean(axis=0)) @ turn.T + b.mean(axis=0)
        found = np.array(poses)
        found[:, :2] = (poses[:, :2] - a.mean(axis=0)) @ turn.T + b.mean(axis=0)
        found[:, 2] += turn_rad
        around = np.hypot(*(moved - found[len(found) // 2, :2]).T) < _AROUND_M
        if around.any():
            found[:, :2] += (b - moved)[around].mean(axis=0)
            off = self.drawn.poses[around, 2] - self.truth[around, 2] - turn_rad
            found[:, 2] += np.angle(np.exp(1j * off).mean())
        return found


def _fit(a: Array, b: Array) -> tuple[float, Array]:
    """The rotation that fits points a to b, both about their centroids."""
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    across = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
    angle = math.atan2(across, (a * b).sum())
    c, s = math.cos(angle), math.sin(angle)
    return angle, np.array([[c, -s], [s, c]])


def make_known(room: Room, profile: str, rng: np.random.Generator) -> Known:
    """Let the core map the room in a flight of some minutes."""
    poses = drone_route(room, rng.uniform(*_MAPPING_S), rng)
    ranges_m = publish(Rangers(Sensor(), room.walls, rng), poses, [], rng)
    odometry = drifting(poses, profile, rng)
    x, y, yaw = poses[0]
    c, s = math.cos(yaw), math.sin(yaw)
    corners = (room.walls.reshape(-1, 2) - (x, y)) @ np.array([[c, -s], [s, c]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = 0.5 * (low + high)
    cell_m = max(0.05, math.ceil((float((high - low).max()) + 0.5) / 128 * 1000) / 1000)
    drawn = draw(odometry, ranges_m, (float(middle[0]), float(middle[1])), cell_m)
    return Known(room, drawn, poses)


def _step(drone: Traveller, lattice: Lattice, came_rad: float | None, rangers: Rangers) -> float:
    """Fly a little along the beam that reaches farthest, not back if there is another way.

    @return the direction flown
    """
    pose = np.array([[drone.x_m, drone.y_m, drone.yaw_rad]])
    ranges_m = rangers.measure(pose, [])[0]
    ranges_m = np.where(ranges_m == NONE_M, _NO_ECHO_M, ranges_m)
    here = pose[0, :2]
    for beam in np.argsort(-ranges_m):
        angle = drone.yaw_rad + BEARINGS_RAD[beam]
        back = came_rad is not None and math.cos(angle - came_rad) < -0.7
        if back and np.partition(ranges_m, -2)[-2] > 2 * _ROOM_M:
            continue
        along = np.array([math.cos(angle), math.sin(angle)])
        length_m = min(_STEP_M, float(ranges_m[beam]) - _ROOM_M)
        while length_m > 0.1 and not lattice.clear(here, here + length_m * along):
            length_m -= 0.1
        if length_m > 0.1:
            drone.go(here + length_m * along)
            return float(angle)
    return came_rad or 0.0


def lost_route(
    room: Room, start: Array, seconds: float, rangers: Rangers, rng: np.random.Generator
) -> Array:
    """Poses of a drone that looks for itself: a full turn, then short moves and turns, to and fro
    so that the gyro's scale does not add up."""
    guarded = Lattice(room, _GUARD_M)
    drone = Traveller(float(start[0]), float(start[1]), rng.uniform(-math.pi, math.pi), _SPEED_MPS)
    drone.hover(0.2)
    drone.turn(math.tau, _RATE_DPS)
    came_rad, way = None, -1.0
    while len(drone.poses) * TICK_S < seconds:
        came_rad = _step(drone, guarded, came_rad, rangers)
        drone.turn(way * _LOOK_RAD, _RATE_DPS)
        way = -way
    poses = np.array(drone.poses[: round(seconds / TICK_S)])
    for column, (sigma, tau_s) in enumerate(_WOBBLES):
        poses[:, column] += wobble(len(poses), sigma, tau_s, rng)
    return poses


@dataclass(frozen=True, slots=True)
class Outcome:
    """One kidnapping, at the first moment at which the core was sure; NaN if it never was, and
    infinitely far off where no pose of the map is right."""

    kind: str
    sure_s: float
    off_m: float
    off_rad: float

    @property
    def sure(self) -> bool:
        return not math.isnan(self.sure_s)

    @property
    def right(self) -> bool:
        return self.sure and self.off_m < NEAR_M and self.off_rad < NEAR_RAD


@dataclass(frozen=True, slots=True)
class Scene:
    """Where the drone is put down."""

    room: Room
    """As it is now."""
    places: Array
    """x, y of where it may be put."""
    people: int = 0
    on_map: bool = True
    """The map knows something of the room."""


def plain(room: Room) -> Scene:
    """A scene anywhere in an unchanged room."""
    return Scene(room, Lattice(room).points)


@dataclass(frozen=True, slots=True)
class LostFlight:
    """The inputs of a lost drone, a row per tick, and the truth in the room's frame."""

    truth: Array
    odometry: Array
    ranges_m: Array


def lost_flight(scene: Scene, profile: str, rng: np.random.Generator) -> LostFlight:
    """Put the drone down somewhere in the scene and fly."""
    rangers = Rangers(Sensor(), scene.room.walls, rng)
    start = scene.places[rng.integers(len(scene.places))]
    poses = lost_route(scene.room, start, LIMIT_S, rangers, rng)
    people = [walker_route(scene.room, len(poses), poses, rng) for _ in range(scene.people)]
    ranges_m = publish(rangers, poses, people, rng)
    return LostFlight(poses, drifting(poses, profile, rng), ranges_m)


def kidnap(known: Known, scene: Scene, profile: str, rng: np.random.Generator) -> Outcome:
    """Run the core on such a flight, with the map of the known room."""
    flight = lost_flight(scene, profile, rng)
    lost = be_lost(known.drawn, flight.odometry, flight.ranges_m, BUDGET)
    moments = np.flatnonzero(lost.sure)
    if len(moments) == 0:
        return Outcome(known.room.kind, math.nan, math.nan, math.nan)
    first = int(moments[0])
    if not scene.on_map:
        return Outcome(known.room.kind, first * TICK_S, math.inf, math.inf)
    off = lost.poses[first] - known.in_map(flight.truth[: first + 1])[first]
    turned = abs(math.remainder(float(off[2]), math.tau))
    return Outcome(known.room.kind, first * TICK_S, float(np.hypot(*off[:2])), turned)
