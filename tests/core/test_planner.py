# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole planner: every way is clear and as long as it says, every status is proven."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core import oracles
from tests.core.forest import checked
from tests.core.maps import (
    FREE,
    PER_CELL,
    SIDE,
    Point,
    blocked_bits,
    fill,
    is_clear,
    length,
    new_clearance,
    new_grid,
    occupy,
    points,
    raw_bytes,
    vec2,
    with_walls,
    xy,
)

Cell = tuple[int, int]
Boxes = list[tuple[int, int, int, int]]
START, GOAL = (20.25, 64.5), (108.75, 64.5)
LONGEST = 200_000  # units of budget, in which every search must have ended
MORE = 1000  # units spent on a shorter way
NEAR_CELLS = 4 / PER_CELL  # ends are moved off the sides of their cells by no more
seeds = st.integers(0, 2**32 - 1)
boxes = st.lists(
    st.tuples(st.integers(0, 110), st.integers(0, 110), st.integers(2, 40), st.integers(2, 18)),
    max_size=16,
)
inside = st.tuples(st.integers(0, SIDE - 1), st.integers(0, SIDE - 1))


def furnish(where: Boxes, *free: Cell) -> set[Cell]:
    cells = {(x + i, y + j) for x, y, w, h in where for i in range(w) for j in range(h)}
    return {(x, y) for x, y in cells if x < SIDE and y < SIDE} - set(free)


def wall_with_gap(gap: range) -> set[Cell]:
    return {(64, y) for y in range(SIDE) if y not in gap}


def centre(cell: Cell) -> Point:
    return cell[0] + 0.5, cell[1] + 0.5


def begin(
    clearance: CData, start: Point = START, goal: Point = GOAL, seed: int = 1, **changes: float
) -> CData:
    planner = ffi.new("planner_t *")
    cfg = ffi.new("planner_config_t *", lib.planner_config_default())
    for name, value in changes.items():
        setattr(cfg, name, value)
    lib.planner_start(planner, cfg, clearance, vec2(*start), vec2(*goal), seed)
    return planner


def extend(planner: CData, clearance: CData, budget: int) -> int:
    return int(lib.planner_extend(planner, clearance, ffi.NULL, budget))


def finish(planner: CData, clearance: CData) -> int:
    """Until a way is known or there is none, and then some more."""
    for _ in range(0, LONGEST, 100):
        if extend(planner, clearance, 100) != lib.PLANNER_SEARCHING:
            return extend(planner, clearance, MORE)
    raise AssertionError("the search does not end")


def path_of(planner: CData, capacity: int = lib.PLANNER_POINTS) -> list[Point]:
    array = ffi.new("vec2_t[]", capacity)
    return points(array, lib.planner_path(planner, array, capacity))


def assert_good(planner: CData, clearance: CData, start: Point, goal: Point) -> None:
    path = path_of(planner)
    assert planner.status == lib.PLANNER_FOUND
    for end, wanted in ((path[0], start), (path[-1], goal)):
        assert math.dist(end, wanted) <= math.hypot(NEAR_CELLS, 1 / PER_CELL)
        assert [math.floor(c) for c in end] == [math.floor(c) for c in wanted]
    assert is_clear(clearance, path)
    assert length(path) == pytest.approx(planner.best_cells, rel=1e-4, abs=1e-4)
    assert lib.planner_nodes(planner) <= lib.TREE_NODES


@given(boxes, seeds, st.booleans())
def test_a_way_is_clear_and_as_long_as_it_says_and_never_gets_worse(
    where: Boxes, seed: int, grid_only: bool
) -> None:
    _, clearance = with_walls(furnish(where, (20, 64), (108, 64)))
    planner = begin(clearance, seed=seed, grid_only=grid_only)
    best = math.inf
    for budget in [1] * 20 + [17] * 40:
        extend(planner, clearance, budget)
        if planner.status == lib.PLANNER_FOUND:
            assert_good(planner, clearance, START, GOAL)
            assert planner.best_cells <= best
            best = planner.best_cells
        else:
            assert path_of(planner) == []


