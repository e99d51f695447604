# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulated flights of three to six minutes: the core's inputs, and the truth for comparison."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ground.sim.sensors import RANGE_AGE_STEPS, RANGE_PERIOD_STEPS
from tests.bench.slam.beams import NONE_M, Rangers, Sensor
from tests.bench.slam.odometry import drifting
from tests.bench.slam.rooms import KINDS, Array, Room, make_room
from tests.bench.slam.routes import drone_route, walker_route

LENGTH_S: Final = (180.0, 360.0)
"""Shortest and longest flight."""
STEPS_PER_TICK: Final = 2
"""Sensors live in steps of 10 ms, the core in ticks of 20 ms."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A way of making a flight harder."""

    name: str
    sensor: Sensor = field(default_factory=Sensor)
    shear_deg: float = 0.0
    people: int = 0


PLAIN: Final = Variant("plain")
STRESS: Final = (
    Variant("oblique", shear_deg=14.0),
    Variant("wide", Sensor(cone_half_deg=13.5, noise_relative=(0.03, 0.03))),
    Variant("short", Sensor(false_short=0.2)),
    Variant("people", people=2),
)


@dataclass(frozen=True, slots=True)
class Flight:
    """One flight, a pose (x, y, yaw) per tick; truth and walls in the frame of the first pose."""

    name: str
    kind: str
    truth: Array
    odometry: Array
    ranges_m: Array
    """As published, held until the next set: front, back, left, right."""
    walls: Array
    cell_m: float
    centre_m: tuple[float, float]


def _sheared(room: Room, poses: Array, shear_deg: float) -> tuple[Array, Array]:
    """Walls and poses of a room sheared by this much."""
    slope = math.tan(math.radians(shear_deg))
    walls, moved = room.walls.copy(), poses.copy()
    walls[:, 0] += slope * walls[:, 1]
    walls[:, 2] += slope * walls[:, 3]
    moved[:, 0] += slope * moved[:, 1]
    return walls, moved


def publish(rangers: Rangers, poses: Array, people: list[Array], rng: np.random.Generator) -> Array:
    """A new set every 100 ms, measured 70 to 90 ms earlier, seen up to a tick late."""
    ticks = len(poses)
    period = RANGE_PERIOD_STEPS // STEPS_PER_TICK
    shown = np.arange(int(rng.integers(period)), ticks, period)
    first, last = RANGE_AGE_STEPS
    age_ticks = rng.integers(first, last + 1, len(shown)) / STEPS_PER_TICK + rng.random()
    measured = np.maximum(shown - age_ticks, 0.0)
    at = np.arange(ticks)
    then = np.stack([np.interp(measured, at, column) for column in poses.T], axis=1)
    places = [
        np.stack([np.interp(measured, at, column) for column in person.T], axis=1)
        for person in people
    ]
    sets = np.vstack([np.full((1, 4), NONE_M), rangers.measure(then, places)])
    held: Array = sets[np.searchsorted(shown, at, side="right")]
    return held


def _into_first_pose(poses: Array, walls: Array) -> tuple[Array, Array]:
    """Convert to the frame of the first pose, where the core's map begins."""
    x, y, yaw = poses[0]
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s], [s, c]])
    moved = np.column_stack([(poses[:, :2] - (x, y)) @ turn, poses[:, 2] - yaw])
    corners = (walls.reshape(-1, 2) - (x, y)) @ turn
    return moved, corners.reshape(-1, 4)


def _cell_m(walls: Array) -> tuple[float, tuple[float, float]]:
    """Cell size (at least 5 cm) with which the grid holds the room, and the room's centre."""
    corners = walls.reshape(-1, 2)
    low, high = corners.min(axis=0), corners.max(axis=0)
    wide_m = float((high - low).max()) + 0.5
    middle = 0.5 * (low + high)
    return max(0.05, math.ceil(wide_m / 128 * 100) / 100), (float(middle[0]), float(middle[1]))


def make_flight(seed: int, profile: str, variant: Variant = PLAIN) -> Flight:
    """The flight with this seed; profile and variant do not change room and route."""
    worlds, faults, drift = (np.random.default_rng((seed, part)) for part in range(3))
    kind = KINDS[seed % len(KINDS)]
    room = make_room(kind, worlds)
    poses = drone_route(room, worlds.uniform(*LENGTH_S), worlds)
    people = [walker_route(room, len(poses), poses, faults) for _ in range(variant.people)]
    walls, poses = _sheared(room, poses, variant.shear_deg)
    rangers = Rangers(variant.sensor, walls, faults)
    ranges_m = publish(rangers, poses, people, faults)
    odometry = drifting(poses, profile, drift)
    truth, walls = _into_first_pose(poses, walls)
    cell_m, centre_m = _cell_m(walls)
    name = f"{profile} {variant.name} {seed}"
    return Flight(name, kind, truth, odometry, ranges_m, walls, cell_m, centre_m)
