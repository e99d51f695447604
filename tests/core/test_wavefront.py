# SPDX-License-Identifier: GPL-3.0-or-later
"""The wave: reaches what a plain breadth-first search reaches, and finds a way that is clear."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core import oracles
from tests.core.maps import (
    SIDE,
    blocked_bits,
    fill,
    from_picture,
    is_clear,
    new_clearance,
    new_grid,
    occupy,
    points,
    raw_bytes,
    vec2,
    with_walls,
)

# Obstacles dense enough to make closed rooms, in a corner of the grid that a fence cuts off.
BOX = 20
CELL_M = 0.05
inside = st.tuples(st.integers(0, BOX - 1), st.integers(0, BOX - 1))
mazes = st.sets(inside, min_size=60, max_size=200)


def box(where: set[tuple[int, int]]) -> tuple[CData, CData]:
    """Grid and clearance of a room of BOX x BOX cells around the grid's middle word border."""
    grid = new_grid(CELL_M)
    occupy(grid, shifted(where))
    low, high = grid.origin_m.x + 54 * CELL_M, grid.origin_m.x + (54 + BOX) * CELL_M
    return grid, new_clearance(grid, 0.0, (low, low), (high, high))


def shifted(where: set[tuple[int, int]]) -> set[tuple[int, int]]:
    return {(x + 54, y + 54) for x, y in where}


def start_wave(target: int, start: tuple[int, int], goal: tuple[int, int] = (0, 0)) -> CData:
    wave = ffi.new("wavefront_t *")
    lib.wavefront_start(
        wave, target, ffi.new("grid_cell_t *", start)[0], ffi.new("grid_cell_t *", goal)[0]
    )
    return wave


def run(wave: CData, clearance: CData, grid: CData, slice_waves: int = 1000) -> int:
    for _ in range(SIDE * SIDE):
        status = lib.wavefront_extend(wave, clearance, grid, slice_waves)
        if status != lib.WAVEFRONT_RUNNING:
            return int(status)
    raise AssertionError("the wave does not end")


def reached(wave: CData) -> set[tuple[int, int]]:
    return {(x, y) for x in range(SIDE) for y in range(SIDE) if lib.wavefront_reached(wave, x, y)}


def path_of(wave: CData, clearance: CData, capacity: int = 400) -> list[tuple[float, float]]:
    array = ffi.new("vec2_t[]", capacity)
    return points(array, lib.wavefront_path(wave, clearance, array, capacity))


@given(mazes, inside)
def test_the_wave_reaches_what_can_be_reached(
    where: set[tuple[int, int]], start: tuple[int, int]
) -> None:
    grid, clearance = box(where - {start})
    (cell,) = shifted({start})
    wave = start_wave(lib.WAVEFRONT_EVERYWHERE, cell)
    assert run(wave, clearance, grid) == lib.WAVEFRONT_EXHAUSTED
    assert reached(wave) == set(oracles.distances(blocked_bits(clearance), cell))


@given(mazes, inside, inside)
def test_a_goal_is_met_exactly_if_there_is_a_way_and_the_way_is_clear(
    where: set[tuple[int, int]], start: tuple[int, int], goal: tuple[int, int]
) -> None:
    grid, clearance = box(where - {start})
    (a,), (b,) = shifted({start}), shifted({goal})
    wave = start_wave(lib.WAVEFRONT_TO_GOAL, a, b)
    status = run(wave, clearance, grid)
    steps = oracles.distances(blocked_bits(clearance), a)
    assert (status == lib.WAVEFRONT_REACHED) == (b in steps)
    path = path_of(wave, clearance)
    if b not in steps:
        assert path == []
        return
    assert wave.waves == steps[b]
    assert path[0] == (a[0] + 0.5, a[1] + 0.5)
    assert path[-1] == (b[0] + 0.5, b[1] + 0.5)
    assert is_clear(clearance, path)
    assert len(path) <= steps[b] + 2


@given(mazes, inside, inside, st.integers(1, 9))
def test_slicing_does_not_change_the_result(
    where: set[tuple[int, int]], start: tuple[int, int], goal: tuple[int, int], waves: int
) -> None:
    grid, clearance = box(where - {start})
    (a,), (b,) = shifted({start}), shifted({goal})
    whole, sliced = (start_wave(lib.WAVEFRONT_TO_GOAL, a, b) for _ in range(2))
    assert run(whole, clearance, grid) == run(sliced, clearance, grid, waves)
    assert raw_bytes(whole) == raw_bytes(sliced)


def test_the_wave_fills_the_whole_grid_to_its_edges() -> None:
    grid, clearance = with_walls([])
    wave = start_wave(lib.WAVEFRONT_EVERYWHERE, (0, 0))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_EXHAUSTED
    assert len(reached(wave)) == SIDE * SIDE