@given(boxes, inside, inside, seeds, st.booleans())
def test_it_is_solved_exactly_if_there_is_a_way(
    where: Boxes, start: Cell, goal: Cell, seed: int, grid_only: bool
) -> None:
    _, clearance = with_walls(furnish(where, start, goal))
    planner = begin(clearance, centre(start), centre(goal), seed, grid_only=grid_only)
    finish(planner, clearance)
    reachable = oracles.distances(blocked_bits(clearance), start)
    if goal in reachable:
        assert_good(planner, clearance, centre(start), centre(goal))
        return
    assert planner.status == lib.PLANNER_NO_WAY
    nearest = xy(lib.planner_nearest(planner))
    away = min(math.dist(centre(cell), centre(goal)) for cell in reachable)
    assert (math.floor(nearest[0]), math.floor(nearest[1])) in reachable
    assert math.dist(nearest, centre(goal)) == pytest.approx(away, abs=1e-2)
    assert lib.planner_enough(planner)


@given(boxes, seeds, st.lists(st.integers(0, 200), max_size=12), st.booleans())
def test_how_the_budget_is_sliced_does_not_matter(
    where: Boxes, seed: int, slices: list[int], grid_only: bool
) -> None:
    _, clearance = with_walls(furnish(where, (20, 64), (108, 64)))
    whole, sliced = (begin(clearance, seed=seed, grid_only=grid_only) for _ in range(2))
    extend(whole, clearance, sum(slices))
    for budget in slices:
        extend(sliced, clearance, budget)
    assert raw_bytes(whole) == raw_bytes(sliced)


def test_the_seed_decides() -> None:
    _, clearance = with_walls(wall_with_gap(range(10, 20)))
    runs = [begin(clearance, seed=seed) for seed in (1, 1, 2)]
    for planner in runs:
        extend(planner, clearance, 300)
    assert raw_bytes(runs[0]) == raw_bytes(runs[1])
    assert raw_bytes(runs[0]) != raw_bytes(runs[2])


@given(boxes, seeds)
def test_the_tree_is_sound_and_its_edges_are_clear(where: Boxes, seed: int) -> None:
    _, clearance = with_walls(furnish(where, (20, 64), (108, 64)))
    planner = begin(clearance, seed=seed)
    for budget in (30, 70, 200, 1500):
        extend(planner, clearance, budget)
        if planner.grown:
            forest = checked(planner.search.rrt.tree)
            for node in forest.values():
                if node.parent != lib.TREE_NONE:
                    edge = [(x / PER_CELL, y / PER_CELL) for x, y in
                            (node.at, forest[node.parent].at)]  # fmt: skip
                    assert is_clear(clearance, edge)


@pytest.mark.parametrize("seed", range(6))
def test_a_pool_that_is_full_for_long_never_stops_improving(seed: int) -> None:
    """A wall of many doors: after ten times as many samples as nodes new nodes still come in."""
    wall = {(x, y) for x in (40, 60, 80) for y in range(SIDE) if y % 25 not in (3, 4, 5)}
    _, clearance = with_walls(wall)
    planner = begin(clearance, seed=seed)
    extend(planner, clearance, 10 * lib.TREE_NODES)
    assert planner.status == lib.PLANNER_FOUND
    before = [(n.x, n.y) for n in (node.at for node in planner.search.rrt.tree.nodes)]
    extend(planner, clearance, 10 * lib.TREE_NODES)
    after = [(n.x, n.y) for n in (node.at for node in planner.search.rrt.tree.nodes)]
    assert planner.stage != lib.PLANNER_END
    assert len(set(after) - set(before)) > 20
    checked(planner.search.rrt.tree)
    assert_good(planner, clearance, START, GOAL)


