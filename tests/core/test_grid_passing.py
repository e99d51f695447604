# SPDX-License-Identifier: GPL-3.0-or-later
"""Obstacles that pass through known free space are forgotten; static ones are kept."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import SIDE, frame, new_grid, pose, values, vec2

SET_MS = 100
ROUND_MS = lib.GRID_FADE_MS * lib.GRID_POINT_SETS
WALL_M, BODY_M = 2.0, 1.0
"""Where the beam ends, without and with somebody in it."""


class Looking:
    """A grid that is updated ten times a second from one place, and fades in between."""

    def __init__(self) -> None:
        self.grid: CData = new_grid()
        self.time_ms = 0

    def look(self, range_m: float, seconds: float, yaw_rad: float = 0.0) -> None:
        for _ in range(round(1000 * seconds / SET_MS)):
            here = pose(0.025, 0.025, yaw_rad)
            lib.grid_insert(self.grid, frame({lib.SCAN_FRONT: range_m}), here)
            self.wait(SET_MS / 1000)

    def wait(self, seconds: float) -> None:
        """Let time pass without measurements."""
        end_ms = self.time_ms + round(1000 * seconds)
        while self.time_ms < end_ms:
            self.time_ms += 20
            before = bytes(ffi.buffer(self.grid.cells))
            faded = lib.grid_fade(self.grid, self.time_ms)
            assert faded == (bytes(ffi.buffer(self.grid.cells)) != before)

    def occupied(self) -> set[tuple[int, int]]:
        return {(int(ix), int(iy)) for iy, ix in np.argwhere(values(self.grid) >= 8)}


WALL, BODY = (64 + round(WALL_M / 0.05), 64), (64 + round(BODY_M / 0.05), 64)


def test_who_stands_in_the_way_is_avoided_and_forgotten_where_nobody_looks() -> None:
    room = Looking()
    room.look(WALL_M, 2.0)
    room.look(BODY_M, 3.0)
    assert room.occupied() == {WALL, BODY}
    assert lib.grid_lasting_eighths(room.grid, *BODY) < 0
    room.wait(2 * ROUND_MS / 1000 + 0.1)
    assert room.occupied() == {WALL}
    assert lib.grid_state(room.grid, *BODY) == lib.GRID_CELL_FREE


def test_who_is_still_looked_at_does_not_fade() -> None:
    room = Looking()
    room.look(WALL_M, 2.0)
    for _ in range(60):
        room.look(BODY_M, 1.0)
        assert BODY in room.occupied()


def test_what_stays_for_three_rounds_is_kept() -> None:
    room = Looking()
    room.look(WALL_M, 2.0)
    room.look(BODY_M, 3 * ROUND_MS / 1000)
    assert lib.grid_lasting_eighths(room.grid, *BODY) >= 0
    room.wait(120.0)
    assert room.occupied() == {WALL, BODY}


def test_a_door_that_closed_for_a_while_is_open_again_when_it_is_looked_at() -> None:
    room = Looking()
    room.look(WALL_M, 2.0)
    room.look(BODY_M, 30.0)
    room.look(WALL_M, 2.0)
    assert room.occupied() == {WALL}


@given(st.lists(st.tuples(st.floats(0.3, 3.0), st.floats(-3.1, 3.1)), min_size=1, max_size=30))
def test_what_was_never_seen_free_never_fades(walls: list[tuple[float, float]]) -> None:
    room = Looking()
    cells = [
        (
            64 + math.floor(0.5 + r * math.cos(yaw) / 0.05),
            64 + math.floor(0.5 + r * math.sin(yaw) / 0.05),
        )
        for r, yaw in walls
    ]
    for ix, iy in cells:
        at = ffi.new("grid_cell_t *", (ix, iy))[0]
        lib.grid_set_value(room.grid, ix, iy, 10)
        lib.grid_points_add(room.grid, at, lib.grid_centre_m(room.grid, at), False)
    before = room.occupied()
    room.wait(60.0)
    assert room.occupied() == before


def test_a_wall_that_noise_has_cleared_is_a_wall_again_at_once() -> None:
    room = Looking()
    for offset in range(-6, 7):
        cell = ffi.new("grid_cell_t *", (WALL[0], WALL[1] + offset))[0]
        for _ in range(4):
            lib.grid_set_value(room.grid, cell.ix, cell.iy, 12)
            lib.grid_points_add(room.grid, cell, lib.grid_centre_m(room.grid, cell), False)
    lib.grid_set_value(room.grid, *WALL, 4)
    room.look(WALL_M, 1.0)
    assert WALL in room.occupied()
    assert lib.grid_lasting_eighths(room.grid, *WALL) >= 0


def test_in_a_crowd_the_passing_make_room_and_their_cells_are_free() -> None:
    grid = new_grid()
    for iy in range(SIDE):
        for ix in range(0, SIDE, 3):
            cell = ffi.new("grid_cell_t *", (ix, iy))[0]
            lib.grid_set_value(grid, ix, iy, 9)
            lib.grid_points_add(grid, cell, lib.grid_centre_m(grid, cell), True)
    occupied = int(np.count_nonzero(values(grid) >= 8))
    assert occupied == sum(p != 0 for p in grid.points) <= lib.GRID_POINTS


def test_an_echo_is_judged_by_what_is_known_around_it() -> None:
    room = Looking()
    end = vec2(BODY_M, 0.025)
    assert lib.grid_classify_echo(room.grid, end, 5) == lib.GRID_ECHO_UNEXPLAINED
    for iy in range(40, 90):
        for ix in range(40, 120):
            lib.grid_set_value(room.grid, ix, iy, 1)
    assert lib.grid_classify_echo(room.grid, end, 5) == lib.GRID_ECHO_STRANGE
    room.look(BODY_M, 3.0)
    assert lib.grid_classify_echo(room.grid, end, 5) == lib.GRID_ECHO_STRANGE
    room.look(BODY_M, 30.0)
    assert lib.grid_classify_echo(room.grid, end, 5) == lib.GRID_ECHO_FAMILIAR


def test_beams_that_sweep_clear_who_has_gone_but_no_wall() -> None:
    grid = new_grid()
    for iy, hits in [*((iy, 4) for iy in range(34, 50)), (64, 1)]:  # a wall, somebody alone
        cell = ffi.new("grid_cell_t *", (BODY[0], iy))[0]
        for _ in range(hits):
            lib.grid_points_add(grid, cell, lib.grid_centre_m(grid, cell), False)
        lib.grid_set_value(grid, cell.ix, cell.iy, 10)
    before = values(grid).copy()
    for sweeping in (False, True):
        grid.sweeping = sweeping
        for step in range(200):
            here = pose(0.025, 0.025, 0.75 * math.sin(0.1 * step))
            lib.grid_insert(grid, frame({}, {lib.SCAN_FRONT: 0.5}), here)
        gone = (before >= 8) & (values(grid) < 8)
        assert np.argwhere(gone).tolist() == [[64, BODY[0]]] * sweeping
