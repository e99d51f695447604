# SPDX-License-Identifier: GPL-3.0-or-later
"""Missions to know a whole world, come home and land."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from ground.core import CellState, EventCode, MissionCmd
from ground.map import GroundMap
from ground.sim.campaign.flights import Flight, Judge, Mission, word_for
from ground.sim.campaign.rows import Row
from ground.sim.campaign.scenes import STYLES, Scene, draw_scene
from ground.sim.footprints import Array
from ground.sim.pilot import Pilot

COMPLETE: Final = 0.95
"""A world is known when that share of its reachable area is."""
LIMIT_S: Final = 400.0
HOME_M: Final = 0.5
_LARGEST_M2: Final = {"maze": 25.0}
_LARGEST_ELSE_M2: Final = 50.0
"""What one battery lasts for."""


class Coverage:
    """How much of the area that can be reached is in the drone's map."""

    def __init__(self, scene: Scene) -> None:
        reached = np.argwhere(scene.reachable())
        places = scene.truth.points_m[tuple(reached.T)]
        c, s = math.cos(scene.spec.start_yaw_rad), math.sin(scene.spec.start_yaw_rad)
        turned = (places - scene.spec.start_m) @ np.array([[c, -s], [s, c]])
        self._places_m: Array = turned

    def of(self, grid: GroundMap) -> float:
        """Share of the places in whose cell something was observed."""
        low = (grid.origin.x_m, grid.origin.y_m)
        columns, rows = np.floor((self._places_m - low) / grid.cell_m).astype(int).T
        side = len(grid.states)
        inside = (columns >= 0) & (columns < side) & (rows >= 0) & (rows < side)
        states = grid.states[rows.clip(0, side - 1), columns.clip(0, side - 1)]
        return float(np.mean(inside & (states != CellState.UNKNOWN)))


def draw_world(rng: np.random.Generator) -> Scene:
    """One that is not too large."""
    while True:
        scene = draw_scene(str(rng.choice(list(STYLES))), rng)
        if scene.layout.outline.area_m2 <= _LARGEST_M2.get(scene.style, _LARGEST_ELSE_M2):
            return scene


def fly_explore(mission: Mission) -> Flight:
    """As `wayflie explore` does."""
    scene = draw_world(mission.rng())
    world = mission.world(scene.spec)
    coverage = Coverage(scene)
    pilot = Pilot(world, mission.options())
    begin_s = pilot.time_s
    known_at_s: list[float] = []

    def look() -> None:
        if not known_at_s and coverage.of(pilot.picture.map) >= COMPLETE:
            known_at_s.append(pilot.time_s - begin_s)

    pilot.every_second = look
    outcome = pilot.fly(MissionCmd.EXPLORE, limit_s=LIMIT_S)
    end_s = pilot.time_s
    pilot.land()
    pilot.fetch_map()
    judge = Judge(pilot, world)
    covered = coverage.of(pilot.picture.map)
    claimed = any(event.code is EventCode.EXPLORED for event in pilot.picture.events)
    home_m = math.dist(judge.place_m(end_s), scene.spec.start_m)
    row = Row(
        mission.kind,
        mission.seed,
        mission.number,
        style=scene.style,
        task="explore",
        outcome="explored" if claimed else word_for(outcome),
        reason=outcome.sentence,
        collisions=judge.collisions,
        touches=len(judge.contacts),
        sim_s=judge.sim_s,
        task_s=round(end_s - begin_s, 2),
        known_s=round(known_at_s[0], 2) if known_at_s else None,
        flown_m=round(judge.flown_m(end_s), 3),
        miss_m=round(home_m, 3),
        covered=round(covered, 4),
        claimed=claimed,
    )
    cause = "collision" if judge.collisions else cause_of(row)
    row = replace(row, cause=cause, ok=not cause)
    return Flight(row, scene.spec, judge.trail, contacts_m=judge.contacts_m)


def cause_of(row: Row) -> str:
    """Why the mission failed; empty if it did not."""
    if row.covered is None or row.covered < COMPLETE:
        return "claimed too early" if row.claimed else "not all known"
    if not row.claimed:
        return "known, but not said"
    return "not home" if row.miss_m is None or row.miss_m > HOME_M else ""
