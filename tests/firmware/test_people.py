# SPDX-License-Identifier: GPL-3.0-or-later
"""A person walks up to the drone: it yields early, hits no wall, and comes back."""

import math
from dataclasses import replace

import pytest

from ground.core import MissionCmd, MissionState, lib
from ground.sim.worldspec import Obstacle
from tests.firmware.people import Watched, box, person, room, visit

OPEN = room(-3.0, -3.0, 3.0, 3.0)
SMALL = room(-2.0, -2.0, 2.0, 2.0)
WALL_BEHIND = room(-0.6, -3.0, 4.0, 3.0)
CORNERED = room(-0.6, -0.6, 4.0, 4.0)
COMES_S = 14.0
GONE_S = 26.0
KEPT_M = 0.3
BODY_M = 0.07


def hovering(obstacles: tuple[Obstacle, ...], seed: int) -> Watched:
    flight = Watched(obstacles, seed)
    flight.hover()
    flight.fly_until(COMES_S)
    return flight


@pytest.mark.parametrize(("bearing_deg", "seed"), [(0, 1), (20, 2), (160, 3), (-110, 4)])
def test_it_gives_way_to_whoever_walks_up_to_it_and_returns(bearing_deg: float, seed: int) -> None:
    flight = hovering((*OPEN, person(visit(bearing_deg, 2.4, 0.0), COMES_S)), seed)
    post_m = flight.place_m
    flight.fly_until(COMES_S + 4.8)
    assert math.dist(flight.place_m, post_m) > 0.5
    flight.fly_until(GONE_S + 8.0)
    assert flight.nearest_m[True] > KEPT_M
    assert flight.state == MissionState.HOVER
    assert math.dist(flight.place_m, post_m) < 0.3
    assert flight.plant.collisions == 0


@pytest.mark.parametrize(
    ("walls", "bearing_deg", "seed"), [(WALL_BEHIND, 0, 1), (WALL_BEHIND, 70, 2), (CORNERED, 20, 3)]
)
def test_it_is_not_pushed_into_a_wall(
    walls: tuple[Obstacle, ...], bearing_deg: float, seed: int
) -> None:
    flight = hovering((*walls, person(visit(bearing_deg, 2.4, 0.5), COMES_S)), seed)
    flight.fly_until(GONE_S)
    assert MissionState.AVOID in flight.states
    assert flight.nearest_m[True] > KEPT_M
    assert flight.nearest_m[False] > BODY_M + 0.02
    assert flight.plant.collisions == 0


def test_it_keeps_its_height_while_it_gives_way() -> None:
    flight = hovering((*OPEN, person(visit(0, 2.4, 0.0), COMES_S)), 5)
    heights_m = []
    while flight.time_s < GONE_S:
        flight.fly_until(flight.time_s + 0.1)
        heights_m.append(flight.plant.truth.position_m[2])
    assert min(heights_m) > flight.nav.cfg.height_m - 0.1
    assert max(heights_m) < flight.nav.cfg.height_m + 0.1


@pytest.mark.parametrize(("held_s", "lands"), [(0.3, False), (math.inf, True)])
def test_a_hand_held_above_lands_it(held_s: float, lands: bool) -> None:
    gone_s = COMES_S + held_s
    hand = Obstacle("hand", (0, 0), (0.4, 0.4), 0.0, 0.0, 0.52, 0.6, 0.8, COMES_S, gone_s)
    flight = hovering((*OPEN, hand), 6)
    flight.fly_until(COMES_S + 6.0)
    assert (flight.state == MissionState.IDLE) == lands
    assert flight.nav.mission.fault == lib.MISSION_OK


@pytest.mark.parametrize("seed", [7, 8])
def test_who_has_passed_is_forgotten_and_the_walls_are_not(seed: int) -> None:
    gone_s = COMES_S + 9.0
    way = [(1.2, -1.6), (1.2, 1.2), (-1.2, 1.2)]
    flight = hovering((*SMALL, person(way, COMES_S, gone_s=gone_s)), seed)
    flight.fly_until(gone_s)
    before = {at for at in flight.obstacles_m() if max(map(abs, at)) > 1.8}
    flight.fly_until(gone_s + 20.0)
    after = flight.obstacles_m()
    assert {at for at in after if max(map(abs, at)) < 1.6} == set()
    assert len(before) > 30
    kept = [at for at in before if any(math.dist(at, other) < 0.11 for other in after)]
    assert len(kept) > 0.95 * len(before)


@pytest.mark.parametrize("seed", [9, 10])
def test_a_door_that_closed_for_a_while_is_flown_through_when_it_is_open(seed: int) -> None:
    beside = (box("wall", (1.0, -2.0), (1.1, -0.45)), box("wall", (1.0, 0.45), (1.1, 2.0)))
    leaf = box("door", (1.0, -0.45), (1.1, 0.45))
    shut = replace(leaf, appears_s=COMES_S, vanishes_s=COMES_S + 8.0)
    flight = hovering((*SMALL, *beside, shut), seed)
    flight.fly_until(COMES_S + 8.0)
    assert any(0.85 < x < 1.25 and abs(y) < 0.3 for x, y in flight.obstacles_m())
    flight.fly_until(COMES_S + 25.0)
    flight.command(MissionCmd.GOTO, (1.6, 0.0))
    flight.fly_until(flight.time_s + 25.0)
    assert math.dist(flight.place_m, (1.6, 0.0)) < 0.35
    assert flight.plant.collisions == 0
