# SPDX-License-Identifier: GPL-3.0-or-later
"""The inflated bit layer equals brute force, however it was updated."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core import oracles
from tests.core.maps import (
    OCCUPIED,
    SIDE,
    blocked_bits,
    from_picture,
    new_clearance,
    new_grid,
    occupy,
    raw_bytes,
    values,
    vec2,
    with_walls,
    xy,
)

CELL_M = 0.05
cells = st.tuples(st.integers(0, SIDE - 1), st.integers(0, SIDE - 1))
walls = st.sets(cells, max_size=40)
radii = st.just(0.0) | st.floats(2.0**-10, 0.578125, width=32)
# A small room full of obstacles, where segments meet many cells; an eighth is exact in every step.
rooms = st.sets(st.tuples(st.integers(40, 51), st.integers(40, 51)), max_size=60)
eighths = st.integers(39 * 8, 53 * 8).map(lambda n: n / 8)
spots = st.tuples(eighths, eighths)
loose = st.floats(39.0, 53.0, width=32)


def occupied(grid: CData) -> oracles.Bits:
    return np.asarray(values(grid) >= lib.GRID_OCCUPIED_MIN)


@given(walls, radii)
def test_a_clearance_from_scratch_equals_brute_force(
    where: set[tuple[int, int]], radius_m: float
) -> None:
    grid = new_grid(CELL_M)
    occupy(grid, where)
    got = blocked_bits(new_clearance(grid, radius_m))
    radius_cells = float(np.float32(radius_m) * grid.cells_per_m)
    assert (got == oracles.inflated(occupied(grid), radius_cells)).all()


@given(walls, st.lists(st.tuples(cells, st.integers(0, 15)), max_size=30), radii, st.data())
def test_an_updated_clearance_equals_a_new_one(
    where: set[tuple[int, int]],
    changes: list[tuple[tuple[int, int], int]],
    radius_m: float,
    data: st.DataObject,
) -> None:
    grid = new_grid(CELL_M)
    occupy(grid, where)
    clearance = new_clearance(grid, radius_m)
    for (ix, iy), value in changes:
        lib.grid_set_value(grid, ix, iy, value)
        if data.draw(st.booleans()):
            lib.clearance_mark(clearance, grid)
            lib.clearance_refresh(clearance, grid, data.draw(st.integers(0, 20)))
    lib.clearance_mark(clearance, grid)
    while lib.clearance_refresh(clearance, grid, 7) > 0:
        pass
    assert raw_bytes(clearance) == raw_bytes(new_clearance(grid, radius_m))


@given(walls, radii, radii)
def test_another_radius_equals_a_new_clearance_and_opens_nothing_before(
    where: set[tuple[int, int]], radius_m: float, other_m: float
) -> None:
    grid = new_grid(CELL_M)
    occupy(grid, where)
    clearance = new_clearance(grid, radius_m)
    before = blocked_bits(clearance)
    far = vec2(100.0, 100.0)
    lib.clearance_configure(clearance, grid, other_m, vec2(-100.0, -100.0), far)
    assert (blocked_bits(clearance) == before).all()
    assert lib.clearance_refresh(clearance, grid, SIDE) == 0
    assert (blocked_bits(clearance) == blocked_bits(new_clearance(grid, other_m))).all()


def test_refreshing_is_bounded_and_says_what_is_left() -> None:
    grid = new_grid()
    clearance = ffi.new("clearance_t *")
    lib.clearance_init(clearance, grid, 0.1, vec2(-9.0, -9.0), vec2(9.0, 9.0))
    left = [lib.clearance_refresh(clearance, grid, 50) for _ in range(4)]
    assert left == [78, 28, 0, 0]
    lib.grid_set_value(grid, 60, 60, OCCUPIED)
    lib.clearance_mark(clearance, grid)
    assert lib.clearance_refresh(clearance, grid, 0) == 2 * clearance.reach + 1
    assert not any(grid.changed_rows)


@given(*[st.floats(-4.0, 4.0)] * 4)
def test_cells_that_are_not_wholly_inside_the_fence_are_blocked(
    x0: float, y0: float, x1: float, y1: float
) -> None:
    grid = new_grid(CELL_M)
    blocked = blocked_bits(new_clearance(grid, 0.0, (x0, y0), (x1, y1)))
    slack_m = 1e-4
    low = grid.origin_m.x + np.arange(SIDE) * CELL_M
    for axis, (start, end) in enumerate(((x0, x1), (y0, y1))):
        inside = (low >= start - slack_m) & (low + CELL_M <= end + slack_m)
        surely = (low >= start + slack_m) & (low + CELL_M <= end - slack_m)
        free = ~blocked.all(axis=axis)
        other = ~blocked.all(axis=1 - axis)
        assert not (free & ~inside).any()
        assert not (surely & ~free).any() or not other.any()


def test_the_default_fence_of_a_room_leaves_the_whole_grid() -> None:
    blocked = blocked_bits(new_clearance(new_grid(CELL_M), 0.0, (-3.2, -3.2), (3.2, 3.2)))
    assert not blocked.any()


@pytest.mark.parametrize("cell", [(-1, 0), (0, -1), (SIDE, 5), (5, SIDE), (10**6, 0)])
def test_outside_the_grid_is_blocked(cell: tuple[int, int]) -> None:
    clearance = new_clearance(new_grid())
    assert lib.clearance_blocked(clearance, *cell)
    assert lib.clearance_blocked_at(clearance, vec2(cell[0] + 0.5, cell[1] + 0.5))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e30])
def test_a_place_that_is_nowhere_is_blocked(bad: float) -> None:
    clearance = new_clearance(new_grid())
    assert lib.clearance_blocked_at(clearance, vec2(bad, 5.0))
    assert not lib.clearance_segment_free(clearance, vec2(5.0, 5.0), vec2(5.0, bad))
    assert not lib.clearance_nearest_free(clearance, vec2(bad, 5.0), 5, ffi.new("vec2_t *"))


@given(rooms, spots, spots)
def test_a_segment_is_free_exactly_if_its_cells_are(
    where: set[tuple[int, int]], a: tuple[float, float], b: tuple[float, float]
) -> None:
    _, clearance = with_walls(where)
    expected = oracles.segment_free(blocked_bits(clearance), a, b)
    assert lib.clearance_segment_free(clearance, vec2(*a), vec2(*b)) == expected


@given(rooms, loose, loose, loose, loose)
def test_a_free_segment_touches_nothing_blocked_by_more_than_rounding(
    where: set[tuple[int, int]], ax: float, ay: float, bx: float, by: float
) -> None:
    _, clearance = with_walls(where)
    got = lib.clearance_segment_free(clearance, vec2(ax, ay), vec2(bx, by))
    blocked = blocked_bits(clearance)
    exact = oracles.segment_free(blocked, (ax, ay), (bx, by))
    if got != exact:  # only a corner missed or met by less than a thousandth of a cell may differ
        shifts = [(dx, dy) for dx in (-1e-3, 0, 1e-3) for dy in (-1e-3, 0, 1e-3)]
        near = {
            oracles.segment_free(blocked, (ax + dx, ay + dy), (bx + dx, by + dy))
            for dx, dy in shifts
        }
        assert got in near


@given(rooms, spots, spots)
def test_a_segment_is_as_free_as_the_other_way_round(
    where: set[tuple[int, int]], a: tuple[float, float], b: tuple[float, float]
) -> None:
    _, clearance = with_walls(where)
    there = lib.clearance_segment_free(clearance, vec2(*a), vec2(*b))
    assert lib.clearance_segment_free(clearance, vec2(*b), vec2(*a)) == there


def test_nothing_squeezes_between_two_cells_that_touch_at_a_corner() -> None:
    _, clearance = with_walls(from_picture([".#", "#."], 10, 10))
    assert not lib.clearance_segment_free(clearance, vec2(10.5, 11.5), vec2(11.5, 10.5))
    assert not lib.clearance_segment_free(clearance, vec2(11.5, 10.5), vec2(10.5, 11.5))
    _, clearance = with_walls(from_picture(["..", "#."], 10, 10))
    assert lib.clearance_segment_free(clearance, vec2(10.5, 11.5), vec2(11.5, 10.5))


@given(
    st.sets(st.tuples(st.integers(58, 70), st.integers(58, 70)), max_size=150), st.integers(0, 9)
)
def test_the_nearest_free_cell_is_the_nearest(where: set[tuple[int, int]], most: int) -> None:
    _, clearance = with_walls(where)
    point = (64.3, 64.6)
    found = ffi.new("vec2_t *")
    free = [
        math.dist(point, (x + 0.5, y + 0.5))
        for x in range(50, 80)
        for y in range(50, 80)
        if (x, y) not in where
    ]
    nearest = min(free)
    got = lib.clearance_nearest_free(clearance, vec2(*point), most, found)
    assert got or nearest > most
    if got:
        assert math.dist(point, xy(found[0])) == pytest.approx(nearest, abs=1e-4)
        assert not lib.clearance_blocked_at(clearance, found[0])
