# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole pathfinder: every path is clear and as long as stated, every search is decided."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import lib
from tests.core import oracles
from tests.core.forest import checked
from tests.core.maps import (
    PER_CELL,
    SIDE,
    blocked_bits,
    is_clear,
    raw_bytes,
    with_walls,
    xy,
)
from tests.core.searches import (
    GOAL,
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


@given(boxes, seeds, st.booleans())
def test_a_way_is_clear_and_as_long_as_it_says_and_never_gets_worse(
    where: Boxes, seed: int, grid_only: bool
) -> None:
    _, clearance = with_walls(furnish(where, (20, 64), (108, 64)))
    planner = begin(clearance, seed=seed, grid_only=grid_only)
    best = math.inf
    for budget in [1] * 20 + [17] * 40:
        extend(planner, clearance, budget)
        if planner.status == lib.PATHFINDER_FOUND:
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
    assert planner.status == lib.PATHFINDER_NO_WAY
    nearest = xy(lib.pathfinder_nearest(planner))
    away = min(math.dist(centre(cell), centre(goal)) for cell in reachable)
    assert (math.floor(nearest[0]), math.floor(nearest[1])) in reachable
    assert math.dist(nearest, centre(goal)) == pytest.approx(away, abs=1e-2)
    assert lib.pathfinder_enough(planner)


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
    """A wall of many doors: after ten times as many samples as nodes, new nodes still enter."""
    wall = {(x, y) for x in (40, 60, 80) for y in range(SIDE) if y % 25 not in (3, 4, 5)}
    _, clearance = with_walls(wall)
    planner = begin(clearance, seed=seed)
    extend(planner, clearance, 10 * lib.TREE_NODES)
    assert planner.status == lib.PATHFINDER_FOUND
    before = [(n.x, n.y) for n in (node.at for node in planner.search.rrt.tree.nodes)]
    extend(planner, clearance, 10 * lib.TREE_NODES)
    after = [(n.x, n.y) for n in (node.at for node in planner.search.rrt.tree.nodes)]
    assert planner.stage != lib.PATHFINDER_END
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
    """The trees may meet in either door; the wavefront has looked at both."""
    _, clearance = with_walls(wall_with_gap(range(84, 90)) - {(64, y) for y in range(8, 30)})
    planner = begin(clearance, seed=seed)
    extend(planner, clearance, 2000)
    shortest = math.dist(START, (64.0, 84.0)) + 1.0 + math.dist((65.0, 84.0), GOAL)
    assert planner.best_cells == pytest.approx(shortest, abs=0.1)
