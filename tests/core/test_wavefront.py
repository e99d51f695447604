# SPDX-License-Identifier: GPL-3.0-or-later
"""The wavefront reaches what a plain breadth-first search reaches, and finds a clear path.

How far it says that a cell is, a plain oracle says too: every other wave goes to 8 neighbours.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core import oracles
from tests.core.maps import (
    SIDE,
    Cell,
    Steps,
    blocked_bits,
    fill,
    from_picture,
    in_cells,
    is_clear,
    lattice_points,
    middle,
    new_clearance,
    new_grid,
    occupy,
    raw_bytes,
    sees,
    vec2,
    with_walls,
)

# Obstacles dense enough to make closed rooms, in a corner of the grid that a fence cuts off.
BOX = 20
CELL_M = 0.05
inside = st.tuples(st.integers(0, BOX - 1), st.integers(0, BOX - 1))
mazes = st.sets(inside, min_size=60, max_size=200)


def box(where: set[Cell]) -> tuple[CData, CData]:
    """Grid and clearance of a room of BOX x BOX cells around the grid's middle word border."""
    grid = new_grid(CELL_M)
    occupy(grid, shifted(where))
    low, high = grid.origin_m.x + 54 * CELL_M, grid.origin_m.x + (54 + BOX) * CELL_M
    return grid, new_clearance(grid, 0.0, (low, low), (high, high))


def shifted(where: set[Cell]) -> set[Cell]:
    return {(x + 54, y + 54) for x, y in where}


def start_wave(target: int, start: Cell, goal: Cell = (0, 0)) -> CData:
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


def reached(wave: CData) -> set[Cell]:
    return {(x, y) for x in range(SIDE) for y in range(SIDE) if lib.wavefront_reached(wave, x, y)}


def path_of(wave: CData, clearance: CData, capacity: int = 400) -> list[Steps]:
    """The path from the target back to the root, followed independently."""
    array = ffi.new("lattice_t[]", capacity)
    wave.walked = wave.points = 0
    count = lib.wavefront_path(wave, clearance, array, capacity, SIDE * SIDE)
    return lattice_points(array, count)


@given(mazes, inside, inside, st.integers(1, 9))
def test_slicing_the_walk_does_not_change_the_way(
    where: set[Cell], start: Cell, goal: Cell, steps: int
) -> None:
    grid, clearance = box(where - {start})
    (a,), (b,) = shifted({start}), shifted({goal})
    wave = start_wave(lib.WAVEFRONT_TO_CELL, a, b)
    run(wave, clearance, grid)
    whole = path_of(wave, clearance)
    array, count = ffi.new("lattice_t[]", 400), int(lib.WAVEFRONT_WALKING)
    wave.walked = wave.points = 0
    for _ in range(SIDE * SIDE):
        count = lib.wavefront_path(wave, clearance, array, 400, steps)
        if count != lib.WAVEFRONT_WALKING:
            break
    assert lattice_points(array, count) == whole


def assert_good(path: list[Steps], clearance: CData, start: Cell, target: Cell) -> None:
    assert path[0] == middle(target)
    assert path[-1] == middle(start)
    assert sees(clearance, path)
    assert is_clear(clearance, in_cells(path))


@given(mazes, inside)
def test_the_wave_reaches_what_can_be_reached(where: set[Cell], start: Cell) -> None:
    grid, clearance = box(where - {start})
    (cell,) = shifted({start})
    wave = start_wave(lib.WAVEFRONT_EVERYWHERE, cell)
    assert run(wave, clearance, grid) == lib.WAVEFRONT_EXHAUSTED
    assert reached(wave) == set(oracles.distances(blocked_bits(clearance), cell))


@given(mazes, inside, inside)
def test_a_goal_is_met_exactly_if_there_is_a_way_and_the_way_is_clear(
    where: set[Cell], start: Cell, goal: Cell
) -> None:
    grid, clearance = box(where - {start})
    (a,), (b,) = shifted({start}), shifted({goal})
    wave = start_wave(lib.WAVEFRONT_TO_CELL, a, b)
    status = run(wave, clearance, grid)
    reachable = oracles.waves(blocked_bits(clearance), a)
    assert (status == lib.WAVEFRONT_REACHED) == (b in reachable)
    path = path_of(wave, clearance)
    if b not in reachable:
        assert path == []
        return
    assert wave.waves == reachable[b]
    assert_good(path, clearance, a, b)
    assert len(path) <= reachable[b] + 2


@given(mazes, inside)
def test_the_waves_are_as_many_as_the_plain_count(where: set[Cell], start: Cell) -> None:
    """Each cell is reached in its wave, as its label says: the wave's number modulo 3."""
    grid, clearance = box(where - {start})
    (cell,) = shifted({start})
    wave = start_wave(lib.WAVEFRONT_EVERYWHERE, cell)
    run(wave, clearance, grid)
    count = oracles.waves(blocked_bits(clearance), cell)
    assert wave.waves == max(count.values()) + 1  # the last one finds nothing
    for (x, y), number in count.items():
        word, bit = y * lib.GRID_BIT_WORDS + x // 32, x % 32
        label = (wave.low[word] >> bit & 1) + 2 * (wave.high[word] >> bit & 1)
        assert label == number % 3 + 1


