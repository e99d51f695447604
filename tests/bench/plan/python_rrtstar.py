# SPDX-License-Identifier: GPL-3.0-or-later
"""RRT* in plain Python, as it is usually taught: linear search, short steps, sampled edges."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tests.bench.plan.exact import Bits, Place
from tests.bench.plan.problems import Problem
from tests.bench.plan.runs import Columns

ITERATIONS = 1000
STEP_CELLS = 5.0
GOAL_BIAS = 0.1
NEAR_CELLS = 50.0
COUNTS = ("nodes_105", "bytes_105", "bytes_end")


@dataclass(slots=True)
class _Node:
    at: Place
    cost: float
    parent: _Node | None
    children: list[_Node] = field(default_factory=list)


class PlainTree:
    """One search on one map."""

    def __init__(self, blocked: Bits, start: Place, goal: Place, seed: int) -> None:
        self._cells: list[list[bool]] = blocked.tolist()
        self._goal = goal
        self._random = random.Random(seed)
        self._nodes = [_Node(start, 0.0, None)]
        self._near_goal: list[_Node] = []

    @property
    def best(self) -> float:
        """Length of the best path so far."""
        ways = (node.cost + math.dist(node.at, self._goal) for node in self._near_goal)
        return min(ways, default=math.inf)

    @property
    def size(self) -> int:
        return len(self._nodes)

    def grow(self) -> None:
        """One iteration of Karaman and Frazzoli's algorithm 6."""
        target = self._target()
        nearest = min(self._nodes, key=lambda node: math.dist(node.at, target))
        distance = math.dist(nearest.at, target)
        if distance == 0.0:
            return
        if distance > STEP_CELLS:
            part = STEP_CELLS / distance
            (x, y), (to_x, to_y) = nearest.at, target
            target = (x + part * (to_x - x), y + part * (to_y - y))
        if self._free(nearest.at, target):
            self._add(target, nearest)

    def _target(self) -> Place:
        if self._random.random() < GOAL_BIAS:
            return self._goal
        height, width = len(self._cells), len(self._cells[0])
        return (self._random.uniform(0, width), self._random.uniform(0, height))

    def _add(self, at: Place, nearest: _Node) -> None:
        count = len(self._nodes) + 1
        radius = min(NEAR_CELLS * math.sqrt(math.log(count) / count), 5 * STEP_CELLS)
        near = [node for node in self._nodes if math.dist(node.at, at) <= radius]
        parent, cost = nearest, nearest.cost + math.dist(nearest.at, at)
        for node in near:
            through = node.cost + math.dist(node.at, at)
            if through < cost and self._free(node.at, at):
                parent, cost = node, through
        added = _Node(at, cost, parent)
        parent.children.append(added)
        self._nodes.append(added)
        for node in near:
            through = cost + math.dist(at, node.at)
            if through < node.cost - 1e-9 and self._free(at, node.at):
                self._rewire(node, added, through)
        if math.dist(at, self._goal) <= STEP_CELLS and self._free(at, self._goal):
            self._near_goal.append(added)

    def _rewire(self, node: _Node, parent: _Node, cost: float) -> None:
        assert node.parent is not None
        node.parent.children.remove(node)
        node.parent = parent
        parent.children.append(node)
        saved, ahead = node.cost - cost, [node]
        while ahead:
            below = ahead.pop()
            below.cost -= saved
            ahead += below.children

    def _free(self, a: Place, b: Place) -> bool:
        """Check a segment at every half cell."""
        count = int(2 * math.dist(a, b)) + 1
        for k in range(count + 1):
            part = k / count
            x, y = a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])
            if self._cells[int(y)][int(x)]:
                return False
        return True


def run_plain(problem: Problem, seed: int) -> dict[str, float]:
    """Times and costs of 1000 iterations, by the names of drive.c's header."""
    tree = PlainTree(problem.blocked, problem.start, problem.goal, seed)
    began_s = time.thread_time()
    found = dict.fromkeys(("first_s", "first_cost", "within_105_s", "within_102_s"), math.inf)
    best = math.inf
    for _ in range(ITERATIONS):
        tree.grow()
        if tree.best < best:
            now_s, before, best = time.thread_time() - began_s, best, tree.best
            if before == math.inf:
                found["first_s"], found["first_cost"] = now_s, best
            for name, factor in (("within_105_s", 1.05), ("within_102_s", 1.02)):
                if best <= factor * problem.optimum < before:
                    found[name] = now_s
    found |= {"end_s": time.thread_time() - began_s, "cost": best, "fixed_cost": best}
    never = ("enough_s", "enough_cost", "flown_cost", "clearance")
    unknown = dict.fromkeys(never, math.inf) | dict.fromkeys(COUNTS, -1.0)
    return found | unknown | {"nodes_end": tree.size, "samples": ITERATIONS, "invalid": 0}


def run_plain_on(problems: Sequence[Problem], seed: int) -> Columns:
    """Run it on a set; one row per problem, as the compiled drivers print them."""
    rows = [run_plain(problem, seed * 7919 + k) for k, problem in enumerate(problems)]
    columns = {name: np.array([row[name] for row in rows], float) for name in rows[0]}
    return {"problem": np.arange(len(rows), dtype=float)} | columns