@pytest.mark.parametrize("seed", range(10))
def test_a_way_round_a_wall_is_the_shortest(seed: int) -> None:
    _, clearance = with_walls(wall_with_gap(range(84, SIDE)))
    planner = begin(clearance, seed=seed)
    extend(planner, clearance, 1000)
    shortest = math.dist(START, (64.0, 84.0)) + 1.0 + math.dist((65.0, 84.0), GOAL)
    assert planner.best_cells == pytest.approx(shortest, abs=0.1)


@pytest.mark.parametrize("seed", range(6))
def test_the_shorter_of_two_doors_is_found(seed: int) -> None:
    """The trees may meet in either; the wave has looked at both."""
    _, clearance = with_walls(wall_with_gap(range(84, 90)) - {(64, y) for y in range(8, 30)})
    planner = begin(clearance, seed=seed)
    extend(planner, clearance, 2000)
    shortest = math.dist(START, (64.0, 84.0)) + 1.0 + math.dist((65.0, 84.0), GOAL)
    assert planner.best_cells == pytest.approx(shortest, abs=0.1)


def test_where_nothing_is_in_between_the_way_is_straight_at_once() -> None:
    _, clearance = with_walls([])
    planner = begin(clearance)
    assert planner.status == lib.PLANNER_FOUND
    assert lib.planner_enough(planner)
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
    assert planner.status == lib.PLANNER_START_BLOCKED
    planner = begin(clearance, goal=bad)
    assert planner.status == lib.PLANNER_GOAL_BLOCKED
    before = raw_bytes(planner)
    assert extend(planner, clearance, 50) == lib.PLANNER_GOAL_BLOCKED
    assert raw_bytes(planner) == before
    assert path_of(planner) == []
    assert lib.planner_enough(planner)


def test_a_full_grid_blocks_the_start() -> None:
    grid = new_grid()
    fill(grid, lib.GRID_VALUE_MAX)
    assert begin(new_clearance(grid)).status == lib.PLANNER_START_BLOCKED


@given(st.floats(0.0, 127.9375, width=32), st.floats(0.0, 127.9375, width=32), seeds)
def test_every_free_place_of_the_grid_may_be_an_end(x: float, y: float, seed: int) -> None:
    _, clearance = with_walls({(60, 60)} - {(int(x), int(y))})
    planner = begin(clearance, start=(x, y), goal=(y, x), seed=seed)
    finish(planner, clearance)
    if planner.status != lib.PLANNER_GOAL_BLOCKED:
        assert_good(planner, clearance, (x, y), (y, x))
    else:
        assert (int(y), int(x)) == (60, 60)


@pytest.mark.parametrize("beside", [63.99999, 63.9999, 63.998, 65.0, 65.001])
def test_an_end_may_be_as_near_to_a_blocked_cell_as_a_float_can_say(beside: float) -> None:
    """Whatever its place in the cell, an end is not taken for one in the next cell."""
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
    """Walls round the middle, each turn open at one corner; ways are 4 cells wide."""
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
    assert planner.status == lib.PLANNER_TOO_WINDING
    assert path_of(planner) == []
    assert lib.planner_enough(planner)


@given(seeds)
def test_a_closed_wall_is_proven_closed(seed: int) -> None:
    _, clearance = with_walls(wall_with_gap(range(0)))
    planner = begin(clearance, seed=seed)
    assert finish(planner, clearance) == lib.PLANNER_NO_WAY
    assert xy(lib.planner_nearest(planner)) == (63.5, 64.5)


