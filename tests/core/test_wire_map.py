# SPDX-License-Identifier: GPL-3.0-or-later
"""Map packets: what is written is read, and nothing else is."""

import random

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ground.core import ffi, lib

u8 = st.integers(0, 255)
OCCUPIED: int = lib.GRID_CELL_OCCUPIED
NO_POINT: int = lib.WIRE_NO_POINT
Tile = tuple[list[int], list[int]]


@st.composite
def tiles(draw: st.DrawFn) -> Tile:
    """States and points of a tile: noise, or rectangles of states as rooms have them."""
    cells = np.full((8, 8), draw(st.integers(0, 2)))
    for _ in range(draw(st.integers(0, 4))):
        x, y = draw(st.integers(0, 7)), draw(st.integers(0, 7))
        cells[y : draw(st.integers(y, 8)), x : draw(st.integers(x, 8))] = draw(st.integers(0, 2))
    noise = random.Random(draw(st.integers(0, 255)))
    if draw(st.integers(0, 3)) == 0:
        cells = np.array([[noise.randrange(3) for _ in range(8)] for _ in range(8)])
    states = [int(state) for state in cells.ravel()]
    places = (NO_POINT, *range(64))
    return states, [noise.choice(places) if s == OCCUPIED else NO_POINT for s in states]


rows = st.lists(tiles(), min_size=1, max_size=12)


def write(first: int, epoch: int, given: list[Tile]) -> tuple[bytes, int]:
    """Write a packet of these tiles; return it and how many of them fitted."""
    wire, tile = ffi.new("wire_map_t *"), ffi.new("wire_tile_t *")
    lib.wire_map_begin(wire, first, epoch)
    count = 0
    for states, eighths in given:
        tile.tile, tile.first_point = (first + count) % 256, 20
        tile.states, tile.eighths = states, eighths
        if not lib.wire_map_add(wire, tile):
            break
        count += 1
    lib.wire_map_end(wire)
    return bytes(ffi.buffer(wire.bytes)), count


def read(data: bytes) -> tuple[int, list[tuple[int, bool, list[int], list[int]]]] | None:
    """Epoch and tiles of a packet; None if it is refused."""
    wire, epoch, tile = (ffi.new(f"{kind} *") for kind in ("wire_map_t", "uint8_t", "wire_tile_t"))
    if not lib.wire_map_open(wire, data, epoch):
        return None
    found = []
    while lib.wire_map_read(wire, tile):
        found.append((tile.tile, bool(tile.whole), list(tile.states), list(tile.eighths)))
    return epoch[0], found


@given(u8, st.integers(0, lib.WIRE_MAP_EPOCHS - 1), rows)
def test_every_map_piece_comes_back(first: int, epoch: int, given: list[Tile]) -> None:
    data, count = write(first, epoch, given)
    assert 1 <= count <= 256 - first
    got_epoch, found = read(data) or (None, [])
    assert got_epoch == epoch
    assert [number for number, *_ in found] == list(range(first, first + count))
    for (_, whole, states, eighths), (wanted, points) in zip(found, given, strict=False):
        assert states == wanted
        assert all(got in (p, NO_POINT) for got, p in zip(eighths, points, strict=True))
        assert whole <= (eighths == points)
    assert all(whole for _, whole, *_ in found[:-1])
    assert found[-1][1] or count == 1, "points are left out only of a tile that is alone"


def test_an_unknown_map_is_one_piece() -> None:
    unknown = ([0] * 64, [NO_POINT] * 64)
    assert write(0, 0, [unknown] * 300)[1] == 256


def test_a_tile_full_of_points_tells_at_least_ten_of_them() -> None:
    noise = random.Random(3)
    states = [noise.choice((0, 1, 2)) for _ in range(64)]
    points = [7 if state == OCCUPIED else NO_POINT for state in states]
    _, ((_, whole, got, eighths),) = read(write(9, 1, [(states, points)])[0]) or (0, [])
    assert got == states
    assert not whole
    assert 10 <= sum(place == 7 for place in eighths) < sum(place == 7 for place in points)


@given(rows, st.integers(0, lib.WIRE_MAP_BYTES * 8 - 1))
def test_a_flipped_bit_in_a_map_piece_is_noticed(given: list[Tile], bit: int) -> None:
    packet = bytearray(write(0, 0, given)[0])
    packet[bit // 8] ^= 1 << bit % 8
    assert read(bytes(packet)) is None


def test_parts_of_different_pieces_are_noticed() -> None:
    def piece(tile: int) -> bytes:
        states = [(tile >> k % 4) % 3 for k in range(64)]
        return write(tile, 0, [(states, [NO_POINT] * 64)])[0]

    whole = {piece(a) for a in range(16)}
    cuts = range(4, lib.WIRE_MAP_BYTES, 4)
    mixed = {a[:cut] + b[cut:] for a in whole for b in whole for cut in cuts} - whole
    taken = [data for data in mixed if read(data) is not None]
    assert len(taken) <= len(mixed) / 500


@given(st.binary(min_size=lib.WIRE_MAP_BYTES, max_size=lib.WIRE_MAP_BYTES))
def test_whatever_passes_for_a_piece_is_possible(packet: bytes) -> None:
    wire, epoch, tile = (ffi.new(f"{kind} *") for kind in ("wire_map_t", "uint8_t", "wire_tile_t"))
    lib.wire_map_open(wire, packet, epoch)  # read it whatever the check says
    count = 0
    while lib.wire_map_read(wire, tile):
        count += 1
        assert max(tile.states) <= OCCUPIED
        assert all(place < 64 or place == NO_POINT for place in tile.eighths)
    assert count <= 256 - packet[0]
