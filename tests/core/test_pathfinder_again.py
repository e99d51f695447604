# SPDX-License-Identifier: GPL-3.0-or-later
"""Reusing the pathfinder: for the next frontier, and after a change of the map or the start."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import lib
from tests.core import oracles
from tests.core.forest import checked
from tests.core.maps import (
    SIDE,
    blocked_bits,
    vec2,
    with_walls,
)
from tests.core.searches import (
    GOAL,
    LONGEST,
    START,
    Boxes,
    Cell,
    assert_good,
    begin,
    boxes,
    centre,
    extend,
    finish,
    furnish,
    inside,
    seeds,
    wall_with_gap,
)


@given(boxes, boxes, inside, seeds, st.integers(0, 600), st.booleans())
def test_a_repaired_way_is_as_good_as_a_new_one(
    where: Boxes, later: Boxes, to: Cell, seed: int, budget: int, moves: bool
) -> None:
    """Walls come and go, the start moves: solved exactly if there is a path, which is clear."""
    _, clearance = with_walls(furnish(where, (20, 64), (108, 64)))
    planner = begin(clearance, seed=seed)
    extend(planner, clearance, budget)
    start = to if moves else (20, 64)
    place = centre(start) if moves else START
    _, clearance = with_walls(furnish(later, start, (108, 64)))
    lib.pathfinder_repair(planner, clearance, vec2(*place))
    best = math.inf
    for piece in [40] * 10 + [LONGEST]:
        if planner.status == lib.PATHFINDER_FOUND:
            assert_good(planner, clearance, place, GOAL)
            assert planner.best_cells <= best
            best = planner.best_cells
        if planner.grown:
            checked(planner.search.rrt.tree)
        extend(planner, clearance, piece) if piece < LONGEST else finish(planner, clearance)
    if (108, 64) in oracles.distances(blocked_bits(clearance), start):
        assert_good(planner, clearance, place, GOAL)
    else:
        assert planner.status == lib.PATHFINDER_NO_WAY


@pytest.mark.parametrize("seed", range(6))
def test_a_closed_door_is_got_round_and_an_opened_one_used(seed: int) -> None:
    both = {(64, y) for y in range(SIDE) if y not in range(60, 68) and y not in range(100, 108)}
    upper = both | {(64, y) for y in range(60, 68)}
    _, open_door = with_walls(both)
    _, closed_door = with_walls(upper)
    planner = begin(open_door, (20.5, 40.5), (108.5, 80.5), seed)
    extend(planner, open_door, 400)
    shorter = planner.best_cells
    lib.pathfinder_repair(planner, closed_door, vec2(20.5, 40.5))
    finish(planner, closed_door)
    assert_good(planner, closed_door, (20.5, 40.5), (108.5, 80.5))
    assert planner.best_cells > shorter + 5.0
    lib.pathfinder_repair(planner, open_door, vec2(20.5, 40.5))
    finish(planner, open_door)
    assert planner.best_cells == pytest.approx(shorter, abs=0.1)


def test_a_way_that_still_holds_is_there_at_once_after_the_start_has_moved_along_it() -> None:
    _, clearance = with_walls(wall_with_gap(range(84, SIDE)))
    planner = begin(clearance)
    extend(planner, clearance, 500)
    before = planner.best_cells
    on = (30.5, 68.5)
    assert lib.pathfinder_repair(planner, clearance, vec2(*on)) == lib.PATHFINDER_FOUND
    assert_good(planner, clearance, on, GOAL)
    assert planner.best_cells < before


def test_a_repair_is_enough_after_fewer_samples_than_a_new_search() -> None:
    doors = {(64, y) for y in range(SIDE) if y not in range(60, 68) and y not in range(100, 108)}
    _, both = with_walls(doors)
    _, one = with_walls(doors | {(64, y) for y in range(60, 68)})
    planner = begin(both, (20.5, 40.5), (108.5, 80.5))
    extend(planner, both, 400)
    lib.pathfinder_repair(planner, one, vec2(20.5, 40.5))
    while not lib.pathfinder_enough(planner):
        extend(planner, one, 1)
    assert planner.samples - planner.first_samples < planner.cfg.least_samples


def test_repair_of_nothing_begins_anew() -> None:
    _, clearance = with_walls(wall_with_gap(range(0)))
    planner = begin(clearance)
    assert finish(planner, clearance) == lib.PATHFINDER_NO_WAY
    _, clearance = with_walls(wall_with_gap(range(10, 20)))
    assert lib.pathfinder_repair(planner, clearance, vec2(*START)) == lib.PATHFINDER_SEARCHING
    finish(planner, clearance)
    assert_good(planner, clearance, START, GOAL)
    assert (
        lib.pathfinder_repair(planner, clearance, vec2(64.5, 5.5)) == lib.PATHFINDER_START_BLOCKED
    )


@pytest.mark.parametrize("seed", range(5))
def test_steps_that_follow_what_is_blocked_solve_too(seed: int) -> None:
    _, clearance = with_walls(furnish([(20, 10, 8, 70), (50, 50, 8, 70), (80, 10, 8, 90)]))
    planner = begin(clearance, (10.5, 20.5), (120.5, 20.5), seed, adaptive=True)
    finish(planner, clearance)
    assert_good(planner, clearance, (10.5, 20.5), (120.5, 20.5))
