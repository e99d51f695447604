# SPDX-License-Identifier: GPL-3.0-or-later
"""How beams change the occupancy grid."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import lib
from tests.core.maps import SIDE, frame, located, new_grid, pose, raw_bytes, values

CELL_M = 0.05
HALF_M = SIDE * CELL_M / 2
positions = st.floats(-2.5, 2.5, width=32)
yaws = st.floats(-3.125, 3.125, width=32)
ranges = st.floats(0.0, 4.0, width=32)


def test_a_beam_marks_its_end_and_clears_its_way() -> None:
    grid = new_grid()
    changed = lib.grid_insert(grid, frame({lib.SCAN_FRONT: 1.0}), pose(0.025, 0.025))
    assert lib.grid_state(grid, 84, 64) == lib.GRID_CELL_OCCUPIED
    assert all(lib.grid_state(grid, ix, 64) == lib.GRID_CELL_FREE for ix in range(64, 84))
    assert lib.grid_state(grid, 85, 64) == lib.GRID_CELL_UNKNOWN
    assert changed == grid.known == np.count_nonzero(values(grid))


@pytest.mark.parametrize("range_m", [math.nan, math.inf, -0.1, 3e5, 1e38])
def test_a_range_that_no_sensor_measures_draws_nothing(range_m: float) -> None:
    grid = new_grid()
    assert lib.grid_insert(grid, frame({0: range_m}, {1: range_m}), pose()) == 0
    assert grid.known == 0


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
