# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms with a walking person, and flights of the core that record how near the person comes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ground.core import CData, MissionCmd, MissionState, ffi, lib
from ground.sim.model import Setpoint
from ground.sim.plant import Plant
from ground.sim.world import World
from ground.sim.worldspec import Motion, Obstacle, Point, WorldSpec
from tests.firmware.flights import STEPS_PER_TICK, measure, steer

PERSON_RADIUS_M: Final = 0.24
PERSON: Final = "person"
_WALL_M: Final = 0.2


def box(name: str, low: Point, high: Point, height_m: float = 2.5) -> Obstacle:
    """An upright box between two corners."""
    center = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
    half = ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2)
    return Obstacle(name, center, half, 0.0, 0.0, 0.0, height_m)


def room(west: float, south: float, east: float, north: float) -> tuple[Obstacle, ...]:
    """Four walls around this inside; the drone takes off at 0, 0."""
    out = _WALL_M
    return (
        box("west wall", (west - out, south - out), (west, north + out)),
        box("east wall", (east, south - out), (east + out, north + out)),
        box("south wall", (west - out, south - out), (east + out, south)),
        box("north wall", (west - out, north), (east + out, north + out)),
    )


def person(
    way: Sequence[Point], start_s: float, speed_mps: float = 0.5, gone_s: float = math.inf
) -> Obstacle:
    """A person who enters at the first point, walks along the others once, and disappears later."""
    motion = Motion(tuple(way[1:]), speed_mps, start_s)
    body = Obstacle(PERSON, way[0], (0.0, 0.0), 0.0, PERSON_RADIUS_M, 0.0, 1.75, 0.5)
    return replace(body, motion=motion, appears_s=start_s, vanishes_s=gone_s)


def visit(bearing_deg: float, from_m: float, up_to_m: float) -> list[Point]:
    """The path to within a distance of the take-off place, and back."""
    angle = math.radians(bearing_deg)
    far, near = ((r * math.cos(angle), r * math.sin(angle)) for r in (from_m, up_to_m))
    return [far, near, far]


class Watched:
    """The core in a simulated body in such a room, recorded."""

    def __init__(self, obstacles: Sequence[Obstacle], seed: int) -> None:
        self._world = World(WorldSpec("people", "people", (0.0, 0.0), 0.0, tuple(obstacles)))
        self._people = [row for row, it in enumerate(obstacles) if it.name == PERSON]
        self.plant = Plant(self._world, seed)
        self.nav = ffi.new("nav_t *")
        self._input = ffi.new("nav_input_t *")
        self._setpoint = Setpoint()
        self.nearest_m = {False: math.inf, True: math.inf}
        """Of the body's centre to anything that stands, and to people, while it flew."""
        self.states: list[MissionState] = []
        lib.nav_init(self.nav, _configuration(seed))

    @property
    def time_s(self) -> float:
        return self.plant.time_s

    @property
    def state(self) -> MissionState:
        return MissionState(self.nav.mission.state)

    @property
    def place_m(self) -> tuple[float, float]:
        """The true position."""
        return self.plant.truth.position_m[:2]

    def obstacles_m(self) -> set[tuple[float, float]]:
        """Centres of the occupied cells of its map."""
        grid, found = ffi.addressof(self.nav, "grid"), set()
        for iy in range(lib.GRID_SIDE_CELLS):
            for ix in range(lib.GRID_SIDE_CELLS):
                if lib.grid_state(grid, ix, iy) == lib.GRID_CELL_OCCUPIED:
                    middle = lib.grid_centre_m(grid, ffi.new("grid_cell_t *", (ix, iy))[0])
                    found.add((middle.x, middle.y))
        return found

    def command(self, cmd: MissionCmd, goal: Point = (0.0, 0.0)) -> None:
        order = ffi.new("nav_command_t *", (cmd, goal))
        assert lib.nav_command(self.nav, order) == lib.MISSION_OK

    def fly_until(self, time_s: float) -> None:
        while self.time_s < time_s:
            self._tick()

    def hover(self) -> None:
        """Take off and look around."""
        self.fly_until(2.0)
        self.command(MissionCmd.TAKE_OFF)
        while self.state != MissionState.HOVER:
            self._tick()

    def _tick(self) -> None:
        for _ in range(STEPS_PER_TICK):
            self.plant.step(self._setpoint, True)
        measure(self.plant, self._input)
        self._setpoint = steer(lib.nav_step(self.nav, self._input))
        if not self.states or self.states[-1] != self.state:
            self.states.append(self.state)
        if self.plant.truth.position_m[2] > 0.2:
            gaps_m = self._world.footprints.signed_m(*self.place_m)
            for row, gap_m in enumerate(gaps_m):
                alive = row in self._people
                self.nearest_m[alive] = min(self.nearest_m[alive], float(gap_m))


def _configuration(seed: int) -> CData:
    cfg = ffi.new("nav_config_t *")
    lib.nav_config_default(cfg)
    cfg.seed = seed
    return cfg
