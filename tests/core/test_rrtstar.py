# SPDX-License-Identifier: GPL-3.0-or-later
"""The two trees: sound after every sample, with a clear path and samples where they help."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.forest import GOAL, START, Forest, checked
from tests.core.maps import (
    PER_CELL,
    SIDE,
    Steps,
    in_cells,
    is_clear,
    lattice,
    lattice_array,
    lattice_points,
    length,
    middle,
    raw_bytes,
    sees,
    with_walls,
)
from tests.core.searches import Boxes, furnish, seeds, wall_with_gap

FROM, TO = middle((20, 64)), middle((108, 64))
NONE: int = lib.TREE_NONE
boxes = st.lists(
    st.tuples(st.integers(0, 110), st.integers(0, 110), st.integers(2, 18), st.integers(2, 18)),
    max_size=14,
)


def furnished(where: Boxes) -> CData:
    return with_walls(furnish(where, (20, 64), (108, 64)))[1]


def gap_in_wall(gap: range) -> CData:
    return with_walls(wall_with_gap(gap))[1]


def begin(seed: int = 1, step_cells: float = 20.0) -> CData:
    rrt = ffi.new("rrtstar_t *")
    lib.rrtstar_start(rrt, lattice(FROM), lattice(TO), step_cells, seed)
    return rrt


def sample(rrt: CData, clearance: CData, count: int) -> None:
    """Sample as the planner does: with the best known length."""
    for _ in range(count):
        if lib.rrtstar_sample(rrt, clearance):
            rrt.best_cells = min(rrt.best_cells, cost(rrt))


def cost(rrt: CData) -> float:
    return float(rrt.tree.nodes[rrt.start_node].cost_cells)


def way_of(rrt: CData, clearance: CData, capacity: int = 64) -> list[Steps]:
    array = ffi.new("lattice_t[]", capacity)
    return lattice_points(array, lib.rrtstar_way(rrt, clearance, array, capacity))


def assert_sound(rrt: CData, clearance: CData) -> Forest:
    """Check that both trees are connected to their roots, and that every edge is free."""
    forest = checked(rrt.tree)
    assert forest[0].at == TO
    assert forest[rrt.start_node].at == FROM
    assert {n.side for n in forest.values()} == ({GOAL} if rrt.connected else {GOAL, START})
    for node in forest.values():
        if node.parent != NONE:
            assert sees(clearance, [node.at, forest[node.parent].at])
    return forest


def assert_good_way(rrt: CData, clearance: CData) -> None:
    way = way_of(rrt, clearance)
    assert (way[0], way[-1]) == (FROM, TO)
    assert sees(clearance, way)
    assert is_clear(clearance, in_cells(way))
    assert length(in_cells(way)) <= cost(rrt) + 1e-3


@given(boxes, seeds)
def test_the_trees_are_sound_and_their_way_gets_shorter(
    where: list[tuple[int, int, int, int]], seed: int
) -> None:
    clearance = furnished(where)
    rrt = begin(seed)
    best = math.inf
    for count in [1] * 10 + [30] * 10 + [500]:
        sample(rrt, clearance, count)
        assert_sound(rrt, clearance)
        if rrt.connected:
            assert_good_way(rrt, clearance)
            assert cost(rrt) <= best + 1e-3
            best = cost(rrt)
        else:
            assert way_of(rrt, clearance) == []


@given(boxes, seeds)
def test_a_sample_says_when_the_way_has_become_shorter(
    where: list[tuple[int, int, int, int]], seed: int
) -> None:
    clearance = furnished(where)
    rrt = begin(seed)
    known = math.inf
    for _ in range(300):
        said = bool(lib.rrtstar_sample(rrt, clearance))
        now = cost(rrt) if rrt.connected else math.inf
        assert said == (now < known)
        known = now
        rrt.best_cells = min(rrt.best_cells, now)


def test_the_seed_decides() -> None:
    clearance = gap_in_wall(range(10, 20))
    runs = [begin(seed) for seed in (1, 1, 2)]
    for rrt in runs:
        sample(rrt, clearance, 200)
    assert raw_bytes(runs[0]) == raw_bytes(runs[1])
    assert raw_bytes(runs[0]) != raw_bytes(runs[2])


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("step_cells", [5.0, 20.0])
def test_until_there_is_a_way_no_edge_is_longer_than_a_step(seed: int, step_cells: float) -> None:
    clearance = gap_in_wall(range(0))
    rrt = begin(seed, step_cells)
    sample(rrt, clearance, 60)
    forest = assert_sound(rrt, clearance)
    assert len(forest) > 20
    for node in forest.values():
        if node.parent != NONE:
            edge = math.dist(node.at, forest[node.parent].at) / PER_CELL
            assert edge <= step_cells + 0.01


@pytest.mark.parametrize("seed", range(8))
def test_samples_stay_where_a_shorter_way_could_lead(seed: int) -> None:
    clearance = gap_in_wall(range(84, SIDE))
    rrt = begin(seed)
    while not rrt.connected:
        sample(rrt, clearance, 1)
    before, best = checked(rrt.tree), rrt.best_cells
    sample(rrt, clearance, 100)
    new = {i: node for i, node in checked(rrt.tree).items() if before.get(i) != node}
    added = [node.at for i, node in new.items() if i not in before]
    assert len(added) > 5
    for at in added:
        assert (math.dist(at, FROM) + math.dist(at, TO)) / PER_CELL <= best + 0.05


@pytest.mark.parametrize("seed", range(6))
def test_a_closed_wall_is_never_passed_and_in_the_end_it_is_stuck(seed: int) -> None:
    clearance = gap_in_wall(range(0))
    rrt = begin(seed)
    while not lib.rrtstar_stuck(rrt):
        sample(rrt, clearance, 10)
        assert not rrt.connected
    assert len(assert_sound(rrt, clearance)) == lib.TREE_NODES
    sample(rrt, clearance, 50)
    assert len(assert_sound(rrt, clearance)) == lib.TREE_NODES
    assert way_of(rrt, clearance) == []


@pytest.mark.parametrize("seed", range(6))
def test_a_full_pool_goes_on_improving(seed: int) -> None:
    """Each new node replaces a leaf, never a node of the path."""
    wall = {(x, y) for x in (40, 60, 80) for y in range(SIDE) if y % 25 not in (3, 4, 5)}
    _, clearance = with_walls(wall)
    rrt = begin(seed)
    while not lib.tree_is_full(ffi.addressof(rrt.tree)):
        sample(rrt, clearance, 10)
    improved = 0
    for _ in range(20):
        before = checked(rrt.tree)
        sample(rrt, clearance, 200)
        after = assert_sound(rrt, clearance)
        improved += set(after.values()) != set(before.values())
        assert len(after) <= lib.TREE_NODES
        assert_good_way(rrt, clearance)
    assert improved == 20


@given(seeds, st.integers(0, 400))
def test_a_way_from_elsewhere_is_taken_in(seed: int, count: int) -> None:
    clearance = gap_in_wall(range(84, SIDE))
    rrt = begin(seed)
    while not rrt.connected:
        sample(rrt, clearance, 1)
    sample(rrt, clearance, count)
    steps = lib.CLEARANCE_CORNER_STEPS
    height = 84 * PER_CELL + steps
    way = [FROM, (64 * PER_CELL - steps, height), (65 * PER_CELL + steps, height), TO]
    assert sees(clearance, way)
    lib.rrtstar_graft(rrt, lattice_array(way), len(way))
    assert cost(rrt) == pytest.approx(length(in_cells(way)), abs=0.02)
    assert_sound(rrt, clearance)
    assert_good_way(rrt, clearance)


def test_all_but_a_way_is_forgotten() -> None:
    clearance = gap_in_wall(range(84, SIDE))
    rrt = begin()
    way = [FROM, middle((60, 90)), middle((70, 90)), TO]
    lib.rrtstar_restart_from(rrt, lattice_array(way), len(way))
    forest = assert_sound(rrt, clearance)
    assert sorted(node.at for node in forest.values()) == sorted(way)
    assert_good_way(rrt, clearance)
    assert cost(rrt) == pytest.approx(length(in_cells(way)), rel=1e-5)


WAY = [FROM, middle((50, 100)), middle((60, 95)), middle((70, 95)), middle((90, 90)), TO]


@pytest.mark.parametrize(("before", "after"), [(0, 0), (1, 0), (0, 4), (2, 2), (3, 1)])
def test_both_sides_begin_with_what_is_left_of_a_broken_way(before: int, after: int) -> None:
    clearance = gap_in_wall(range(84, 108))
    rrt = begin()
    lib.rrtstar_mend(rrt, lattice_array(WAY), len(WAY), before, after)
    forest = assert_sound(rrt, clearance)
    sides = {
        side: {node.at for node in forest.values() if node.side == side} for side in (START, GOAL)
    }
    assert sides[START] == set(WAY[: before + 1])
    assert sides[GOAL] == set(WAY[len(WAY) - 1 - after :])
    for _ in range(4000):
        sample(rrt, clearance, 1)
        if rrt.connected:
            break
    assert_sound(rrt, clearance)
    assert_good_way(rrt, clearance)


def test_the_first_samples_after_a_break_come_from_about_it() -> None:
    clearance = gap_in_wall(range(0))
    rrt = begin()
    lib.rrtstar_mend(rrt, lattice_array(WAY), len(WAY), 2, 2)
    known = {node.at for node in checked(rrt.tree).values()}
    focus = middle((65, 95))
    for count in (4, 8):
        sample(rrt, clearance, 4)
        new = [node.at for node in checked(rrt.tree).values() if node.at not in known]
        reach_cells = (10 + 2 * count) * math.sqrt(2) + 20.0
        assert all(math.dist(at, focus) / PER_CELL <= reach_cells for at in new)


def test_a_way_that_does_not_fit_is_not_given() -> None:
    clearance = gap_in_wall(range(84, 108))
    rrt = begin()
    lib.rrtstar_restart_from(rrt, lattice_array(WAY), len(WAY))
    full = way_of(rrt, clearance)
    assert 2 < len(full) <= len(WAY)
    assert way_of(rrt, clearance, len(full)) == full
    assert way_of(rrt, clearance, 2) == []


def test_points_in_sight_of_each_other_are_left_out_of_a_way() -> None:
    _, clearance = with_walls([])
    rrt = begin()
    lib.rrtstar_restart_from(rrt, lattice_array(WAY), len(WAY))
    assert way_of(rrt, clearance) == [FROM, TO]
    assert all(sees(clearance, [a, b]) for a, b in itertools.combinations(WAY, 2))
