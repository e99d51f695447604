# SPDX-License-Identifier: GPL-3.0-or-later
"""Missions to explore a whole world, come home and land."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from ground.core import CellState, EventCode, MissionCmd
from ground.map.groundmap import GroundMap
from ground.sim.campaign.flights import Flight, Judge, Mission, word_for
from ground.sim.campaign.overlay import lay_over
from ground.sim.campaign.rows import Row
from ground.sim.campaign.scenes import STYLES, Scene, draw_scene
from ground.sim.footprints import Array
from ground.sim.pilot import Pilot
from ground.sim.world import World

COMPLETE: Final = 0.95
"""A world counts as known when this share of its reachable area is."""
LIMIT_S: Final = 400.0
HOME_M: Final = 0.5
_LARGEST_M2: Final = {"maze": 25.0}
_LARGEST_ELSE_M2: Final = 50.0
"""Larger worlds need more than one battery."""


class Coverage:
    """The share of the reachable area that the drone's map knows."""

    def __init__(self, scene: Scene, world: World) -> None:
        self._truth, self._world = scene.truth, world
        self._places_m: Array = scene.truth.points_m[scene.reachable()]

    def of(self, grid: GroundMap) -> float:
        """Share of reachable places whose map cell has been observed."""
        return self._known(grid, self._places_m)

    def of_fitted(self, grid: GroundMap) -> float:
        """The same after fitting the map to the world, which removes its drift as a whole."""
        drawn_m = np.column_stack(self._world.to_world(*grid.obstacles_m().T))
        return self._known(grid, lay_over(drawn_m, self._truth).lifted(self._places_m))

    def _known(self, grid: GroundMap, places_m: Array) -> float:
        x_m, y_m = self._world.to_map(places_m[:, 0], places_m[:, 1])
        columns = np.floor((x_m - grid.origin.x_m) / grid.cell_m).astype(int)
        rows = np.floor((y_m - grid.origin.y_m) / grid.cell_m).astype(int)
        side = len(grid.states)
        inside = (columns >= 0) & (columns < side) & (rows >= 0) & (rows < side)
        states = grid.states[rows.clip(0, side - 1), columns.clip(0, side - 1)]
        return float(np.mean(inside & (states != CellState.UNKNOWN)))


def draw_world(rng: np.random.Generator) -> Scene:
    """Draw a world that one battery suffices for."""
    while True:
        scene = draw_scene(str(rng.choice(list(STYLES))), rng)
        if scene.layout.outline.area_m2 <= _LARGEST_M2.get(scene.style, _LARGEST_ELSE_M2):
            return scene


class Watcher:
    """Watches the map during a flight, and notes when enough of it is known."""

    def __init__(self, mission: Mission, scene: Scene) -> None:
        self.world = mission.world(scene.spec)
        self.pilot = Pilot(self.world, mission.options())
        self.known_s: float | None = None
        self.coverage = Coverage(scene, self.world)
        self._begin_s = self.pilot.time_s
        self.pilot.every_second = self._look

    @property
    def passed_s(self) -> float:
        """Simulated seconds since the command."""
        return self.pilot.time_s - self._begin_s

    def _look(self) -> None:
        if self.known_s is None and self.coverage.of(self.pilot.picture.map) >= COMPLETE:
            self.known_s = round(self.passed_s, 2)


def fly_explore(mission: Mission) -> Flight:
    """Explore as `wayflie explore` does, then again with the baseline's settings, if any."""
    scene = draw_world(mission.rng())
    watcher = Watcher(mission, scene)
    pilot = watcher.pilot
    outcome = pilot.fly(MissionCmd.EXPLORE, limit_s=LIMIT_S)
    end_s, task_s = pilot.time_s, watcher.passed_s
    pilot.land()
    pilot.fetch_map()
    judge = Judge(pilot, watcher.world)
    claimed = any(event.code is EventCode.EXPLORED for event in pilot.picture.events)
    baseline_s, more_s = _baseline(mission, scene) if mission.baseline else (None, 0.0)
    row = Row(
        mission.kind,
        mission.seed,
        mission.number,
        mission.conditions,
        style=scene.style,
        task="explore",
        outcome="explored" if claimed else word_for(outcome),
        reason=outcome.sentence,
        collisions=judge.collisions,
        touches=len(judge.contacts),
        sim_s=round(judge.sim_s + more_s, 3),
        task_s=round(task_s, 2),
        known_s=watcher.known_s,
        flown_m=round(judge.flown_m(end_s), 3),
        miss_m=round(math.dist(judge.place_m(end_s), scene.spec.start_m), 3),
        covered=round(watcher.coverage.of_fitted(pilot.picture.map), 4),
        claimed=claimed,
        baseline_s=baseline_s,
    )
    cause = "collision" if judge.collisions else cause_of(row)
    row = replace(row, cause=cause, ok=not cause)
    return judge.flight(row)


def _baseline(mission: Mission, scene: Scene) -> tuple[float, float]:
    """Seconds until COMPLETE is known (LIMIT_S if it never is), and seconds simulated."""
    other = replace(mission, settings=(*mission.settings, *mission.baseline))
    watcher = Watcher(other, scene)
    while watcher.known_s is None and watcher.passed_s < LIMIT_S:  # command again if it gives up
        watcher.pilot.fly(
            MissionCmd.EXPLORE,
            limit_s=LIMIT_S - watcher.passed_s,
            enough=lambda: watcher.known_s is not None,
        )
        watcher.pilot.rest(1.0)
    known_s = LIMIT_S if watcher.known_s is None else watcher.known_s
    return known_s, watcher.pilot.time_s


def cause_of(row: Row) -> str:
    """Why the mission failed; empty if it succeeded."""
    if row.covered is None or row.covered < COMPLETE:
        return "claimed too early" if row.claimed else "not all known"
    if not row.claimed:
        return "known, but not said"
    return "not home" if row.miss_m is None or row.miss_m > HOME_M else ""
