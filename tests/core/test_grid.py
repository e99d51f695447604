# SPDX-License-Identifier: GPL-3.0-or-later
"""The occupancy grid: where cells lie, how beams change them, what queries return."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import SIDE, fill, located, new_grid, raw_bytes, values, vec2, xy

CELL_M = 0.05
HALF_M = SIDE * CELL_M / 2
cells = st.integers(0, SIDE - 1)
positions = st.floats(-2.5, 2.5, width=32)


def row(query: CData, grid: CData, iy: int) -> list[int]:
    bits = ffi.new("uint32_t[]", lib.GRID_BIT_WORDS)
    query(grid, iy, bits)
    return [bits[ix // 32] >> ix % 32 & 1 for ix in range(SIDE)]


def changed_rows(grid: CData) -> set[int]:
    return {iy for iy in range(SIDE) if grid.changed_rows[iy // 32] >> iy % 32 & 1}


@given(positions, positions, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_a_point_lies_in_the_cell_that_covers_it(cx: float, cy: float, x: float, y: float) -> None:
    grid = new_grid(CELL_M, (cx, cy))
    found = located(grid, x, y)
    in_cells = lib.grid_to_cells(grid, vec2(x, y))
    inside = 0 <= in_cells.x < SIDE and 0 <= in_cells.y < SIDE
    assert (found is not None) == inside
    if found:
        assert found == (math.floor(in_cells.x), math.floor(in_cells.y))
        centre = lib.grid_centre_m(grid, ffi.new("grid_cell_t *", found)[0])
        assert abs(centre.x - x) <= CELL_M / 2 + 1e-4
        assert abs(centre.y - y) <= CELL_M / 2 + 1e-4


@pytest.mark.parametrize(
    ("x_m", "y_m", "cell"),
    [
        (0.01, 0.01, (64, 64)),
        (-0.01, 0.01, (63, 64)),
        (-0.01, -0.01, (63, 63)),
        (0.01, -0.01, (64, 63)),
    ],
)
def test_the_four_quadrants_meet_without_a_double_cell(
    x_m: float, y_m: float, cell: tuple[int, int]
) -> None:
    assert located(new_grid(), x_m, y_m) == cell


def test_the_edges_belong_to_the_grid_below_and_left_only() -> None:
    grid = new_grid()
    assert located(grid, -HALF_M, -HALF_M) == (0, 0)
    assert located(grid, HALF_M - 1e-3, HALF_M - 1e-3) == (SIDE - 1, SIDE - 1)
    assert located(grid, HALF_M, 0.0) is None
    assert located(grid, 0.0, HALF_M) is None
    assert located(grid, -HALF_M - 1e-3, 0.0) is None
    for bad in (math.nan, math.inf, -math.inf, 1e30):
        assert located(grid, bad, 0.0) is None
        assert located(grid, 0.0, bad) is None


@given(positions, positions)
def test_metres_to_cells_and_back(x_m: float, y_m: float) -> None:
    grid = new_grid(CELL_M, (0.3, -1.2))
    back = lib.grid_to_metres(grid, lib.grid_to_cells(grid, vec2(x_m, y_m)))
    assert xy(back) == pytest.approx((x_m, y_m), abs=1e-5)


@pytest.mark.parametrize(("asked", "got"), [(0.0, 0.02), (0.1, 0.1), (9.0, 0.5), (math.nan, 0.02)])
def test_the_cell_size_has_limits(asked: float, got: float) -> None:
    assert new_grid(asked).cell_m == pytest.approx(got)


@given(st.lists(st.tuples(cells, cells, st.integers(0, 15)), max_size=60))
def test_what_is_set_is_read_and_counted(settings: list[tuple[int, int, int]]) -> None:
    grid = new_grid()
    model = np.zeros((SIDE, SIDE), dtype=np.uint8)
    for ix, iy, value in settings:
        lib.grid_set_value(grid, ix, iy, value)
        model[iy, ix] = value
    assert (values(grid) == model).all()
    assert grid.known == np.count_nonzero(model)
    for ix, iy, _ in settings:
        assert lib.grid_value(grid, ix, iy) == model[iy, ix]
        for y in (iy - 1, iy, iy + 1):
            line = model[y] if 0 <= y < SIDE else np.zeros(SIDE)
            assert row(lib.grid_occupied_row, grid, y) == [int(v >= 8) for v in line]
            assert row(lib.grid_known_row, grid, y) == [int(v > 0) for v in line]


def test_rows_equal_cells_for_every_value_in_every_place() -> None:
    grid = new_grid()
    for ix in range(SIDE):
        for iy in range(16):
            lib.grid_set_value(grid, ix, iy, (ix + iy) % 16)
    for iy in range(16):
        states = [lib.grid_state(grid, ix, iy) for ix in range(SIDE)]
        occupied = [int(s == lib.GRID_CELL_OCCUPIED) for s in states]
        known = [int(s != lib.GRID_CELL_UNKNOWN) for s in states]
        assert row(lib.grid_occupied_row, grid, iy) == occupied
        assert row(lib.grid_known_row, grid, iy) == known


@pytest.mark.parametrize(("ix", "iy"), [(-1, 0), (0, -1), (SIDE, 0), (0, SIDE), (9999, -9999)])
def test_outside_is_unknown_and_cannot_be_written(ix: int, iy: int) -> None:
    grid = new_grid()
    before = raw_bytes(grid)
    lib.grid_set_value(grid, ix, iy, 15)
    assert raw_bytes(grid) == before
    assert lib.grid_value(grid, ix, iy) == lib.GRID_UNKNOWN
    assert lib.grid_point_eighths(grid, ix, iy) == -1


@pytest.mark.parametrize("value", [-1, 16, 1000])
def test_an_impossible_value_is_not_taken(value: int) -> None:
    grid = new_grid()
    lib.grid_set_value(grid, 5, 5, value)
    assert lib.grid_value(grid, 5, 5) == lib.GRID_UNKNOWN


def test_only_rows_whose_obstacles_changed_are_marked() -> None:
    grid = new_grid()
    lib.grid_set_value(grid, 3, 10, 5)
    assert changed_rows(grid) == set()
    lib.grid_set_value(grid, 3, 10, 9)
    lib.grid_set_value(grid, 90, 100, 15)
    assert changed_rows(grid) == {10, 100}
    ffi.memmove(grid.changed_rows, bytes(16), 16)
    lib.grid_set_value(grid, 3, 10, 12)
    assert changed_rows(grid) == set()
    lib.grid_set_value(grid, 3, 10, 2)
    assert changed_rows(grid) == {10}


@given(positions, positions, positions, positions, st.floats(0.0, 0.3), st.data())
def test_a_corridor_is_known_only_where_all_of_it_was_seen(
    ax: float, ay: float, bx: float, by: float, half_m: float, data: st.DataObject
) -> None:
    grid = new_grid()
    fill(grid, 3)
    a, b = vec2(ax, ay), vec2(bx, by)
    assert lib.grid_segment_known(grid, a, b, half_m)
    along = data.draw(st.floats(0.0, 1.0))
    aside_m = data.draw(st.floats(-half_m, half_m))
    size_m = math.hypot(bx - ax, by - ay)
    across = (-(by - ay) / size_m, (bx - ax) / size_m) if size_m > 1e-3 else (0.0, 1.0)
    spot = (
        ax + along * (bx - ax) + aside_m * across[0],
        ay + along * (by - ay) + aside_m * across[1],
    )
    cell = located(grid, *spot)
    if cell:
        middle = lib.grid_centre_m(grid, ffi.new("grid_cell_t *", cell)[0])
        lib.grid_set_value(grid, *cell, lib.GRID_UNKNOWN)
        along_m = ((middle.x - ax) * (bx - ax) + (middle.y - ay) * (by - ay)) / max(size_m, 1e-6)
        aside = abs((middle.x - ax) * across[0] + (middle.y - ay) * across[1])
        if 0.0 <= along_m <= size_m and aside <= half_m:
            assert not lib.grid_segment_known(grid, a, b, half_m)


def test_outside_the_grid_nothing_is_known() -> None:
    grid = new_grid()
    fill(grid, 3)
    inside, outside = vec2(0.0, 0.0), vec2(HALF_M + 0.1, 0.0)
    assert not lib.grid_segment_known(grid, inside, outside, 0.0)
    assert not lib.grid_segment_known(grid, vec2(math.nan, 0.0), inside, 0.1)
    assert not lib.grid_segment_known(grid, inside, vec2(0.0, math.inf), 0.1)


@pytest.mark.parametrize("half_m", [math.nan, -1.0, -math.inf])
def test_a_width_that_is_none_is_a_line(half_m: float) -> None:
    grid = new_grid()
    for ix in range(60, 71):
        lib.grid_set_value(grid, ix, 64, 3)
    assert lib.grid_segment_known(grid, vec2(-0.1, 0.025), vec2(0.3, 0.025), half_m)


@given(st.lists(st.tuples(cells, cells, st.integers(0, 15)), max_size=60), st.integers(0, 15))
def test_doubt_takes_exactly_the_occupied_cells_of_little_evidence(
    put: list[tuple[int, int, int]], value_max: int
) -> None:
    grid = new_grid()
    for ix, iy, value in put:
        lib.grid_set_value(grid, ix, iy, value)
    before = values(grid)
    lib.grid_doubt(grid, value_max)
    weak = (before >= lib.GRID_OCCUPIED_MIN) & (before <= value_max)
    assert np.array_equal(values(grid), np.where(weak, lib.GRID_UNKNOWN, before))
    assert grid.known == np.count_nonzero(values(grid))
