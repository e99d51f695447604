# SPDX-License-Identifier: GPL-3.0-or-later
"""Two trees in one pool, after any sequence of operations, against a plain model of them."""

import random
from collections.abc import Iterable
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.forest import (
    GOAL,
    NODES,
    NONE,
    START,
    Forest,
    Node,
    checked,
    cost,
    squared_steps,
)
from tests.core.maps import PER_CELL, STEPS_MAX, Steps, lattice

seeds = st.integers(0, 2**32 - 1)
OPERATIONS = 80
SPREADS = (40, 3000, STEPS_MAX)  # all in one place, in a few buckets, everywhere


def above(forest: Forest, i: int) -> list[int]:
    """A node and all its ancestors."""
    way = [i]
    while forest[way[-1]].parent != NONE:
        way.append(forest[way[-1]].parent)
    return way


def turned_round(forest: Forest, node: int, parent: int) -> None:
    """Reverse an edge chain in the model: the node's ancestors become its descendants."""
    way = above(forest, node)
    for child, new in zip(way, [parent, *way], strict=False):
        forest[child] = replace(forest[child], parent=new)


def hanging_on(forest: Forest, root: int) -> set[int]:
    return {i for i in forest if root in above(forest, i)}


class Random:
    """Random operations on a tree and on a model of it."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.spread = self.rng.choice(SPREADS)
        self.tree = ffi.new("tree_t *")
        lib.tree_clear(self.tree)
        self.model: Forest = {}
        assert self.add(GOAL, NONE) == 0
        self.start = self.add(START, NONE)

    def place(self) -> Steps:
        low = (STEPS_MAX - self.spread) // 2
        return low + self.rng.randint(0, self.spread), low + self.rng.randint(0, self.spread)

    def any_of(self, nodes: Iterable[int]) -> int | None:
        choice = sorted(nodes)
        return self.rng.choice(choice) if choice else None

    def side(self, side: int) -> set[int]:
        return {i for i, node in self.model.items() if node.side == side}

    def add(self, side: int, parent: int) -> int:
        at = self.place()
        node = lib.tree_add(self.tree, side, lattice(at), parent)
        if len(self.model) == NODES:
            assert node == NONE
        else:
            assert node not in self.model
            self.model[node] = Node(at, parent, side)
        return int(node)

    def grow(self) -> None:
        parent = self.rng.choice(sorted(self.model))
        self.add(self.model[parent].side, parent)

    def drop(self) -> None:
        parents = {node.parent for node in self.model.values()}
        node = self.any_of(self.side(GOAL) - parents - {0, self.start})
        if node is not None:
            lib.tree_drop(self.tree, node)
            del self.model[node]

    def move(self) -> None:
        node = self.any_of(self.side(GOAL) - {0})
        if node is not None:
            parent = self.any_of(self.side(GOAL) - hanging_on(self.model, node))
            lib.tree_move(self.tree, node, parent)
            self.model[node] = replace(self.model[node], parent=parent)

    def join(self) -> None:
        to, from_start = self.any_of(self.side(GOAL)), self.any_of(self.side(START))
        if from_start is not None:
            lib.tree_join(self.tree, to, from_start)
            turned_round(self.model, from_start, to)
            self.model = {i: replace(node, side=GOAL) for i, node in self.model.items()}

    def do(self) -> None:
        operations = [self.grow] * 6 + [self.drop] * 2 + [self.move, self.move]
        if self.rng.random() < 0.02:
            self.join()
        self.rng.choice(operations)()


@given(seeds)
def test_any_operations_give_what_the_plain_model_gives(seed: int) -> None:
    run = Random(seed)
    for _ in range(OPERATIONS):
        run.do()
        assert checked(run.tree) == run.model


@given(seeds)
def test_a_full_pool_stays_sound(seed: int) -> None:
    run = Random(seed)
    while not lib.tree_is_full(run.tree):
        run.grow()
    assert len(run.model) == NODES
    assert run.add(GOAL, 0) == NONE
    for operation in (run.move, run.join, run.move, run.drop, run.drop, run.grow):
        operation()
        assert checked(run.tree) == run.model
        assert lib.tree_is_full(run.tree) == (len(run.model) == NODES)


@given(seeds)
def test_the_nearest_node_is_the_nearest(seed: int) -> None:
    run = Random(seed)
    for _ in range(30):
        run.grow()
    for side in (GOAL, START):
        for at in [run.place() for _ in range(5)] + [(0, 0), (STEPS_MAX, STEPS_MAX)]:
            squared = squared_steps(run.model, side, at)
            nearest = lib.tree_nearest(run.tree, side, lattice(at))
            assert squared[nearest] == min(squared.values())


def near(tree: CData, at: Steps, radius_cells: int) -> dict[int, float]:
    found = ffi.new("tree_near_t *")
    lib.tree_near(tree, lattice(at), radius_cells, found)
    got = {found.nodes[i]: found.distance_cells[i] for i in range(found.count)}
    assert len(got) == found.count <= lib.TREE_NEAR
    return got


@given(seeds, st.sampled_from([1, 15, 24, 127]))
def test_the_near_nodes_are_the_nearest_of_the_goals_side(seed: int, radius_cells: int) -> None:
    run = Random(seed)
    for _ in range(60):
        run.grow()
    for at in [run.place() for _ in range(5)] + [(0, 0), (STEPS_MAX, 0)]:
        squared = squared_steps(run.model, GOAL, at)
        inside = sorted(s for s in squared.values() if s < (radius_cells * PER_CELL) ** 2)
        found = near(run.tree, at, radius_cells)
        assert sorted(squared[i] for i in found) == inside[: lib.TREE_NEAR]
        for i, distance_cells in found.items():
            assert distance_cells == pytest.approx(squared[i] ** 0.5 / PER_CELL, rel=1e-5)


@given(seeds)
def test_a_node_is_found_exactly_where_it_is(seed: int) -> None:
    run = Random(seed)
    for _ in range(40):
        run.grow()
    places = [node.at for node in run.model.values()] + [run.place() for _ in range(10)]
    for at in places:
        there = {i for i, n in run.model.items() if n.side == GOAL and n.at == at}
        found = lib.tree_find(run.tree, lattice(at))
        assert found in there or (found == NONE and not there)


def test_nothing_is_near_in_an_empty_tree() -> None:
    tree = ffi.new("tree_t *")
    lib.tree_clear(tree)
    assert near(tree, (5, 5), 127) == {}
    assert lib.tree_find(tree, lattice((5, 5))) == NONE
    assert checked(tree) == {}


def test_a_joined_tree_leads_from_the_start_to_the_goal() -> None:
    run = Random(3)
    while len(run.model) < 100:
        run.grow()
    run.join()
    assert cost(run.model, run.start) > 0.0
    assert above(run.model, run.start)[-1] == 0
    assert run.tree.nodes[run.start].cost_cells == pytest.approx(cost(run.model, run.start))


def test_clearing_forgets_everything() -> None:
    run = Random(4)
    for _ in range(200):
        run.do()
    lib.tree_clear(run.tree)
    assert checked(run.tree) == {}
    assert lib.tree_add(run.tree, GOAL, lattice((1, 2)), NONE) == 0
