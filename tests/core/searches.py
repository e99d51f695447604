# SPDX-License-Identifier: GPL-3.0-or-later
"""Searches of the pathfinder for tests, and the invariants of their paths."""

import math

import pytest
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import (
    PER_CELL,
    SIDE,
    Cell,
    Point,
    is_clear,
    length,
    points,
    vec2,
)

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
    planner = ffi.new("pathfinder_t *")
    cfg = ffi.new("pathfinder_config_t *", lib.pathfinder_config_default())
    for name, value in changes.items():
        setattr(cfg, name, value)
    lib.pathfinder_start(planner, cfg, clearance, vec2(*start), vec2(*goal), seed)
    return planner


def extend(planner: CData, clearance: CData, budget: int) -> int:
    return int(lib.pathfinder_extend(planner, clearance, ffi.NULL, budget))


def finish(planner: CData, clearance: CData) -> int:
    """Search until a path is known or there is none, and then a little longer."""
    for _ in range(0, LONGEST, 100):
        if extend(planner, clearance, 100) != lib.PATHFINDER_SEARCHING:
            return extend(planner, clearance, MORE)
    raise AssertionError("the search does not end")


def path_of(planner: CData, capacity: int = lib.PATHFINDER_POINTS) -> list[Point]:
    array = ffi.new("vec2_t[]", capacity)
    return points(array, lib.pathfinder_path(planner, array, capacity))


def assert_good(planner: CData, clearance: CData, start: Point, goal: Point) -> None:
    path = path_of(planner)
    assert planner.status == lib.PATHFINDER_FOUND
    for end, wanted in ((path[0], start), (path[-1], goal)):
        assert math.dist(end, wanted) <= math.hypot(NEAR_CELLS, 1 / PER_CELL)
        assert [math.floor(c) for c in end] == [math.floor(c) for c in wanted]
    assert is_clear(clearance, path)
    assert length(path) == pytest.approx(planner.best_cells, rel=1e-4, abs=1e-4)
    assert lib.pathfinder_nodes(planner) <= lib.TREE_NODES
