# SPDX-License-Identifier: GPL-3.0-or-later
"""Routes: moved off corners, rounded without getting longer; every piece is clear."""

import itertools
import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import (
    OCCUPIED,
    PER_CELL,
    fill,
    in_cells,
    is_clear,
    length,
    new_grid,
    path_array,
    points,
    sees,
    vec2,
    with_walls,
)

Path = list[tuple[float, float]]
CAPACITY: int = lib.ROUTE_POINTS
PAST = lib.CLEARANCE_CORNER_STEPS / PER_CELL
TINY_CELLS = 4 / PER_CELL  # points are rounded to the lattice
places = st.integers(30 * PER_CELL, 61 * PER_CELL)
ways = st.lists(st.tuples(places, places), min_size=2, max_size=8).map(in_cells)
walls = st.sets(st.tuples(st.integers(30, 60), st.integers(30, 60)), max_size=25)


def stood_off(clearance: CData, path: Path) -> Path:
    array = path_array(path)
    lib.route_stand_off(clearance, array, len(path))
    return points(array, len(path))


def in_sight(clearance: CData, path: Path) -> bool:
    return sees(clearance, [(int(x * PER_CELL), int(y * PER_CELL)) for x, y in path])


def rounded(clearance: CData, path: Path, capacity: int = CAPACITY) -> Path:
    array = path_array(path)
    return points(array, lib.route_round(clearance, array, len(path), capacity))


def route_of(path_m: Path) -> CData:
    route = ffi.new("route_t *", {"count": len(path_m)})
    for i, (x, y) in enumerate(path_m):
        route.points_m[i].x, route.points_m[i].y = x, y
    return route


def turn(path: Path) -> float:
    """The sharpest turn of a path [rad]."""
    legs = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in itertools.pairwise(path)]
    return max(abs(math.remainder(b - a, math.tau)) for a, b in itertools.pairwise(legs))


def gap_cells(where: set[tuple[int, int]], at: tuple[float, float]) -> float:
    """Distance from a place to the nearest occupied cell."""
    return min(
        (
            math.hypot(max(x - at[0], 0.0, at[0] - x - 1), max(y - at[1], 0.0, at[1] - y - 1))
            for x, y in where
        ),
        default=math.inf,
    )


@given(walls, ways)
def test_standing_off_keeps_the_ends_and_stays_clear(
    where: set[tuple[int, int]], path: Path
) -> None:
    _, clearance = with_walls(where)
    assume(in_sight(clearance, path))
    moved = stood_off(clearance, path)
    assert (moved[0], moved[-1]) == (path[0], path[-1])
    assert in_sight(clearance, moved)
    assert is_clear(clearance, moved)
    for before, after in zip(path, moved, strict=True):
        assert math.dist(before, after) <= lib.ROUTE_STAND_OFF_CELLS + TINY_CELLS


@given(st.integers(2, 30), st.integers(2, 9), st.floats(5.0, 40.0))
def test_a_point_at_a_corner_goes_to_the_middle_of_its_gap(
    height: int, gap: int, rise: float
) -> None:
    """Between a wall below and a wall above, it is no nearer to either than before."""
    walls = {(64, 30 + y) for y in range(height)}
    walls |= {(64, 30 + height + gap + y) for y in range(20)}
    _, clearance = with_walls(walls)
    top = 30.0 + height
    path = in_cells(
        (round(x * PER_CELL), round(y * PER_CELL))
        for x, y in (
            (50.5, top - min(rise, 20.0)),
            (64.0 - PAST, top + PAST),
            (65.0 + PAST, top + PAST),
            (80.5, top - min(rise, 20.0)),
        )
    )
    assume(in_sight(clearance, path))
    moved = stood_off(clearance, path)
    for before, after in zip(path, moved, strict=True):
        assert gap_cells(walls, after) >= gap_cells(walls, before) - TINY_CELLS
    assert max(math.dist(a, b) for a, b in zip(path, moved, strict=True)) > 0.4


def test_in_the_open_a_corner_is_passed_at_a_distance() -> None:
    walls = {(x, y) for x in range(60, 70) for y in range(20, 64)}
    _, clearance = with_walls(walls)
    path = [(40.5, 40.5), (60 - PAST, 64 + PAST), (70 + PAST, 64 + PAST), (90.5, 40.5)]
    moved = stood_off(clearance, path)
    for point in moved[1:-1]:
        assert gap_cells(walls, point) == pytest.approx(lib.ROUTE_STAND_OFF_CELLS, abs=0.1)


def test_a_straight_way_stays_where_it_is() -> None:
    _, clearance = with_walls([])
    path = [(20.5 + i, 64.5 - 0.5 * i) for i in range(10)]
    assert stood_off(clearance, path) == path


@given(walls, ways)
def test_rounding_is_clear_and_never_longer(where: set[tuple[int, int]], path: Path) -> None:
    _, clearance = with_walls(where)
    assume(in_sight(clearance, path))
    curve = rounded(clearance, path)
    assert curve[0] == path[0]
    assert curve[-1] == path[-1]
    assert is_clear(clearance, curve)
    assert length(curve) <= length(path) + TINY_CELLS * len(curve)
    assert len(curve) <= CAPACITY


