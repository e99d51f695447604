# SPDX-License-Identifier: GPL-3.0-or-later
"""One obstacle point per occupied cell: refined by repeated hits, gone with its cell."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import OCCUPIED, SIDE, new_grid, vec2

CELL_M = 0.05
cells = st.tuples(st.integers(0, SIDE - 1), st.integers(0, SIDE - 1))
shares = st.floats(0.0, 1.0, exclude_max=True)


def place(grid: CData, cell: tuple[int, int], x: float, y: float) -> CData:
    """The place at this fraction of the cell."""
    return lib.grid_to_metres(grid, vec2(cell[0] + x, cell[1] + y))


def hit(grid: CData, cell: tuple[int, int], x: float, y: float) -> None:
    lib.grid_set_value(grid, *cell, OCCUPIED)
    lib.grid_points_add(grid, ffi.new("grid_cell_t *", cell)[0], place(grid, cell, x, y), False)


def point(grid: CData, cell: tuple[int, int]) -> tuple[float, float] | None:
    """The fraction of the cell at which its point lies."""
    found = ffi.new("vec2_t *")
    if not lib.grid_point(grid, *cell, found):
        return None
    in_cells = lib.grid_to_cells(grid, found[0])
    return in_cells.x - cell[0], in_cells.y - cell[1]


@given(cells, shares, shares)
def test_a_first_hit_is_kept_to_an_eighth_of_a_cell(
    cell: tuple[int, int], x: float, y: float
) -> None:
    grid = new_grid()
    hit(grid, cell, x, y)
    assert point(grid, cell) == pytest.approx((x, y), abs=1 / 16 + 1e-3)
    eighths = lib.grid_point_eighths(grid, *cell)
    assert point(grid, cell) == pytest.approx(
        ((eighths & 7) / 8 + 1 / 16, (eighths >> 3) / 8 + 1 / 16), abs=1e-3
    )


@given(cells, st.lists(st.tuples(shares, shares), min_size=1, max_size=30))
def test_hits_refine_one_point_between_them(
    cell: tuple[int, int], hits: list[tuple[float, float]]
) -> None:
    grid = new_grid()
    for x, y in hits:
        hit(grid, cell, x, y)
    found = point(grid, cell)
    assert found is not None
    for axis in (0, 1):
        low, high = min(h[axis] for h in hits), max(h[axis] for h in hits)
        assert low - 1 / 8 - 1e-3 <= found[axis] <= high + 1 / 8 + 1e-3
    assert sum(p != 0 for p in grid.points) == 1


def test_a_point_follows_an_obstacle_that_moved_within_its_cell() -> None:
    grid = new_grid()
    for x in [0.1] * 10 + [0.9] * 15:
        hit(grid, (40, 40), x, 0.5)
    found = point(grid, (40, 40))
    assert found is not None
    assert found[0] > 0.6


@given(st.lists(cells, unique=True, min_size=1, max_size=40), st.data())
def test_a_point_lives_only_as_long_as_its_cell_is_believed(
    where: list[tuple[int, int]], data: st.DataObject
) -> None:
    grid = new_grid()
    for cell in where:
        hit(grid, cell, 0.3, 0.7)
    gone = data.draw(st.sets(st.sampled_from(where)))
    had = {cell for cell in where if point(grid, cell)}
    for cell in gone:
        lib.grid_set_value(grid, *cell, 4)
    assert {cell for cell in where if point(grid, cell)} == had - gone
    for cell in gone:
        lib.grid_set_value(grid, *cell, OCCUPIED)
        assert point(grid, cell) is None


def test_a_removed_point_is_gone_and_its_cell_stays() -> None:
    grid = new_grid()
    hit(grid, (3, 4), 0.5, 0.5)
    cell = ffi.new("grid_cell_t *", (3, 4))[0]
    lib.grid_points_remove(grid, cell)
    lib.grid_points_remove(grid, cell)
    assert point(grid, (3, 4)) is None
    assert lib.grid_state(grid, 3, 4) == lib.GRID_CELL_OCCUPIED


def test_no_point_is_ever_read_for_another_cell() -> None:
    grid = new_grid()
    hit(grid, (17, 99), 0.5, 0.5)
    for iy in range(SIDE):
        for ix in range(SIDE):
            lib.grid_set_value(grid, ix, iy, OCCUPIED)
    having = [c for c in ((x, y) for y in range(SIDE) for x in range(SIDE)) if point(grid, c)]
    assert having == [(17, 99)]


def test_the_walls_of_a_home_keep_nearly_all_their_points() -> None:
    grid = new_grid()
    walls = {(i, row) for i in range(4, 124) for row in (4, 64, 123)}
    walls |= {(column, i) for i in range(4, 124) for column in (4, 64, 123)}
    for cell in walls:
        hit(grid, cell, 0.5, 0.5)
    kept = sum(point(grid, cell) is not None for cell in walls)
    assert kept > 0.95 * len(walls)
    assert all(lib.grid_state(grid, *cell) == lib.GRID_CELL_OCCUPIED for cell in walls)


def test_when_the_table_is_full_a_confirmed_point_outlives_fresh_ones() -> None:
    grid = new_grid()
    for _ in range(6):
        hit(grid, (64, 64), 0.5, 0.5)
    for iy in range(0, SIDE, 2):
        for ix in range(1, SIDE, 2):
            hit(grid, (ix, iy), 0.5, 0.5)
    assert point(grid, (64, 64)) is not None
