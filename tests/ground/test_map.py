# SPDX-License-Identifier: GPL-3.0-or-later
"""The ground's map equals the drone's, whatever the order, loss and repetition of packets."""

import itertools
import random
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from ground.core import GRID_SIDE_CELLS, TILES, CData, CellState, ffi, lib
from ground.map.groundmap import NO_POINT, GroundMap
from ground.model import Capability, Hello, MapPacket, MapPiece, Point

MIDDLE = GRID_SIDE_CELLS // 2


@pytest.fixture(scope="module")
def grid() -> CData:
    """A drone's grid with some obstacles, as the core makes it."""
    grid = ffi.new("grid_t *")
    cfg = ffi.new("grid_config_t *", lib.grid_config_default())
    lib.grid_init(grid, cfg, (0.3, -0.2), 0.05)
    frame = ffi.new("scan_frame_t *")
    frame.hit, frame.clear = 0b1101, 0b0010
    rng = random.Random(5)
    for _ in range(60):
        frame.range_m[0:4] = [rng.uniform(0.3, 2.5) for _ in range(4)]
        pose = (rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-3, 3))
        for _ in range(3):
            lib.grid_insert(grid, frame, pose)
    return grid


def stream(grid: CData, epoch: int = 0) -> Iterator[MapPacket]:
    mapstream = ffi.new("mapstream_t *")
    lib.mapstream_init(mapstream)
    packed = ffi.new("uint8_t[]", 26)
    for drone_ms in itertools.count(0, 10):
        lib.mapstream_next(mapstream, grid, epoch, packed)
        yield MapPacket(drone_ms, bytes(packed))


def true_states(grid: CData) -> list[list[int]]:
    side = range(GRID_SIDE_CELLS)
    return [[lib.grid_state(grid, ix, iy) for ix in side] for iy in side]


@settings(max_examples=10, deadline=None)
@given(loss=st.floats(0, 0.5), seed=st.integers(0, 1000))
def test_map_becomes_whole_in_spite_of_losses(grid: CData, loss: float, seed: int) -> None:
    ground, rng = GroundMap(), random.Random(seed)
    pieces = stream(grid)
    for _ in range(40 * TILES):
        packet = next(pieces)
        if rng.random() >= loss:
            ground.take_packet(packet, 0.0)
        if ground.completeness == 1:
            break
    assert ground.completeness == 1
    assert ground.states.tolist() == true_states(grid)
    assert ground.known_cells == grid.known


def test_points_lie_where_the_drone_has_them(grid: CData) -> None:
    ground, pieces = GroundMap(), stream(grid)
    origin = Point(grid.origin_m.x, grid.origin_m.y)
    ground.take_hello(Hello(Capability(0), 0, grid.cell_m, GRID_SIDE_CELLS, origin))
    for _ in range(40 * TILES):
        ground.take_packet(next(pieces), 0.0)
    expected: list[tuple[float, float]] = []
    place = ffi.new("vec2_t *")
    for iy in range(GRID_SIDE_CELLS):
        for ix in range(GRID_SIDE_CELLS):
            if lib.grid_point(grid, ix, iy, place):
                expected.append((place.x, place.y))
    rows, columns = np.nonzero(ground.states == CellState.OCCUPIED)
    known = ground.eighths[rows, columns] != NO_POINT
    drawn = ground.obstacles_m()[known]
    assert len(expected) > 50
    assert lattice(drawn, grid) == lattice(np.array(expected), grid)


def lattice(places_m: NDArray[np.float64], grid: CData) -> set[tuple[int, ...]]:
    """A point in eighths of a cell, the resolution at which points are kept."""
    eighths = (places_m - [grid.origin_m.x, grid.origin_m.y]) / grid.cell_m * 8 - 0.5
    return {tuple(row) for row in np.rint(eighths).astype(int).tolist()}


def piece_of(tile: int, epoch: int = 0, state: CellState = CellState.OCCUPIED) -> MapPiece:
    return MapPiece(tile, epoch, bytes([state] * 64), ((9, 0o75),))


def test_new_epoch_clears_and_an_older_piece_is_ignored() -> None:
    ground = GroundMap()
    assert ground.take_piece(piece_of(0, epoch=3), 1.0)
    assert ground.take_piece(piece_of(1, epoch=0, state=CellState.FREE), 2.0)
    assert ground.known_cells == 64
    assert ground.completeness == 1 / TILES
    assert not ground.take_piece(piece_of(0, epoch=3), 3.0)
    assert ground.known_cells == 64


def test_hello_moves_the_grid_and_clears_what_was_drawn_elsewhere() -> None:
    ground = GroundMap()
    ground.take_piece(piece_of(0), 1.0)
    hello = Hello(Capability(0), 0, 0.1, GRID_SIDE_CELLS, Point(-1.0, -2.0))
    ground.take_hello(hello)
    assert ground.known_cells == 0
    ground.take_piece(piece_of(0), 2.0)
    ground.take_hello(hello)
    assert ground.known_cells == 64
    assert ground.obstacles_m().min(axis=0) == pytest.approx([-0.95, -1.95])


def test_point_goes_with_its_cell() -> None:
    ground = GroundMap()
    ground.take_piece(piece_of(0), 1.0)
    x, y = 0o5, 0o7
    assert ground.eighths[1, 1] == x | y << 3
    assert ground.codes()[1, 1] == 3 + 4 * (x | y << 3)
    ground.take_piece(MapPiece(0, 0, bytes([CellState.FREE] * 64), ()), 2.0)
    assert np.all(ground.eighths == NO_POINT)


def test_a_point_stays_when_a_later_piece_carries_other_points() -> None:
    ground = GroundMap()
    ground.take_piece(piece_of(0), 1.0)
    ground.take_piece(MapPiece(0, 0, bytes([CellState.OCCUPIED] * 64), ((0, 3),)), 2.0)
    assert (ground.eighths != NO_POINT).sum() == 2


def test_age_and_revision() -> None:
    ground = GroundMap()
    ground.take_piece(piece_of(7), 10.0)
    ages_s = ground.tile_ages_s(12.5)
    assert ages_s[7] == 2.5
    assert np.isinf(ages_s).sum() == TILES - 1
    revision = ground.revision
    ground.take_piece(piece_of(7), 11.0)
    assert ground.revision == revision, "the same piece again is no change"