def test_a_corner_in_the_open_is_rounded() -> None:
    _, clearance = with_walls([])
    path = [(20.5, 20.5), (60.5, 20.5), (60.5, 60.5)]
    curve = rounded(clearance, path)
    assert len(curve) > len(path)
    assert turn(curve) < 0.6 * turn(path)
    assert length(curve) < length(path) - 1.0


def test_rounding_takes_no_more_points_than_there_is_room_for() -> None:
    _, clearance = with_walls([])
    path = [(20.5 + 4 * i, 64.5 + 8 * (i % 2)) for i in range(20)]
    for capacity in range(20, CAPACITY + 1):
        assert len(rounded(clearance, path, capacity)) <= capacity


@given(walls, ways)
def test_a_route_is_the_way_in_metres(where: set[tuple[int, int]], path: Path) -> None:
    grid, clearance = with_walls(where)
    assume(in_sight(clearance, path))
    route = route_of(path)
    lib.route_build(route, grid, clearance, len(path))
    built = points(route.points_m, route.count)
    ends = [lib.grid_to_metres(grid, vec2(*p)) for p in (path[0], path[-1])]
    assert built[0] == pytest.approx((ends[0].x, ends[0].y), abs=1e-5)
    assert built[-1] == pytest.approx((ends[1].x, ends[1].y), abs=1e-5)
    assert lib.route_length_m(route) == pytest.approx(length(built), rel=1e-4)
    cells = [lib.grid_to_cells(grid, vec2(*p)) for p in built]
    assert is_clear(clearance, [(p.x, p.y) for p in cells])
    assert route.revision == 1


def test_an_empty_route_has_no_length() -> None:
    route = route_of([])
    grid, clearance = with_walls([])
    assert lib.route_length_m(route) == 0.0
    assert lib.route_clear_m(route, grid, clearance, 0.0) == 0.0
    assert lib.route_known_m(route, grid, 0.1, 0.0, 100.0) == 0.0


@given(st.integers(70, 100), st.floats(0.0, 0.2))
def test_a_route_is_clear_up_to_a_new_obstacle(ix: int, from_m: float) -> None:
    route = route_of([(0.0, 0.0), (1.0, 0.0), (2.5, 0.0)])
    grid, clearance = with_walls([])
    assert lib.route_clear_m(route, grid, clearance, from_m) == pytest.approx(2.5, abs=1e-4)
    _, clearance = with_walls([(ix, 64)])
    wall_m = (ix - 64) * grid.cell_m
    clear_m = lib.route_clear_m(route, grid, clearance, from_m)
    assert wall_m - 0.11 <= clear_m <= wall_m + 1e-4
    assert lib.route_clear_m(route, grid, clearance, wall_m + 0.11) == pytest.approx(2.5, abs=1e-4)


@given(st.integers(70, 100), st.floats(0.0, 0.2), st.floats(0.0, 0.2))
def test_a_route_is_known_up_to_what_nobody_has_seen(
    ix: int, half_width_m: float, from_m: float
) -> None:
    route = route_of([(0.0, 0.025), (1.0, 0.025), (2.5, 0.025)])
    grid = new_grid()
    fill(grid, 3)
    known_m = lib.route_known_m(route, grid, half_width_m, from_m, 100.0)
    assert known_m == pytest.approx(2.5, abs=1e-4)
    lib.grid_set_value(grid, ix, 64, lib.GRID_UNKNOWN)
    unseen_m = (ix - 64) * grid.cell_m
    known_m = lib.route_known_m(route, grid, half_width_m, from_m, 100.0)
    assert unseen_m - 0.11 <= known_m <= unseen_m + 1e-4
    lib.grid_set_value(grid, ix, 64, OCCUPIED)
    assert lib.route_known_m(route, grid, half_width_m, from_m, 100.0) == pytest.approx(
        2.5, abs=1e-4
    )


@given(st.integers(66, 90), st.integers(0, 4))
def test_the_room_of_a_route_is_that_to_the_nearest_blocked_cell(ix: int, off: int) -> None:
    route = route_of([(0.025, 0.025), (2.5, 0.025)])
    grid, clearance = with_walls([(ix, 64 + off)])
    free = min(max(0, off - 1), lib.ROUTE_ROOM_CELLS)
    room_m = lib.route_room_m(route, grid, clearance, 0.0, 100.0)
    assert room_m == pytest.approx(free * grid.cell_m)
    past_m = (ix - 64 + 5) * grid.cell_m
    room_m = lib.route_room_m(route, grid, clearance, past_m, 100.0)
    assert room_m == pytest.approx(lib.ROUTE_ROOM_CELLS * grid.cell_m)


@given(ways, st.floats(0.0, 50.0))
def test_looking_along_a_route_ends(path: Path, from_m: float) -> None:
    grid, clearance = with_walls([])
    route = route_of([(x / 20 - 2.0, y / 20 - 2.0) for x, y in path])
    fill(grid, 3)
    end_m = lib.route_length_m(route)
    clear_m = lib.route_clear_m(route, grid, clearance, from_m)
    known_m = lib.route_known_m(route, grid, 0.1, from_m, 100.0)
    assert clear_m == pytest.approx(max(from_m, end_m), abs=1e-3)
    assert known_m == pytest.approx(max(from_m, end_m), abs=1e-3)