def test_in_the_open_waves_are_octagons() -> None:
    """So no path is taken for much longer or shorter than it is, compared with another."""
    grid, clearance = with_walls([])
    ratios = []
    for angle in np.linspace(0.0, np.pi / 2, 19):
        dx, dy = round(60 * np.cos(angle)), round(60 * np.sin(angle))
        wave = start_wave(lib.WAVEFRONT_TO_CELL, (64, 64), (64 + dx, 64 + dy))
        assert run(wave, clearance, grid) == lib.WAVEFRONT_REACHED
        ratios.append(wave.waves / np.hypot(dx, dy))
    assert max(ratios) / min(ratios) < 1.12


@given(mazes, inside, inside, st.integers(1, 9))
def test_slicing_does_not_change_the_result(
    where: set[Cell], start: Cell, goal: Cell, waves: int
) -> None:
    grid, clearance = box(where - {start})
    (a,), (b,) = shifted({start}), shifted({goal})
    whole, sliced = (start_wave(lib.WAVEFRONT_TO_CELL, a, b) for _ in range(2))
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
    wave = start_wave(lib.WAVEFRONT_TO_CELL, (10, 10), (120, 10))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_REACHED
    assert_good(path_of(wave, clearance), clearance, (10, 10), (120, 10))


def test_no_way_leads_between_cells_that_touch_at_a_corner() -> None:
    grid, clearance = with_walls({(x, SIDE - 1 - x) for x in range(SIDE)})
    wave = start_wave(lib.WAVEFRONT_TO_CELL, (10, 10), (120, 120))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_EXHAUSTED


def test_the_start_may_be_the_goal() -> None:
    grid, clearance = with_walls([])
    wave = start_wave(lib.WAVEFRONT_TO_CELL, (7, 8), (7, 8))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_REACHED
    assert path_of(wave, clearance) == [middle((7, 8)), middle((7, 8))]


def test_a_way_with_more_corners_than_there_is_room_for_is_not_given() -> None:
    wall = {(x, y) for x in range(8, 120, 4) for y in range(SIDE)}
    wall -= {(x, 0 if x % 8 else SIDE - 1) for x in range(8, 120, 4)}
    grid, clearance = with_walls(wall)
    wave = start_wave(lib.WAVEFRONT_TO_CELL, (4, 64), (122, 64))
    assert run(wave, clearance, grid) == lib.WAVEFRONT_REACHED
    full = path_of(wave, clearance)
    assert_good(full, clearance, (4, 64), (122, 64))
    assert len(full) > 28
    assert path_of(wave, clearance, len(full)) == full
    assert path_of(wave, clearance, len(full) - 1) == []
    assert path_of(wave, clearance, 1) == []


@given(st.sets(inside, max_size=120), st.sets(inside, max_size=120), inside)
def test_a_frontier_is_a_seen_cell_beside_an_unseen_one_reached_through_seen_cells(
    where: set[Cell], unseen: set[Cell], start: Cell
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
    wave = start_wave(lib.WAVEFRONT_OBSERVED, cell)
    found: dict[Cell, int] = {}
    while lib.wavefront_extend(wave, clearance, grid, 1) == lib.WAVEFRONT_RUNNING:
        met = {(wave.met_ix[i], wave.met_iy[i]) for i in range(wave.met)}
        assert not met & set(found)
        found |= dict.fromkeys(met, wave.waves)
    assert wave.status == lib.WAVEFRONT_EXHAUSTED
    count = oracles.waves(blocked | ~known, cell)
    assert reached(wave) == set(count)
    frontier = {
        (x, y): count[x, y]
        for x, y in set(count) - {cell}
        if not all(known[b, a] for a, b in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)))
    }
    assert found.items() <= frontier.items()
    eights = {(x // 8, y, waves) for (x, y), waves in found.items()}
    assert eights == {(x // 8, y, waves) for (x, y), waves in frontier.items()}
    for target in sorted(found)[:3]:
        lib.wavefront_aim(wave, ffi.new("grid_cell_t *", target)[0], found[target])
        assert_good(path_of(wave, clearance), clearance, cell, target)


@pytest.mark.parametrize("point", [(64.0, 64.0), (100.2, 3.3), (-50.0, 500.0)])
def test_the_nearest_reached_cell_is_the_nearest(point: tuple[float, float]) -> None:
    room = from_picture(["######", "#....#", "#....#", "#....#", "######"], 20, 30)
    grid, clearance = with_walls(room)
    wave = start_wave(lib.WAVEFRONT_EVERYWHERE, (22, 32))
    run(wave, clearance, grid)
    found = lib.wavefront_nearest(wave, vec2(*point))
    distance = np.hypot(found.ix + 0.5 - point[0], found.iy + 0.5 - point[1])
    best = min(np.hypot(x + 0.5 - point[0], y + 0.5 - point[1]) for x, y in reached(wave))
    assert distance == pytest.approx(best, rel=1e-5)
