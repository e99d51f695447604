# SPDX-License-Identifier: GPL-3.0-or-later
"""The pathfinder once more: to the next frontier, and after the map or the start has changed."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import ffi, lib
from tests.core import oracles
from tests.core.forest import checked
from tests.core.maps import (
    FREE,
    SIDE,
    blocked_bits,
    fill,
    new_clearance,
    new_grid,
    occupy,
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
    path_of,
    seeds,
    wall_with_gap,
)

ROOM = range(40, 81)
in_room = st.tuples(st.sampled_from(ROOM), st.sampled_from(ROOM))


@given(st.sets(in_room, max_size=300), in_room, st.sets(in_room, max_size=60))
def test_the_nearest_frontier_is_found_exactly_if_there_is_one(
    where: set[Cell], start: Cell, unseen: set[Cell]
) -> None:
    grid = new_grid()
    fill(grid, FREE)
    occupy(grid, where - {start})
    occupy(grid, {(x, y) for x in range(39, 82) for y in range(39, 82)} - set(product(ROOM, ROOM)))
    clearance = new_clearance(grid)
    known = np.ones((SIDE, SIDE), dtype=bool)
    for x, y in unseen - {start}:
        lib.grid_set_value(grid, x, y, lib.GRID_UNKNOWN)
        known[y, x] = False
    planner = ffi.new("pathfinder_t *")
    cfg = ffi.new("pathfinder_config_t *", lib.pathfinder_config_default())
    lib.pathfinder_start_frontier(planner, cfg, clearance, vec2(*centre(start)))
    lib.pathfinder_extend(planner, clearance, grid, LONGEST)
    count = oracles.waves(blocked_bits(clearance) | ~known, start)
    frontier = [
        (x, y)
        for x, y in set(count) - {start}
        if any(
            0 <= a < SIDE and 0 <= b < SIDE and not known[b, a]
            for a, b in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1))
        )
    ]
    if not frontier:
        assert planner.status == lib.PATHFINDER_NO_WAY
        return
    end = path_of(planner)[-1]
    cell = math.floor(end[0]), math.floor(end[1])
    assert_good(planner, clearance, centre(start), end)
    assert cell in frontier
    assert count[cell] == min(count[c] for c in frontier)
    assert lib.pathfinder_enough(planner)


@given(boxes, boxes, inside, seeds, st.integers(0, 600), st.booleans())
def test_a_repaired_way_is_as_good_as_a_new_one(
    where: Boxes, later: Boxes, to: Cell, seed: int, budget: int, moves: bool
) -> None:
    """Walls come and go, the start moves: solved exactly if there is a way, and it is clear."""
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
