# SPDX-License-Identifier: GPL-3.0-or-later
"""The map stream: changed tiles come first, and every tile is repeated."""

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import OCCUPIED, SIDE, new_grid, values, vec2

TILE: int = lib.GRID_TILE_SIDE_CELLS
PER_ROW: int = lib.GRID_TILES_PER_ROW
TILES: int = lib.GRID_TILES


class Stream:
    """A map stream over one grid, read packet by packet."""

    def __init__(self, grid: CData) -> None:
        self.grid = grid
        self.stream = ffi.new("mapstream_t *")
        lib.mapstream_init(self.stream)

    def next(self, epoch: int = 0) -> list[CData]:
        """The tiles of the next packet."""
        packet = ffi.new("uint8_t[]", lib.WIRE_MAP_BYTES)
        wire, got = ffi.new("wire_map_t *"), ffi.new("uint8_t *")
        lib.mapstream_next(self.stream, self.grid, epoch, packet)
        assert lib.wire_map_open(wire, packet, got)
        assert got[0] == epoch
        tiles = []
        while lib.wire_map_read(wire, tile := ffi.new("wire_tile_t *")):
            tiles.append(tile)
        return tiles


def hard(grid: CData) -> CData:
    """Make tiles of which no two fit into one packet."""
    for i in range(SIDE * SIDE):
        lib.grid_set_value(grid, i % SIDE, i // SIDE, (0, 3, OCCUPIED)[i * 7919 % 1013 % 3])
    settle(grid)
    return grid


def settle(grid: CData) -> None:
    """Clear all marks of changed tiles."""
    ffi.memmove(grid.changed_tiles, bytes(TILES // 8), TILES // 8)


def states(grid: CData) -> np.ndarray[Any, Any]:
    cell = values(grid)
    return np.where(cell == 0, 0, np.where(cell < lib.GRID_OCCUPIED_MIN, 1, 2))


def drawn(pieces: list[list[Any]]) -> np.ndarray[Any, Any]:
    """The map that a listener has after these packets."""
    picture = np.zeros((SIDE, SIDE), dtype=int)
    for piece in itertools.chain(*pieces):
        y, x = piece.tile // PER_ROW * TILE, piece.tile % PER_ROW * TILE
        picture[y : y + TILE, x : x + TILE] = np.reshape(list(piece.states), (TILE, TILE))
    return picture


def test_without_changes_every_tile_comes_in_turn() -> None:
    stream = Stream(hard(new_grid()))
    tiles = [tile.tile for _ in range(TILES + 4) for tile in stream.next()]
    assert set(tiles) == set(range(TILES))
    assert [now for before, now in itertools.pairwise(tiles) if (now - before) % TILES > 1] == []


@pytest.mark.parametrize("listeners", [2, 3, 4, 5, 8])
@pytest.mark.parametrize("crowded", [False, True])
def test_listeners_that_take_turns_all_hear_everything(listeners: int, crowded: bool) -> None:
    grid = new_grid()
    if crowded:
        hard(grid)
    else:
        lib.grid_set_value(grid, 100, 100, OCCUPIED)
    stream = Stream(grid)
    heard: list[set[int]] = [set() for _ in range(listeners)]
    for i in range(16 * listeners * TILES if crowded else 100 * listeners):
        heard[i % listeners] |= {tile.tile for tile in stream.next()}
    assert heard == [set(range(TILES))] * listeners


@given(st.sets(st.integers(0, TILES - 1), min_size=1, max_size=60), st.integers(0, 300))
def test_changed_tiles_come_first(changed: set[int], before: int) -> None:
    grid = new_grid()
    stream = Stream(grid)
    hard(grid)
    for _ in range(before):
        stream.next()
    for tile in changed:
        ix, iy = tile % PER_ROW * TILE + 3, tile // PER_ROW * TILE + 5
        lib.grid_set_value(grid, ix, iy, 3 if lib.grid_value(grid, ix, iy) > 7 else OCCUPIED)
    needed = len(changed) * 4 // 3 + 2
    assert changed <= {tile.tile for _ in range(needed) for tile in stream.next()}
    assert not any(grid.changed_tiles)


def test_every_tile_comes_within_a_bound_although_others_change_all_the_time() -> None:
    grid = new_grid()
    stream = Stream(grid)
    hard(grid)
    seen: set[int] = set()
    for i in range(4 * TILES + 20):
        for ix in (3, 40, 90):
            lib.grid_set_value(grid, ix, 9, 3 if i % 2 else OCCUPIED)
        seen |= {tile.tile for tile in stream.next()}
    assert seen == set(range(TILES))


@given(st.lists(st.tuples(*[st.integers(0, SIDE - 1)] * 2, st.integers(0, 15)), max_size=80))
def test_a_listener_draws_the_same_map(settings: list[tuple[int, int, int]]) -> None:
    grid = new_grid()
    for ix, iy, value in settings:
        lib.grid_set_value(grid, ix, iy, value)
    stream = Stream(grid)
    pieces = [stream.next() for _ in range(len(settings) * 4 // 3 + 2)]
    assert (drawn(pieces) == states(grid)).all()


def test_whatever_was_lost_comes_again() -> None:
    grid = new_grid()
    lib.grid_set_value(grid, 100, 100, OCCUPIED)
    stream = Stream(grid)
    for _ in range(17):
        stream.next()  # lost on the way
    pieces = [stream.next() for _ in range(4 * TILES)]
    assert (drawn(pieces) == states(grid)).all()


def test_the_points_of_a_crowded_tile_come_in_turns() -> None:
    grid = hard(new_grid())
    crowd = {(16 + i % TILE, 24 + i // TILE) for i in range(TILE * TILE)}
    for ix, iy in crowd:
        lib.grid_set_value(grid, ix, iy, OCCUPIED)
        at = lib.grid_to_metres(grid, vec2(ix + 0.3, iy + 0.8))
        lib.grid_points_add(grid, ffi.new("grid_cell_t *", (ix, iy))[0], at, False)
    there = {at for at in crowd if lib.grid_point_eighths(grid, *at) >= 0}
    stream = Stream(grid)
    seen = set()
    for _ in range(30):
        settle(grid)
        lib.grid_set_value(grid, 17, 31, 3 if stream.stream.dice % 2 else OCCUPIED)
        for tile in stream.next():
            if tile.tile == 24 // TILE * PER_ROW + 16 // TILE:
                assert not tile.whole
                cells = [i for i in range(64) if tile.eighths[i] != lib.WIRE_NO_POINT]
                assert len(cells) >= 15
                assert {tile.eighths[i] for i in cells} == {2 + 8 * 6}
                seen |= {(16 + i % TILE, 24 + i // TILE) for i in cells}
    assert seen >= there - {(17, 31)}


def test_a_map_that_was_kept_comes_back_with_its_points() -> None:
    grid, taken = new_grid(), new_grid()
    for i in range(0, SIDE, 3):
        ix, iy = i, i * 7 % SIDE
        lib.grid_set_value(grid, (ix + 40) % SIDE, iy, 2)
        lib.grid_set_value(grid, ix, iy, 9)
        at = lib.grid_to_metres(grid, vec2(ix + i % 8 / 8 + 0.05, iy + i % 5 / 8 + 0.05))
        lib.grid_points_add(grid, ffi.new("grid_cell_t *", (ix, iy))[0], at, False)
    stream, packet = ffi.new("mapstream_t *"), ffi.new("uint8_t[]", lib.WIRE_MAP_BYTES)
    for _ in range(2 * TILES):
        lib.mapstream_next(stream, grid, 1, packet)
        assert lib.mapstream_take(taken, 1, packet)
    assert (states(taken) == states(grid)).all()
    for at in itertools.product(range(SIDE), repeat=2):
        assert lib.grid_point_eighths(taken, *at) == lib.grid_point_eighths(grid, *at)
    assert not lib.mapstream_take(taken, 2, packet)


def test_reading_the_stream_changes_no_cell() -> None:
    grid = new_grid()
    for i in range(SIDE):
        lib.grid_set_value(grid, i, i * 7 % SIDE, i % 16)
    before = values(grid).copy()
    known = grid.known
    stream = Stream(grid)
    for _ in range(600):
        stream.next()
    assert (values(grid) == before).all()
    assert grid.known == known
