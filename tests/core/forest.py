# SPDX-License-Identifier: GPL-3.0-or-later
"""Invariants of the two trees in a pool, checked on the struct alone."""

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
import pytest

from ground.core import CData, lib
from tests.core.maps import PER_CELL, Steps

NONE: int = lib.TREE_NONE
GOAL, START = lib.TREE_OF_GOAL, lib.TREE_OF_START
NODES: int = lib.TREE_NODES
BUCKET_STEPS = 16 * PER_CELL


@dataclass(frozen=True)
class Node:
    at: Steps
    parent: int
    side: int


Forest = dict[int, Node]


def follow(first: int, after: list[int]) -> list[int]:
    """The members of a list that is linked by `after`."""
    found, i = [], first
    while i != NONE:
        found.append(i)
        assert len(found) <= NODES, "a list runs in a circle"
        i = after[i]
    return found


def bucket_of(at: Steps) -> int:
    return at[1] // BUCKET_STEPS * lib.TREE_BUCKET_SIDE + at[0] // BUCKET_STEPS


def checked(tree: CData) -> Forest:
    """The live nodes, after checking the invariants of nodes and links."""
    nodes = tree.nodes[0 : tree.count]
    after = [node.next for node in nodes]
    dropped = follow(tree.dropped, after)
    assert all(nodes[i].cost_cells < 0.0 for i in dropped)
    sides: dict[int, int] = {}
    for side in (GOAL, START):
        for b in range(lib.TREE_BUCKETS):
            for i in follow(tree.buckets[side][b], after):
                assert i not in sides, "a node is in two buckets"
                assert bucket_of((nodes[i].at.x, nodes[i].at.y)) == b
                sides[i] = side
    assert sorted([*sides, *dropped]) == list(range(tree.count)), "a node is lost"
    forest = {i: Node((nodes[i].at.x, nodes[i].at.y), nodes[i].parent, sides[i]) for i in sides}
    check_links(tree, forest)
    check_costs(tree, forest)
    return forest


def check_links(tree: CData, forest: Forest) -> None:
    """Check that each node but a root is a child once, of its parent, on the same side."""
    after = [node.sibling for node in tree.nodes[0 : tree.count]]
    children = Counter((i, child) for i in forest for child in follow(tree.nodes[i].child, after))
    assert children == Counter((n.parent, i) for i, n in forest.items() if n.parent != NONE)
    assert all(forest[n.parent].side == n.side for n in forest.values() if n.parent != NONE)


def check_costs(tree: CData, forest: Forest) -> None:
    """Check the lengths along the tree to the only root of each side."""
    roots = Counter(n.side for n in forest.values() if n.parent == NONE)
    assert set(roots.values()) <= {1}
    for i in forest:
        assert tree.nodes[i].cost_cells == pytest.approx(cost(forest, i), rel=1e-5, abs=1e-3)


def cost(forest: Forest, i: int) -> float:
    """Cost of a node [cells]."""
    total = 0.0
    while forest[i].parent != NONE:
        total += math.dist(forest[i].at, forest[forest[i].parent].at)
        i = forest[i].parent
    return total / PER_CELL


def squared_steps(forest: Forest, side: int, at: Steps) -> dict[int, int]:
    """Squared distances of a side's nodes from a place."""
    here = np.array(at)
    return {
        i: int(((np.array(n.at) - here) ** 2).sum()) for i, n in forest.items() if n.side == side
    }
