# SPDX-License-Identifier: GPL-3.0-or-later
"""Corner cases of the pathfinder: each has its status."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import lib
from tests.core.maps import (
    SIDE,
    Point,
    fill,
    new_clearance,
    new_grid,
    raw_bytes,
    vec2,
    with_walls,
    xy,
)
from tests.core.searches import (
    GOAL,
    LONGEST,
    START,
    Cell,
    assert_good,
    begin,
    extend,
    finish,
    path_of,
    seeds,
    wall_with_gap,
)


def test_where_nothing_is_in_between_the_way_is_straight_at_once() -> None:
    _, clearance = with_walls([])
    planner = begin(clearance)
    assert planner.status == lib.PATHFINDER_FOUND
    assert lib.pathfinder_enough(planner)
    assert planner.best_cells == pytest.approx(math.dist(START, GOAL), abs=0.02)
    assert len(path_of(planner)) == 2


def test_a_start_may_be_the_goal() -> None:
    _, clearance = with_walls([])
    planner = begin(clearance, START, START)
    assert_good(planner, clearance, START, START)
    assert planner.best_cells == 0.0


@pytest.mark.parametrize(
    "bad",
    [
        (64.5, 10.5), (-1.0, 5.0), (5.0, 128.0), (math.nan, 5.0), (5.0, math.nan),
        (math.inf, 5.0), (5.0, -math.inf), (1e30, 5.0),
    ],
)  # fmt: skip
def test_a_blocked_end_is_said_so_at_once(bad: Point) -> None:
    _, clearance = with_walls(wall_with_gap(range(0)))
    planner = begin(clearance, start=bad)
    assert planner.status == lib.PATHFINDER_START_BLOCKED
    planner = begin(clearance, goal=bad)
    assert planner.status == lib.PATHFINDER_GOAL_BLOCKED
    before = raw_bytes(planner)
    assert extend(planner, clearance, 50) == lib.PATHFINDER_GOAL_BLOCKED
    assert raw_bytes(planner) == before
    assert path_of(planner) == []
    assert lib.pathfinder_enough(planner)


def test_a_full_grid_blocks_the_start() -> None:
    grid = new_grid()
    fill(grid, lib.GRID_VALUE_MAX)
    assert begin(new_clearance(grid)).status == lib.PATHFINDER_START_BLOCKED


@given(st.floats(0.0, 127.9375, width=32), st.floats(0.0, 127.9375, width=32), seeds)
def test_every_free_place_of_the_grid_may_be_an_end(x: float, y: float, seed: int) -> None:
    _, clearance = with_walls({(60, 60)} - {(int(x), int(y))})
    planner = begin(clearance, start=(x, y), goal=(y, x), seed=seed)
    finish(planner, clearance)
    if planner.status != lib.PATHFINDER_GOAL_BLOCKED:
        assert_good(planner, clearance, (x, y), (y, x))
    else:
        assert (int(y), int(x)) == (60, 60)


@pytest.mark.parametrize("beside", [63.99999, 63.9999, 63.998, 65.0, 65.001])
def test_an_end_may_be_as_near_to_a_blocked_cell_as_a_float_can_say(beside: float) -> None:
    """Wherever an end lies in its cell, it is not assigned to the next cell."""
    _, clearance = with_walls({(64, y) for y in range(20, 110)})
    x, _ = xy(vec2(beside, 0.0))
    for start, goal in (((x, 64.5), (126.5 - x, 64.2)), ((30.5, 40.5), (x, 64.99999))):
        start, goal = xy(vec2(*start)), xy(vec2(*goal))
        planner = begin(clearance, start, goal)
        finish(planner, clearance)
        assert_good(planner, clearance, start, goal)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("row", [0, 1, 70, 127])
def test_a_gap_of_one_cell_is_found(row: int, seed: int) -> None:
    _, clearance = with_walls(wall_with_gap(range(row, row + 1)))
    planner = begin(clearance, seed=seed)
    finish(planner, clearance)
    assert_good(planner, clearance, START, GOAL)


def spiral() -> set[Cell]:
    """Walls around the middle, each turn open at one corner; passages are 4 cells wide."""
    walls: set[Cell] = set()
    for k, side in enumerate(range(6, 62, 5)):
        low, high = 64 - side, 64 + side
        ring = {(x, y) for x in range(low, high) for y in (low, high - 1)}
        ring |= {(x, y) for y in range(low, high) for x in (low, high - 1)}
        gap = (low, range(low + 1, low + 4)) if k % 2 else (high - 1, range(high - 4, high - 1))
        walls |= ring - {(gap[0], y) for y in gap[1]}
    return walls


@pytest.mark.parametrize("grid_only", [False, True])
def test_the_way_out_of_a_spiral_is_found(grid_only: bool) -> None:
    _, clearance = with_walls(spiral())
    planner = begin(clearance, (64.5, 64.5), (1.5, 1.5), grid_only=grid_only)
    finish(planner, clearance)
    assert_good(planner, clearance, (64.5, 64.5), (1.5, 1.5))


def test_a_way_with_more_turns_than_points_is_said_so() -> None:
    wall = {(x, y) for x in range(1, 126, 2) for y in range(SIDE)}
    wall -= {(x, 0 if x % 4 == 1 else SIDE - 1) for x in range(1, 126, 2)}
    _, clearance = with_walls(wall)
    planner = begin(clearance, (0.5, 64.5), (126.5, 64.5))
    finish(planner, clearance)
    assert planner.status == lib.PATHFINDER_TOO_WINDING
    assert path_of(planner) == []
    assert lib.pathfinder_enough(planner)


@given(seeds)
def test_a_closed_wall_is_proven_closed(seed: int) -> None:
    _, clearance = with_walls(wall_with_gap(range(0)))
    planner = begin(clearance, seed=seed)
    assert finish(planner, clearance) == lib.PATHFINDER_NO_WAY
    assert xy(lib.pathfinder_nearest(planner)) == (63.5, 64.5)


def test_nothing_passes_between_cells_that_touch_at_a_corner() -> None:
    _, clearance = with_walls({(x, SIDE - 1 - x) for x in range(SIDE)})
    planner = begin(clearance, (10.5, 10.5), (120.5, 120.5))
    assert finish(planner, clearance) == lib.PATHFINDER_NO_WAY


def test_a_path_that_does_not_fit_is_not_given() -> None:
    _, clearance = with_walls(wall_with_gap(range(110, SIDE)))
    planner = begin(clearance)
    extend(planner, clearance, 2000)
    full = path_of(planner)
    assert len(full) > 2
    assert path_of(planner, len(full)) == full
    assert path_of(planner, len(full) - 1) == []


def test_it_says_when_it_has_enough_and_may_go_on() -> None:
    _, clearance = with_walls(wall_with_gap(range(84, SIDE)))
    planner = begin(clearance)
    budget = 0
    while not lib.pathfinder_enough(planner):
        extend(planner, clearance, 10)
        budget += 10
        assert budget < LONGEST
    cfg = planner.cfg
    since_first = planner.samples - planner.first_samples
    assert since_first >= cfg.least_samples
    assert planner.samples >= cfg.stop_ratio * planner.first_samples
    before = planner.samples
    extend(planner, clearance, 500)
    assert planner.samples > before
    assert_good(planner, clearance, START, GOAL)
