# SPDX-License-Identifier: GPL-3.0-or-later
"""Missions to a goal among people, sliding doors and crates that are moved or taken away."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ground.core import MissionCmd
from ground.model import Point
from ground.sim.campaign.flights import Flight, Judge, Mission
from ground.sim.campaign.ghosts import count_ghosts, where
from ground.sim.campaign.goto import Task, reachable_task, row_for
from ground.sim.campaign.movers import PERSON, draw_crate, draw_door, draw_person
from ground.sim.campaign.scenes import Scene, draw_scene
from ground.sim.campaign.truth import TrueMap
from ground.sim.footprints import Array
from ground.sim.pilot import Pilot
from ground.sim.worldspec import Obstacle
from ground.sim.worldspec import Point as Place

SLOW_MPS: Final = 0.25
"""The speed at which the drone backs away, so that it can keep clear of slower people."""
LIMIT_S: Final = 300.0
FORGET_S: Final = 20.0
"""This long after people have left, nothing of them may remain in the map."""
_STYLES: Final = ("home", "office", "clutter")
_FLYING_M: Final = 0.1


def draw_task(rng: np.random.Generator) -> tuple[Task, tuple[Obstacle, ...]]:
    """Draw a reachable goal and at least one moving obstacle."""
    while True:
        scene = draw_scene(str(rng.choice(_STYLES)), rng)
        task = reachable_task(scene, rng)
        if task is None:
            continue
        ends = (scene.spec.start_m, task.goal_m)
        movers = [m for _ in range(int(rng.integers(0, 3))) for m in draw_person(scene, ends, rng)]
        if rng.random() < 0.5:
            movers += draw_door(scene, rng)
        if rng.random() < 0.5:
            movers += draw_crate(scene, ends, rng)
        if movers:
            return task, tuple(movers)


def fly_moving(mission: Mission) -> Flight:
    """Fly to the goal, hover until everybody has been gone for FORGET_S, then land."""
    task, movers = draw_task(mission.rng())
    scene = task.scene
    spec = replace(scene.spec, obstacles=(*scene.spec.obstacles, *movers))
    world = mission.world(spec)
    goal = Point(*world.to_map(*task.goal_m))
    pilot = Pilot(world, mission.options())
    begin_s = pilot.time_s
    outcome = pilot.fly(MissionCmd.GOTO, goal, LIMIT_S)
    end_s = pilot.time_s
    gone_s = max((mover.vanishes_s for mover in movers if mover.name == PERSON), default=0.0)
    pilot.rest(max(0.0, gone_s + FORGET_S - pilot.time_s))
    pilot.fetch_map()
    drawn = pilot.picture.map.obstacles_m()
    ghosts = count_ghosts(np.column_stack(world.to_world(*drawn.T)), scene.truth, movers)
    pilot.land()
    judge = Judge(pilot, world)
    row = row_for(mission, task, outcome, judge, goal, begin_s, end_s)
    row = replace(
        row,
        person_m=_nearest_m(judge.trail, movers, scene),
        ghosts=ghosts if gone_s else None,
    )
    cause = row.cause or ("people left in the map" if row.ghosts else "")
    row = replace(row, cause=cause, ok=not cause)
    flight = judge.flight(row)
    return replace(flight, goal_m=task.goal_m, way_m=task.way_m)


def _nearest_m(trail: Array, movers: Sequence[Obstacle], scene: Scene) -> float | None:
    """Least distance in flight between the drone's centre and a slow person in line of sight."""
    nearest = math.inf
    slow = [m for m in movers if m.name == PERSON and m.motion and m.motion.speed_mps <= SLOW_MPS]
    for time_s, x_m, y_m, z_m, _ in trail:
        for person in slow if z_m > _FLYING_M else ():
            if time_s >= person.vanishes_s:
                continue
            there = where(person, time_s)
            gap_m = math.dist((x_m, y_m), there) - person.radius_m
            if gap_m < nearest and _in_sight(scene.truth, (x_m, y_m), there):
                nearest = gap_m
    return round(nearest, 3) if math.isfinite(nearest) else None


def _in_sight(truth: TrueMap, a: Place, b: Place) -> bool:
    points = np.linspace(a, b, 2 + int(math.dist(a, b) / 0.05))
    return all(truth.body_gap_m[truth.cell(point)] > 0.0 for point in points)
