# SPDX-License-Identifier: GPL-3.0-or-later
"""Moving obstacles: people on their rounds, sliding doors, crates pushed or taken away."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from ground.sim.campaign.furniture import pole, prism
from ground.sim.campaign.layout import Door, Rect
from ground.sim.campaign.scenes import CLEARANCE_M, SURE_M, Scene
from ground.sim.campaign.truth import Bits, TrueMap, flood
from ground.sim.worldspec import Motion, Obstacle, Point

PERSON: Final = "person"
KEEP_OFF_M: Final = 0.9
"""People keep this distance from the drone's start and goal."""
_PERSON_GAP_M: Final = 0.3
_SLOW_MPS: Final = (0.12, 0.25)
_BRISK_MPS: Final = (0.25, 1.2)
_LEAF_M: Final = 0.04
_CRATE_M: Final = (0.25, 0.5)
_TRIES: Final = 20


def draw_person(
    scene: Scene, keep_off: tuple[Point, ...], rng: np.random.Generator
) -> list[Obstacle]:
    """Draw a person who walks between places with pauses, and leaves after a while."""
    truth = scene.truth
    away = _away(truth, keep_off)
    fit = np.argwhere(scene.reachable() & (truth.body_gap_m > _PERSON_GAP_M) & away)
    if not len(fit):
        return []
    for _ in range(_TRIES):
        stops = [
            truth.place(fit[int(rng.integers(len(fit)))]) for _ in range(int(rng.integers(2, 4)))
        ]
        way = [stops[0]]
        for goal in stops[1:]:
            leg = truth.way(way[-1], goal, _PERSON_GAP_M)
            way += leg[1:]
        there_and_back = [*way, *way[-2:0:-1]]
        length = sum(math.dist(a, b) for a, b in pairwise(way))
        if len(way) > 1 and length > 2.0 and _keeps_off(way, keep_off):
            break
    else:
        return []
    motion = Motion(
        tuple(there_and_back[1:]),
        speed_mps=rng.uniform(*(_SLOW_MPS if rng.random() < 0.5 else _BRISK_MPS)),
        start_s=rng.uniform(0.0, 5.0),
        loop=True,
        pause_s=rng.uniform(0.0, 2.0),
    )
    body = pole(PERSON, rng.uniform(0.18, 0.25), (0.0, rng.uniform(1.5, 1.9)), 0.5, way[0])
    return [replace(body, vanishes_s=rng.uniform(20.0, 60.0), motion=motion)]


def draw_door(scene: Scene, rng: np.random.Generator) -> list[Obstacle]:
    """Draw a door leaf that slides out of its wall and back with pauses, if a wall has room."""
    doors = list(scene.layout.doors)
    rng.shuffle(doors)
    for door in doors:
        pocket = _pocket(door, scene.layout.walls)
        if pocket is None:
            continue
        gap = door.gap.center_m
        size = (_LEAF_M, door.width_m) if door.upright else (door.width_m, _LEAF_M)
        leaf = prism("sliding door", size, (0.0, 2.0), 0.8, pocket)
        motion = Motion(
            (gap,),
            speed_mps=rng.uniform(0.1, 0.3),
            start_s=rng.uniform(3.0, 20.0),
            loop=True,
            pause_s=rng.uniform(5.0, 12.0),
        )
        return [replace(leaf, motion=motion)]
    return []


def draw_crate(
    scene: Scene, keep_off: tuple[Point, ...], rng: np.random.Generator
) -> list[Obstacle]:
    """Draw a crate that is pushed elsewhere or taken away; the goal always stays reachable."""
    truth = scene.truth
    fit = np.argwhere(scene.reachable() & (truth.solid_gap_m > 0.45) & _away(truth, keep_off))
    if not len(fit):
        return []
    for _ in range(_TRIES):
        here, there = (truth.place(fit[int(rng.integers(len(fit)))]) for _ in range(2))
        side = rng.uniform(*_CRATE_M)
        crate = prism("crate", (side, side), (0.0, rng.uniform(0.6, 1.2)), 0.6, here)
        if rng.random() < 0.5:
            ends = [crate]
            crate = replace(crate, vanishes_s=rng.uniform(10.0, 40.0))
        else:
            way = truth.way(here, there, _PERSON_GAP_M)
            if not 0.5 < math.dist(here, there) < 2.5 or not _keeps_off(way, keep_off):
                continue
            ends = [crate, replace(crate, center_m=there)]
            motion = Motion(tuple(way[1:]), rng.uniform(0.1, 0.3), rng.uniform(5.0, 30.0))
            crate = replace(crate, motion=motion)
        if all(_still_reachable(scene, end, keep_off) for end in ends):
            return [crate]
    return []


def _still_reachable(scene: Scene, crate: Obstacle, ends: tuple[Point, ...]) -> bool:
    truth = TrueMap((*scene.spec.obstacles, crate), scene.layout.outline)
    free = truth.solid_gap_m > CLEARANCE_M + SURE_M
    reached = flood(free, truth.cell(ends[0]))
    return all(bool(reached[truth.cell(end)]) for end in ends)


def _away(truth: TrueMap, keep_off: tuple[Point, ...]) -> Bits:
    gaps = [np.hypot(*np.moveaxis(truth.points_m - place, -1, 0)) for place in keep_off]
    away: Bits = np.min(gaps, axis=0) > KEEP_OFF_M
    return away


def _keeps_off(way: list[Point], keep_off: tuple[Point, ...]) -> bool:
    for a, b in pairwise(way):
        count = 2 + int(math.dist(a, b) / 0.1)
        for point in np.linspace(a, b, count):
            if any(math.dist(point, place) < KEEP_OFF_M for place in keep_off):
                return False
    return True


def _pocket(door: Door, walls: tuple[Rect, ...]) -> Point | None:
    """Centre of the open leaf: wholly within a wall beside the door."""
    x, y = door.gap.center_m
    width = door.width_m
    for sign in (-1, 1):
        at = (x, y + sign * width) if door.upright else (x + sign * width, y)
        half = (0.0, width / 2) if door.upright else (width / 2, 0.0)
        leaf = Rect(at[0] - half[0], at[1] - half[1], at[0] + half[0], at[1] + half[1])
        if any(_holds(wall, leaf) for wall in walls):
            return at
    return None


def _holds(wall: Rect, leaf: Rect) -> bool:
    slack = 1e-6
    return (
        wall.x0 <= leaf.x0 + slack
        and leaf.x1 <= wall.x1 + slack
        and wall.y0 <= leaf.y0 + slack
        and leaf.y1 <= wall.y1 + slack
    )