def test_nothing_passes_between_cells_that_touch_at_a_corner() -> None:
    _, clearance = with_walls({(x, SIDE - 1 - x) for x in range(SIDE)})
    planner = begin(clearance, (10.5, 10.5), (120.5, 120.5))
    assert finish(planner, clearance) == lib.PLANNER_NO_WAY


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
    while not lib.planner_enough(planner):
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
    planner = ffi.new("planner_t *")
    cfg = ffi.new("planner_config_t *", lib.planner_config_default())
    lib.planner_start_frontier(planner, cfg, clearance, vec2(*centre(start)))
    lib.planner_extend(planner, clearance, grid, LONGEST)
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
        assert planner.status == lib.PLANNER_NO_WAY
        return
    end = path_of(planner)[-1]
    cell = math.floor(end[0]), math.floor(end[1])
    assert_good(planner, clearance, centre(start), end)
    assert cell in frontier
    assert count[cell] == min(count[c] for c in frontier)
    assert lib.planner_enough(planner)


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
    lib.planner_repair(planner, clearance, vec2(*place))
    best = math.inf
    for piece in [40] * 10 + [LONGEST]:
        if planner.status == lib.PLANNER_FOUND:
            assert_good(planner, clearance, place, GOAL)
            assert planner.best_cells <= best
            best = planner.best_cells
        if planner.grown:
            checked(planner.search.rrt.tree)
        extend(planner, clearance, piece) if piece < LONGEST else finish(planner, clearance)
    if (108, 64) in oracles.distances(blocked_bits(clearance), start):
        assert_good(planner, clearance, place, GOAL)
    else:
        assert planner.status == lib.PLANNER_NO_WAY


@pytest.mark.parametrize("seed", range(6))
def test_a_closed_door_is_got_round_and_an_opened_one_used(seed: int) -> None:
    both = {(64, y) for y in range(SIDE) if y not in range(60, 68) and y not in range(100, 108)}
    upper = both | {(64, y) for y in range(60, 68)}
    _, open_door = with_walls(both)
    _, closed_door = with_walls(upper)
    planner = begin(open_door, (20.5, 40.5), (108.5, 80.5), seed)
    extend(planner, open_door, 400)
    shorter = planner.best_cells
    lib.planner_repair(planner, closed_door, vec2(20.5, 40.5))
    finish(planner, closed_door)
    assert_good(planner, closed_door, (20.5, 40.5), (108.5, 80.5))
    assert planner.best_cells > shorter + 5.0
    lib.planner_repair(planner, open_door, vec2(20.5, 40.5))
    finish(planner, open_door)
    assert planner.best_cells == pytest.approx(shorter, abs=0.1)


def test_a_way_that_still_holds_is_there_at_once_after_the_start_has_moved_along_it() -> None:
    _, clearance = with_walls(wall_with_gap(range(84, SIDE)))
    planner = begin(clearance)
    extend(planner, clearance, 500)
    before = planner.best_cells
    on = (30.5, 68.5)
    assert lib.planner_repair(planner, clearance, vec2(*on)) == lib.PLANNER_FOUND
    assert_good(planner, clearance, on, GOAL)
    assert planner.best_cells < before


def test_repair_of_nothing_begins_anew() -> None:
    _, clearance = with_walls(wall_with_gap(range(0)))
    planner = begin(clearance)
    assert finish(planner, clearance) == lib.PLANNER_NO_WAY
    _, clearance = with_walls(wall_with_gap(range(10, 20)))
    assert lib.planner_repair(planner, clearance, vec2(*START)) == lib.PLANNER_SEARCHING
    finish(planner, clearance)
    assert_good(planner, clearance, START, GOAL)
    assert lib.planner_repair(planner, clearance, vec2(64.5, 5.5)) == lib.PLANNER_START_BLOCKED


@pytest.mark.parametrize("seed", range(5))
def test_steps_that_follow_what_is_blocked_solve_too(seed: int) -> None:
    _, clearance = with_walls(furnish([(20, 10, 8, 70), (50, 50, 8, 70), (80, 10, 8, 90)]))
    planner = begin(clearance, (10.5, 20.5), (120.5, 20.5), seed, adaptive=True)
    finish(planner, clearance)
    assert_good(planner, clearance, (10.5, 20.5), (120.5, 20.5))