def test_a_slice_does_no_more_than_it_may() -> None:
    grid, clearance = with_walls([])
    wave = start_wave(lib.WAVEFRONT_EVERYWHERE, (64, 64))
    for waves in (0, 1, 5):
        before = wave.waves
        assert lib.wavefront_extend(wave, clearance, grid, waves) == lib.WAVEFRONT_RUNNING
        assert wave.waves == before + waves


def test_the_way_through_a_gap_of_one_cell_is_found() -> None:
    wall = {(64, y) for y in range(SIDE)} - {(64, 90)}
    grid, clearance = with_walls(wall)
    wave = start_wave(lib.WAVEFRONT_TO_GOAL, (10, 10), (120, 10))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_REACHED
    path = path_of(wave, clearance)
    assert is_clear(clearance, path)


def test_no_way_leads_between_cells_that_touch_at_a_corner() -> None:
    grid, clearance = with_walls({(x, SIDE - 1 - x) for x in range(SIDE)})
    wave = start_wave(lib.WAVEFRONT_TO_GOAL, (10, 10), (120, 120))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_EXHAUSTED


def test_the_start_may_be_the_goal() -> None:
    grid, clearance = with_walls([])
    wave = start_wave(lib.WAVEFRONT_TO_GOAL, (7, 8), (7, 8))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_REACHED
    assert path_of(wave, clearance) == [(7.5, 8.5), (7.5, 8.5)]


def test_a_way_with_more_corners_than_there_is_room_for_is_not_given() -> None:
    wall = {(x, y) for x in range(8, 120, 4) for y in range(SIDE)}
    wall -= {(x, 0 if x % 8 else SIDE - 1) for x in range(8, 120, 4)}
    grid, clearance = with_walls(wall)
    wave = start_wave(lib.WAVEFRONT_TO_GOAL, (4, 64), (122, 64))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_REACHED
    full = path_of(wave, clearance)
    assert is_clear(clearance, full)
    assert len(full) > 28
    assert path_of(wave, clearance, len(full)) == full
    assert path_of(wave, clearance, len(full) - 1) == []
    assert path_of(wave, clearance, 1) == []


@given(st.sets(inside, max_size=120), st.sets(inside, max_size=120), inside)
def test_a_frontier_is_a_seen_cell_beside_an_unseen_one_reached_through_seen_cells(
    where: set[tuple[int, int]], unseen: set[tuple[int, int]], start: tuple[int, int]
) -> None:
    grid, clearance = box(where - {start})
    (cell,) = shifted({start})
    blocked = blocked_bits(clearance)
    fill(grid, 0)
    known = np.ones((SIDE, SIDE), dtype=bool)
    for x, y in shifted(unseen - where - {start}):
        known[y, x] = False
    for y, x in np.argwhere(known):
        lib.grid_set_value(grid, int(x), int(y), 3)
    wave = start_wave(lib.WAVEFRONT_TO_FRONTIER, cell)
    status = run(wave, clearance, grid)
    steps = oracles.distances(blocked | ~known, cell)
    frontier = {
        (x, y)
        for x, y in steps
        if not all(known[b, a] for a, b in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)))
    } - {cell}
    assert (status == lib.WAVEFRONT_REACHED) == bool(frontier)
    if frontier:
        assert (wave.goal.ix, wave.goal.iy) in frontier
        assert wave.waves == min(steps[c] for c in frontier)
        assert is_clear(clearance, path_of(wave, clearance))


def test_where_all_is_seen_there_is_no_frontier() -> None:
    grid, clearance = with_walls([])
    fill(grid, 3)
    wave = start_wave(lib.WAVEFRONT_TO_FRONTIER, (64, 64))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_EXHAUSTED


@pytest.mark.parametrize("point", [(64.0, 64.0), (100.2, 3.3), (-50.0, 500.0)])
def test_the_nearest_reached_cell_is_the_nearest(point: tuple[float, float]) -> None:
    room = from_picture(["######", "#....#", "#....#", "#....#", "######"], 20, 30)
    grid, clearance = with_walls(room)
    wave = start_wave(lib.WAVEFRONT_EVERYWHERE, (22, 32))
    run(wave, clearance, grid)
    found = ffi.new("grid_cell_t *")
    assert lib.wavefront_nearest(wave, vec2(*point), found)
    distance = np.hypot(found.ix + 0.5 - point[0], found.iy + 0.5 - point[1])
    best = min(np.hypot(x + 0.5 - point[0], y + 0.5 - point[1]) for x, y in reached(wave))
    assert distance == pytest.approx(best, rel=1e-5)
