# SPDX-License-Identifier: GPL-3.0-or-later
"""Somebody walks up to the drone: it gives way early, hits no wall, and comes back."""

import math

import pytest

from ground.core import MissionState, lib
from ground.sim.worldspec import Obstacle
from tests.firmware.people import Watched, person, room, visit

OPEN = room(-3.0, -3.0, 3.0, 3.0)
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
