# SPDX-License-Identifier: GPL-3.0-or-later
"""The occupancy grid: where cells lie, what beams do to them, what the queries say."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import SIDE, fill, new_grid, raw_bytes, values, vec2, xy

CELL_M = 0.05
HALF_M = SIDE * CELL_M / 2
cells = st.integers(0, SIDE - 1)
positions = st.floats(-2.5, 2.5, width=32)
yaws = st.floats(-3.125, 3.125, width=32)
ranges = st.floats(0.0, 4.0, width=32)


def pose(x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0) -> CData:
    return ffi.new("pose2_t *", (x_m, y_m, yaw_rad))[0]


def frame(hits_m: dict[int, float], clear_m: dict[int, float] | None = None) -> CData:
    """A measured set: beam to range."""
    clear_m = clear_m or {}
    made = ffi.new("scan_frame_t *")
    for beam, range_m in {**hits_m, **clear_m}.items():
        made.range_m[beam] = range_m
    made.hit = sum(1 << beam for beam in hits_m)
    made.clear = sum(1 << beam for beam in clear_m)
    return made


def located(grid: CData, x_m: float, y_m: float) -> tuple[int, int] | None:
    cell = ffi.new("grid_cell_t *", (-7, -7))
    if lib.grid_locate(grid, vec2(x_m, y_m), cell):
        return cell.ix, cell.iy
    assert (cell.ix, cell.iy) == (-7, -7)
    return None


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


def test_a_beam_marks_its_end_and_clears_its_way() -> None:
    grid = new_grid()
    changed = lib.grid_insert(grid, frame({lib.SCAN_FRONT: 1.0}), pose(0.025, 0.025))
    assert lib.grid_state(grid, 84, 64) == lib.GRID_CELL_OCCUPIED
    assert all(lib.grid_state(grid, ix, 64) == lib.GRID_CELL_FREE for ix in range(64, 84))
    assert lib.grid_state(grid, 85, 64) == lib.GRID_CELL_UNKNOWN
    assert changed == grid.known == np.count_nonzero(values(grid))


@pytest.mark.parametrize(
    ("beam", "yaw_rad", "end"),
    [
        ("SCAN_FRONT", 0.0, (84, 64)),
        ("SCAN_BACK", 0.0, (44, 64)),
        ("SCAN_LEFT", 0.0, (64, 84)),
        ("SCAN_RIGHT", 0.0, (64, 44)),
        ("SCAN_FRONT", math.pi / 2, (64, 84)),
        ("SCAN_LEFT", math.pi, (64, 44)),
    ],
)
def test_beams_end_where_they_point(beam: str, yaw_rad: float, end: tuple[int, int]) -> None:
    grid = new_grid()
    lib.grid_insert(grid, frame({getattr(lib, beam): 1.0}), pose(0.025, 0.025, yaw_rad))
    occupied = {(ix, iy) for iy, ix in np.argwhere(values(grid) >= 8)}
    assert occupied == {end}


def test_a_beam_without_echo_only_clears() -> None:
    grid = new_grid()
    lib.grid_insert(grid, frame({}, {lib.SCAN_FRONT: 1.0}), pose())
    assert values(grid).max() < lib.GRID_OCCUPIED_MIN
    assert lib.grid_state(grid, 80, 64) == lib.GRID_CELL_FREE


@given(positions, positions, yaws, st.lists(ranges, min_size=4, max_size=4))
def test_free_space_is_never_drawn_past_the_echo(
    x_m: float, y_m: float, yaw_rad: float, ranges_m: list[float]
) -> None:
    grid = new_grid()
    hits = dict(enumerate(ranges_m))
    lib.grid_insert(grid, frame(hits), pose(x_m, y_m, yaw_rad))
    slack_m = CELL_M * math.sqrt(2)
    for iy, ix in np.argwhere(values(grid) > 0):
        dx = grid.origin_m.x + (ix + 0.5) * CELL_M - x_m
        dy = grid.origin_m.y + (iy + 0.5) * CELL_M - y_m
        reached = False
        for beam, range_m in hits.items():
            bearing = yaw_rad + lib.scan_bearing_rad(beam)
            along = dx * math.cos(bearing) + dy * math.sin(bearing)
            across = abs(dy * math.cos(bearing) - dx * math.sin(bearing))
            wide_m = max(along, 0.0) * math.tan(grid.cfg.fan_half_rad) + slack_m
            reached |= -slack_m <= along <= range_m + slack_m and across <= wide_m
        assert reached


@given(positions, positions, yaws, st.lists(ranges, min_size=4, max_size=4))
def test_an_end_in_the_grid_is_occupied_and_has_a_point(
    x_m: float, y_m: float, yaw_rad: float, ranges_m: list[float]
) -> None:
    grid = new_grid()
    lib.grid_insert(grid, frame(dict(enumerate(ranges_m))), pose(x_m, y_m, yaw_rad))
    for beam, range_m in enumerate(ranges_m):
        bearing = yaw_rad + lib.scan_bearing_rad(beam)
        end = (x_m + range_m * math.cos(bearing), y_m + range_m * math.sin(bearing))
        found = located(grid, *end)
        inner = max(abs(end[0]), abs(end[1])) < HALF_M - CELL_M
        assert found is not None or not inner
        if found is None:
            continue
        near = [(found[0] + dx, found[1] + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        hit = [c for c in near if lib.grid_state(grid, *c) == lib.GRID_CELL_OCCUPIED]
        assert hit
        assert any(lib.grid_point_eighths(grid, *c) >= 0 for c in hit)


@given(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0), yaws, st.floats(0.0, 40.0))
def test_beams_are_clipped_at_the_border(
    x_m: float, y_m: float, yaw_rad: float, range_m: float
) -> None:
    grid = new_grid()
    every = {beam: range_m for beam in range(lib.SCAN_BEAMS)}
    changed = lib.grid_insert(grid, frame(every), pose(x_m, y_m, yaw_rad))
    assert changed >= grid.known == np.count_nonzero(values(grid))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e20])
def test_a_pose_that_is_nowhere_changes_nothing(bad: float) -> None:
    grid = new_grid()
    before = raw_bytes(grid)
    assert lib.grid_insert(grid, frame({0: 1.0, 1: 1.0}), pose(bad, 0.0)) == 0
    assert lib.grid_insert(grid, frame({0: 1.0, 1: 1.0}), pose(0.0, bad)) == 0
    assert raw_bytes(grid) == before


def test_evidence_is_clamped_at_both_ends() -> None:
    grid = new_grid()
    for _ in range(100):
        lib.grid_insert(grid, frame({lib.SCAN_FRONT: 1.0}), pose(0.025, 0.025))
    assert lib.grid_value(grid, 84, 64) == lib.GRID_VALUE_MAX
    assert lib.grid_value(grid, 70, 64) == 1


def test_newer_beats_older() -> None:
    grid = new_grid()
    for _ in range(20):
        lib.grid_insert(grid, frame({lib.SCAN_FRONT: 1.0}), pose(0.025, 0.025))
    passes = 0
    while lib.grid_state(grid, 84, 64) == lib.GRID_CELL_OCCUPIED:
        lib.grid_insert(grid, frame({lib.SCAN_FRONT: 2.0}), pose(0.025, 0.025))
        passes += 1
        assert passes <= 8
    assert passes > 1
    assert lib.grid_point_eighths(grid, 84, 64) == -1


@pytest.mark.parametrize("degree", range(0, 360, 7))
def test_the_ends_of_one_set_are_not_cleared_by_its_other_beams(degree: int) -> None:
    grid = new_grid()
    corner = frame({lib.SCAN_FRONT: 0.3, lib.SCAN_LEFT: 0.04, lib.SCAN_RIGHT: 2.0})
    lib.grid_insert(grid, corner, pose(0.013, 0.007, math.radians(degree)))
    for beam, range_m in ((lib.SCAN_FRONT, 0.3), (lib.SCAN_LEFT, 0.04), (lib.SCAN_RIGHT, 2.0)):
        bearing = math.radians(degree) + lib.scan_bearing_rad(beam)
        end = located(
            grid, 0.013 + range_m * math.cos(bearing), 0.007 + range_m * math.sin(bearing)
        )
        assert end is not None
        assert lib.grid_value(grid, *end) >= lib.GRID_OCCUPIED_MIN - 1 + grid.cfg.hit


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
