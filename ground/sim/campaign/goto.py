# SPDX-License-Identifier: GPL-3.0-or-later
"""Missions to one goal in a static world; some goals cannot be reached."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ground.core import MissionCmd, MissionReason
from ground.model import Point
from ground.sim.campaign.flights import Flight, Judge, Mission, word_for
from ground.sim.campaign.rows import Row
from ground.sim.campaign.scenes import CLEARANCE_M, STYLES, Scene, draw_scene
from ground.sim.campaign.truth import flood, length_m
from ground.sim.pilot import Pilot
from ground.sim.worldspec import Point as Place
from ground.station.flight import Outcome

BODY_M: Final = 0.08
"""A goal counts as unreachable if not even a body of this radius gets there."""
LIMIT_S: Final = 360.0
THERE_M: Final = 0.5
"""A goal counts as truly reached within this distance: not lost, nor in another room."""
_GOAL_GAP_M: Final = 0.38
"""Goals this far from obstacles keep their clearance even where the map is off by 0.2 m."""
_LEAST_WAY_M: Final = 1.5
_BEYOND_REACH_M: Final = 0.3
_UNREACHABLE: Final = 0.15
IMPOSSIBLE: Final = ("sealed", "inside", "outside")
_SAID_SO: Final = (
    MissionReason.OUTSIDE_GRID,
    MissionReason.OUTSIDE_AREA,
    MissionReason.GOAL_OCCUPIED,
    MissionReason.GOAL_UNREACHABLE,
)


@dataclass(frozen=True, slots=True)
class Task:
    """A world and a goal in it, in the world frame."""

    scene: Scene
    goal_m: Place
    what: str
    """reachable, or why not: sealed (room), inside (furniture) or outside (the geofence)."""
    way_m: tuple[Place, ...] = ()


def draw_task(rng: np.random.Generator, what: str = "") -> Task:
    """Draw worlds until one has a goal of this kind; an empty string means any kind."""
    if not what:
        impossible = rng.random() < _UNREACHABLE
        what = str(rng.choice(IMPOSSIBLE)) if impossible else "reachable"
    styles = [style for style in STYLES if what in ("reachable", "outside") or style != "maze"]
    if what == "sealed":
        styles.remove("clutter")
    while True:
        scene = draw_scene(str(rng.choice(styles)), rng, seal=what == "sealed")
        task = reachable_task(scene, rng) if what == "reachable" else _other_task(scene, what, rng)
        if task is not None:
            return task


def reachable_task(scene: Scene, rng: np.random.Generator) -> Task | None:
    """Draw a goal that is certainly reachable and not too near."""
    truth, start_m = scene.truth, scene.spec.start_m
    fit = scene.reachable()
    places = np.argwhere(fit & (truth.solid_gap_m > _GOAL_GAP_M))
    for _ in range(10):
        goal_m = truth.place(places[int(rng.integers(len(places)))])
        if math.dist(goal_m, start_m) < _LEAST_WAY_M / 2:
            continue
        way = truth.way(start_m, goal_m, CLEARANCE_M)
        if length_m(way) >= _LEAST_WAY_M:
            return Task(scene, goal_m, "reachable", tuple(way))
    return None


def _other_task(scene: Scene, what: str, rng: np.random.Generator) -> Task | None:
    """Draw a goal that is certainly unreachable."""
    truth, layout = scene.truth, scene.layout
    if what == "outside":
        x0, y0, x1, y1 = layout.outline.x0, layout.outline.y0, layout.outline.x1, layout.outline.y1
        off = rng.uniform(1.0, 3.0)
        sides = ((x0 - off, y0), (x1 + off, y1), (x0, y1 + off), (x1, y0 - off))
        return Task(scene, sides[int(rng.integers(4))], what)
    if what == "inside":
        if not scene.solid:
            return None
        goal_m = scene.solid[int(rng.integers(len(scene.solid)))].center_m
    else:
        if scene.sealed is None:
            return None
        room = layout.rooms[scene.sealed]
        places = np.argwhere(truth.within(room) & (truth.solid_gap_m > _GOAL_GAP_M))
        if not len(places):
            return None
        goal_m = truth.place(places[int(rng.integers(len(places)))])
    start = truth.cell(scene.spec.start_m)
    reached = truth.points_m[flood(truth.body_gap_m > BODY_M, start)]
    nearest_m = float(np.hypot(*(reached - goal_m).T).min())
    return Task(scene, goal_m, what) if nearest_m > _BEYOND_REACH_M else None


def fly_goto(mission: Mission) -> Flight:
    """Fly to the goal and land there, as `wayflie goto X Y` does."""
    task = draw_task(mission.rng())
    world = mission.world(task.scene.spec)
    goal = Point(*world.to_map(*task.goal_m))
    pilot = Pilot(world, mission.options())
    begin_s = pilot.time_s
    outcome = pilot.fly(MissionCmd.GOTO, goal, LIMIT_S)
    end_s = pilot.time_s
    pilot.land()
    judge = Judge(pilot, world)
    row = row_for(mission, task, outcome, judge, goal, begin_s, end_s)
    flight = judge.flight(row)
    return replace(flight, goal_m=task.goal_m, way_m=task.way_m)


def row_for(
    mission: Mission,
    task: Task,
    outcome: Outcome,
    judge: Judge,
    goal: Point,
    begin_s: float,
    end_s: float,
) -> Row:
    """The verdict on a flight to a goal."""
    miss_m = judge.miss_m(end_s, goal)
    cause = "collision" if judge.collisions else cause_of(task, outcome, miss_m)
    return Row(
        mission.kind,
        mission.seed,
        mission.number,
        mission.conditions,
        style=task.scene.style,
        task=task.what,
        outcome="arrived" if outcome.reached else word_for(outcome),
        reason=outcome.sentence,
        ok=not cause,
        cause=cause,
        collisions=judge.collisions,
        touches=len(judge.contacts),
        sim_s=judge.sim_s,
        task_s=round(end_s - begin_s, 2),
        flown_m=round(judge.flown_m(end_s), 3) if outcome.reached else None,
        shortest_m=round(length_m(task.way_m), 3) if task.way_m else None,
        miss_m=round(miss_m, 3) if task.what == "reachable" else None,
    )


def cause_of(task: Task, outcome: Outcome, miss_m: float) -> str:
    """Why the mission failed; empty if it succeeded."""
    if task.what == "reachable":
        if outcome.reached:
            return "" if miss_m <= THERE_M else "arrived elsewhere"
        return "wrongly refused" if outcome.reason in _SAID_SO else "not reached"
    if outcome.reached:
        return "arrived where nobody can"
    return "" if outcome.reason in _SAID_SO else "not reported"
