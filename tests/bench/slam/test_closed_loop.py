# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone flies from room to room on its corrected pose, where odometry would get lost."""

import math
from itertools import islice, pairwise

import numpy as np
import pytest

from ground.map.groundmap import GroundMap
from ground.model import Point
from ground.sim.footprints import Array
from ground.sim.world import load_world
from tests.bench.slam.closed_loop import Flown, Leg, Plan, fly_closed
from tests.bench.slam.closed_table import sentence, summary
from tests.bench.slam.goals import goals

MINUTES = 2.5


@pytest.fixture(scope="module")
def flights() -> dict[int, Flown]:
    """The same goals with the same drift, by value of `way.slam`."""
    return {slam: fly_closed(Plan("hard", slam, seed=6, minutes=MINUTES)) for slam in (0, 1)}


def test_goals_are_truly_reached_and_nothing_is_touched() -> None:
    flown = fly_closed(Plan("real", 1, seed=6, minutes=MINUTES))
    assert flown.touches == ()
    assert len(flown.legs) >= 4
    assert [leg.sentence for leg in flown.legs if not leg.arrived] == []
    assert flown.truly_there >= len(flown.legs) - 1, flown.leg_errors_m
    assert flown.map_m < 0.06


def test_most_goals_are_truly_reached_where_odometry_drifts_hard(flights: dict[int, Flown]) -> None:
    flown = flights[1]
    assert flown.touches == ()
    assert len(flown.legs) >= 4
    assert flown.truly_there >= 0.85 * len(flown.legs), flown.leg_errors_m
    assert flown.map_m < 0.1


def test_by_odometry_alone_it_is_several_times_as_far_off(flights: dict[int, Flown]) -> None:
    slam_m, odometry_m = (float(np.median(flights[slam].errors_m)) for slam in (1, 0))
    assert odometry_m > 3 * slam_m
    assert flights[0].truly_there < len(flights[0].legs)


def flown(believed: Array, true: Array) -> Flown:
    """A flight with two goals, both reached by the drone's own account, one truly."""
    legs = tuple(Leg(Point(1.0, 0.0), True, "arrived", end_s) for end_s in (10.0, 20.0))
    errors_m = np.array([0.1, 0.7])
    touch = {"time_s": 12.3, "obstacle": "bed"}
    plan = Plan("real", 1, 5)
    return Flown(plan, legs, errors_m, believed, true, GroundMap(), (touch,), 0.05)


def circle(turn_deg: float = 0.0, drift_mps: float = 0.0) -> Array:
    """A round trip of a minute, rotated and drifting."""
    times_s = np.arange(0.0, 60.0, 0.05)
    angles = 2 * math.pi * times_s / 60 + math.radians(turn_deg)
    x_m, y_m = 2 * np.cos(angles), 2 * np.sin(angles)
    return np.column_stack([times_s, x_m + drift_mps * times_s, y_m])


def test_a_turned_map_is_an_error_but_not_being_lost() -> None:
    turned = flown(circle(turn_deg=20.0), circle())
    assert np.median(turned.errors_m) == pytest.approx(4 * math.sin(math.radians(10.0)))
    assert turned.aligned_errors_m.max() < 1e-6 and not turned.lost
    assert flown(circle(drift_mps=0.05), circle()).lost


def test_figures_tell_what_the_drone_says_from_what_is_true() -> None:
    one = flown(circle(), circle())
    figures = summary([one, one])
    assert (figures["goals"], figures["arrived"], figures["truly_there"]) == (4, 1.0, 0.5)
    assert (figures["touches"], figures["lost"], figures["error_max_m"]) == (2, 0, 0.0)
    assert sentence(one) == "real, slam, seed 5: 1 of 2 goals; 12 s: touched bed"


def test_goals_are_apart_in_all_rooms_and_clear_of_everything() -> None:
    world = load_world("flat")
    wanted = list(islice(goals(world, 3), 60))
    assert wanted == list(islice(goals(load_world("flat"), 3), 60))
    places = np.array([world.to_world(goal.x_m, goal.y_m) for goal in wanted])
    assert world.surface_distance_m(places).min() > 0.4
    assert all(math.dist(a, b) >= 1.5 for a, b in pairwise(places.tolist()))
    kitchen, bedroom = places[:, 0] > 3.95, (places[:, 0] < 3.9) & (places[:, 1] > 3.05)
    assert kitchen.any() and bedroom.any() and not (kitchen | bedroom).all()
