# SPDX-License-Identifier: GPL-3.0-or-later
"""RRT*: every way is clear and as long as it says; more budget never makes it worse."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import (
    SIDE,
    is_clear,
    length,
    points,
    raw_bytes,
    vec2,
    with_walls,
    xy,
)

Point = tuple[float, float]
START, GOAL = (20.25, 64.5), (108.75, 64.5)
seeds = st.integers(0, 2**32 - 1)
# Furniture: a few boxes anywhere.
boxes = st.lists(
    st.tuples(st.integers(0, 110), st.integers(0, 110), st.integers(2, 18), st.integers(2, 18)),
    max_size=14,
)
NODE_CELLS = 1 / 512  # what a node's position is rounded to


def furnish(where: list[tuple[int, int, int, int]]) -> set[tuple[int, int]]:
    return {(x + i, y + j) for x, y, w, h in where for i in range(w) for j in range(h)}


def wall_with_gap(gap: range) -> set[tuple[int, int]]:
    return {(64, y) for y in range(SIDE) if y not in gap}


def plan(clearance: CData, start: Point = START, goal: Point = GOAL, seed: int = 1) -> CData:
    rrt = ffi.new("rrtstar_t *")
    cfg = ffi.new("rrtstar_config_t *", lib.rrtstar_config_default())
    lib.rrtstar_start(rrt, cfg, clearance, vec2(*start), vec2(*goal), seed)
    return rrt


def path_of(rrt: CData, capacity: int = 343) -> list[Point]:
    array = ffi.new("vec2_t[]", capacity)
    return points(array, lib.rrtstar_path(rrt, array, capacity))


def assert_good(rrt: CData, clearance: CData, start: Point, goal: Point) -> None:
    path = path_of(rrt)
    assert path[0] == pytest.approx(start, abs=NODE_CELLS)
    assert path[-1] == pytest.approx(goal, abs=NODE_CELLS)
    assert is_clear(clearance, path)
    assert length(path) == pytest.approx(rrt.best_cells, rel=1e-4)


def has_way(rrt: CData) -> bool:
    return bool(rrt.goal_parent != lib.RRTSTAR_NONE)


@given(boxes, seeds)
def test_a_way_is_clear_and_as_long_as_it_says_at_every_stage(
    where: list[tuple[int, int, int, int]], seed: int
) -> None:
    _, clearance = with_walls(furnish(where) - {(20, 64), (108, 64)})
    rrt = plan(clearance, seed=seed)
    best = math.inf
    for _ in range(12):
        lib.rrtstar_extend(rrt, clearance, 50)
        if has_way(rrt):
            assert_good(rrt, clearance, START, GOAL)
            assert rrt.best_cells <= best
            best = rrt.best_cells


@given(boxes, seeds)
def test_the_tree_is_a_tree_with_right_costs(
    where: list[tuple[int, int, int, int]], seed: int
) -> None:
    _, clearance = with_walls(furnish(where) - {(20, 64), (108, 64)})
    rrt = plan(clearance, seed=seed)
    lib.rrtstar_extend(rrt, clearance, 400)
    at = [(node.x / 512, node.y / 512) for node in rrt.nodes[0 : rrt.count]]
    for i in range(1, rrt.count):
        node = rrt.nodes[i]
        parent = rrt.nodes[node.parent]
        edge = math.dist(at[i], at[node.parent])
        assert node.cost_cells == pytest.approx(parent.cost_cells + edge, rel=1e-4, abs=1e-3)
        assert is_clear(clearance, [at[node.parent], at[i]])
    linked = []
    for i in range(rrt.count):
        child = rrt.nodes[i].child
        while child != lib.RRTSTAR_NONE:
            assert rrt.nodes[child].parent == i
            linked.append(child)
            child = rrt.nodes[child].sibling
    assert sorted(linked) == list(range(1, rrt.count))


@given(boxes, seeds, st.lists(st.integers(0, 90), max_size=8))
def test_how_the_budget_is_sliced_does_not_matter(
    where: list[tuple[int, int, int, int]], seed: int, slices: list[int]
) -> None:
    _, clearance = with_walls(furnish(where) - {(20, 64), (108, 64)})
    whole, sliced = plan(clearance, seed=seed), plan(clearance, seed=seed)
    lib.rrtstar_extend(whole, clearance, sum(slices))
    for budget in slices:
        lib.rrtstar_extend(sliced, clearance, budget)
    assert raw_bytes(whole) == raw_bytes(sliced)


def test_the_seed_decides() -> None:
    _, clearance = with_walls(wall_with_gap(range(10, 20)))
    runs = [plan(clearance, seed=seed) for seed in (1, 1, 2)]
    for rrt in runs:
        lib.rrtstar_extend(rrt, clearance, 300)
    assert raw_bytes(runs[0]) == raw_bytes(runs[1])
    assert raw_bytes(runs[0]) != raw_bytes(runs[2])


def test_where_nothing_is_in_between_the_way_is_straight_at_once() -> None:
    _, clearance = with_walls([])
    rrt = plan(clearance)
    assert rrt.status == lib.RRTSTAR_FOUND
    assert rrt.best_cells == pytest.approx(math.dist(START, GOAL), abs=0.01)
    assert len(path_of(rrt)) == 2


@pytest.mark.parametrize("seed", range(12))
def test_a_way_round_a_wall_comes_near_the_shortest(seed: int) -> None:
    _, clearance = with_walls(wall_with_gap(range(84, SIDE)))
    rrt = plan(clearance, seed=seed)
    lib.rrtstar_extend(rrt, clearance, 3000)
    corner_left, corner_right = (64.0, 84.0), (65.0, 84.0)
    shortest = math.dist(START, corner_left) + 1.0 + math.dist(corner_right, GOAL)
    assert has_way(rrt)
    assert shortest - 0.01 <= rrt.best_cells < 1.06 * shortest


@pytest.mark.parametrize("seed", range(8))
def test_a_gap_of_one_cell_is_passed_through_its_middle_or_not_at_all(seed: int) -> None:
    _, clearance = with_walls(wall_with_gap(range(70, 71)))
    rrt = plan(clearance, seed=seed)
    lib.rrtstar_extend(rrt, clearance, 20000)
    if has_way(rrt):
        assert_good(rrt, clearance, START, GOAL)
    else:
        assert rrt.status in (lib.RRTSTAR_POOL_FULL, lib.RRTSTAR_SEARCHING)


def test_most_seeds_find_a_door() -> None:
    _, clearance = with_walls(wall_with_gap(range(70, 77)))
    found = 0
    for seed in range(20):
        rrt = plan(clearance, seed=seed)
        lib.rrtstar_extend(rrt, clearance, 3000)
        found += has_way(rrt)
    assert found >= 18


@given(seeds)
def test_a_closed_wall_is_never_passed(seed: int) -> None:
    _, clearance = with_walls(wall_with_gap(range(0)))
    rrt = plan(clearance, seed=seed)
    lib.rrtstar_extend(rrt, clearance, 2000)
    assert not has_way(rrt)
    assert path_of(rrt) == []


def test_the_pool_ends_and_what_was_found_stands() -> None:
    _, clearance = with_walls(wall_with_gap(range(110, SIDE)))
    rrt = plan(clearance)
    for _ in range(500):
        if lib.rrtstar_extend(rrt, clearance, 100) == lib.RRTSTAR_POOL_FULL:
            break
    before = raw_bytes(rrt)
    assert lib.rrtstar_extend(rrt, clearance, 100) in (lib.RRTSTAR_POOL_FULL, lib.RRTSTAR_FOUND)
    if rrt.status == lib.RRTSTAR_POOL_FULL:
        assert raw_bytes(rrt) == before
        assert rrt.count == lib.RRTSTAR_NODES
    assert_good(rrt, clearance, START, GOAL)


@pytest.mark.parametrize("bad", [(64.5, 10.5), (-1.0, 5.0), (5.0, 128.0), (math.nan, 5.0)])
def test_a_blocked_end_is_said_so(bad: Point) -> None:
    _, clearance = with_walls(wall_with_gap(range(0)))
    assert plan(clearance, start=bad).status == lib.RRTSTAR_START_BLOCKED
    rrt = plan(clearance, goal=bad)
    assert rrt.status == lib.RRTSTAR_GOAL_BLOCKED
    before = raw_bytes(rrt)
    assert lib.rrtstar_extend(rrt, clearance, 50) == lib.RRTSTAR_GOAL_BLOCKED
    assert raw_bytes(rrt) == before
    assert path_of(rrt) == []


@given(st.floats(0.0, 127.9375, width=32), st.floats(0.0, 127.9375, width=32), seeds)
def test_every_free_place_of_the_grid_may_be_an_end(x: float, y: float, seed: int) -> None:
    _, clearance = with_walls({(60, 60)} - {(int(x), int(y))})
    rrt = plan(clearance, start=(x, y), goal=(y, x), seed=seed)
    lib.rrtstar_extend(rrt, clearance, 200)
    assert has_way(rrt) or rrt.status == lib.RRTSTAR_GOAL_BLOCKED
    if has_way(rrt):
        assert_good(rrt, clearance, (x, y), (y, x))


def test_a_path_that_does_not_fit_is_not_given() -> None:
    _, clearance = with_walls(wall_with_gap(range(110, SIDE)))
    rrt = plan(clearance)
    lib.rrtstar_extend(rrt, clearance, 2000)
    full = path_of(rrt)
    assert len(full) > 2
    assert path_of(rrt, len(full)) == full
    assert path_of(rrt, len(full) - 1) == []


def test_samples_stay_where_a_shorter_way_could_lead() -> None:
    _, clearance = with_walls(wall_with_gap(range(84, SIDE)))
    rrt = plan(clearance)
    while not has_way(rrt):
        lib.rrtstar_extend(rrt, clearance, 1)
    count, best = rrt.count, rrt.best_cells
    lib.rrtstar_extend(rrt, clearance, 300)
    for node in rrt.nodes[count : rrt.count]:
        spot = (node.x / 512, node.y / 512)
        around = math.dist(spot, xy(rrt.start_cells)) + math.dist(spot, xy(rrt.goal_cells))
        assert around <= best + 0.05
