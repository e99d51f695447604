# SPDX-License-Identifier: GPL-3.0-or-later
"""The map stream through log blocks: whole packets, each once, whatever the client requests."""

import itertools
import math
import random

import pytest

from ground.core import (
    GRID_SIDE_CELLS,
    TILE_SIDE_CELLS,
    TILES,
    TILES_PER_ROW,
    CellState,
    MissionCmd,
    MissionState,
)
from ground.link.wire import decode_map_piece
from ground.model import MapPiece
from ground.sim.firmware import BlockReader
from tests.app.drone import UINT16, UINT32, Drone

CELL_M = 0.05
OCCUPIED = CellState.OCCUPIED
NAMES = [f"m{i}" for i in range(7)]


@pytest.fixture
def mapped(drone: Drone) -> Drone:
    """A drone that has taken off and looked around."""
    drone.command(MissionCmd.SCAN if drone.state is MissionState.HOVER else MissionCmd.TAKE_OFF)
    drone.run_until(MissionState.HOVER)
    drone.command(MissionCmd.SCAN)
    drone.run(5.0)
    return drone


def block(drone: Drone, order: list[str]) -> BlockReader:
    ids = [drone.logs[f"waymap.{name}"] for name in order]
    return drone.firmware.block_reader(ids, [UINT16 if n == "m6" else UINT32 for n in order])


def occupied_m(piece: MapPiece) -> list[tuple[float, float]]:
    """Centres of the occupied cells of a map packet, in the map of a new drone."""
    origin_m = -GRID_SIDE_CELLS / 2 * CELL_M
    row, column = divmod(piece.tile, TILES_PER_ROW)
    places = [divmod(i, TILE_SIDE_CELLS) for i, s in enumerate(piece.states) if s == OCCUPIED]
    return [
        (
            origin_m + (column * TILE_SIDE_CELLS + ix + 0.5) * CELL_M,
            origin_m + (row * TILE_SIDE_CELLS + iy + 0.5) * CELL_M,
        )
        for iy, ix in places
    ]


def ordered(data: bytes, order: list[str]) -> bytes:
    """The 26 bytes of a map packet from a block with its variables in any order."""
    sizes = [2 if name == "m6" else 4 for name in order]
    ends = list(itertools.accumulate(sizes))
    parts = {n: data[end - size : end] for n, end, size in zip(order, ends, sizes, strict=True)}
    return b"".join(parts[name] for name in NAMES)


def pieces(drone: Drone, order: list[str], count: int) -> list[list[MapPiece]]:
    """The tiles of samples at 50 Hz; all packets must be intact."""
    reader = block(drone, order)
    found = []
    for _ in range(count):
        drone.run(0.02)
        tiles = decode_map_piece(ordered(reader.read(drone.firmware.now_ms()), order))
        assert tiles
        found.append(tiles)
    return found


def tiles(drone: Drone, count: int) -> dict[int, MapPiece]:
    """The latest version of each tile in so many samples."""
    return {tile.tile: tile for piece in pieces(drone, NAMES, count) for tile in piece}


@pytest.mark.parametrize("seed", range(4))
def test_pieces_are_whole_in_any_order_of_variables(mapped: Drone, seed: int) -> None:
    order = random.Random(seed).sample(NAMES, len(NAMES)) if seed else NAMES
    found = pieces(mapped, order, 40)
    assert len({piece[0].tile for piece in found}) > 20


def test_all_getters_of_one_time_stamp_agree(mapped: Drone) -> None:
    reader = block(mapped, NAMES)
    now_ms = mapped.firmware.now_ms() + 1
    first = reader.read(now_ms)
    assert reader.read(now_ms) == first
    mapped.run(0.02)
    assert reader.read(mapped.firmware.now_ms()) != first


@pytest.mark.parametrize("late_ms", [0, 3, 20, 30, 57])
@pytest.mark.parametrize("first", [1, 3, 6])
def test_two_blocks_of_one_period_tell_whole_pieces_together(
    mapped: Drone, first: int, late_ms: int
) -> None:
    """As in cfclient's plotter, which puts as many variables into a block as fit."""
    early, late = block(mapped, NAMES[:first]), block(mapped, NAMES[first:])
    numbers = set()
    for _ in range(40):
        data = early.read(mapped.firmware.now_ms())
        mapped.firmware.run(late_ms)
        data += late.read(mapped.firmware.now_ms())
        found = decode_map_piece(data)
        assert found
        numbers.add(found[0].tile)
        mapped.firmware.run(60 - late_ms)
    assert len(numbers) > 20


def test_the_stream_goes_as_fast_as_it_is_asked(mapped: Drone) -> None:
    """At the shortest period of a block, 10 ms, no packet comes twice."""
    reader = block(mapped, NAMES)
    samples = []
    for _ in range(100):
        mapped.firmware.run(10)
        samples.append(reader.read(mapped.firmware.now_ms()))
    repeated = sum(a == b for a, b in itertools.pairwise(samples))
    assert repeated <= 2, "while it learns the period"


def test_when_none_is_ready_the_last_piece_comes_again(mapped: Drone) -> None:
    reader = block(mapped, NAMES)
    now_ms = mapped.firmware.now_ms()
    samples = [reader.read(now_ms + i) for i in range(50)]
    assert samples[-1] == samples[-2]
    assert decode_map_piece(samples[-1]) is not None
    mapped.run(0.1)
    assert reader.read(mapped.firmware.now_ms()) != samples[-1]


def test_the_stream_tells_the_whole_map(mapped: Drone) -> None:
    mapped.command(MissionCmd.LAND)
    mapped.run_until(MissionState.IDLE)
    latest = tiles(mapped, 4 * TILES + 100)
    assert len(latest) == TILES
    known = sum(1 for piece in latest.values() for state in piece.states if state)
    assert known == mapped.log("way.known") > 500


FRONT, LEFT, RIGHT = 0, 2, 3
BEARINGS = {FRONT: 0.0, LEFT: math.pi / 2, RIGHT: -math.pi / 2}


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "beam", "wall"),
    [
        (-15.0, 0.0, FRONT, False),
        (15.0, 0.0, FRONT, True),
        (0.0, 15.0, RIGHT, False),
        (0.0, 15.0, LEFT, True),
        (0.0, -15.0, LEFT, False),
    ],
)
def test_where_a_side_hangs_down_the_floor_is_no_wall(
    drone: Drone, pitch_deg: float, roll_deg: float, beam: int, wall: bool
) -> None:
    """At 0.4 m height a beam 15 degrees down meets the floor after 1.55 m; upwards it is a wall.

    Nose up and right side down are positive.
    """
    drone.write("way.slam", 0)
    drone.command(MissionCmd.TAKE_OFF)
    drone.run_until(MissionState.HOVER)
    drone.readings.pitch_deg, drone.readings.roll_deg = pitch_deg, roll_deg
    for i in range(10):
        ranges = [32767] * 5
        ranges[beam] = 1550 + i % 2
        drone.hang(0.1, (ranges[0], ranges[1], ranges[2], ranges[3], ranges[4]))
    bearing = math.radians(drone.log("way.yaw")) + BEARINGS[beam]
    level_m = 1.55 * math.cos(math.radians(15.0))
    at_m = (
        drone.log("way.x") + level_m * math.cos(bearing),
        drone.log("way.y") + level_m * math.sin(bearing),
    )
    reader = block(drone, NAMES)
    found: dict[int, bool] = {}
    for _ in range(TILES):
        drone.firmware.run(20)
        for tile in decode_map_piece(reader.read(drone.firmware.now_ms())):
            found[tile.tile] = any(math.dist(place, at_m) < 0.15 for place in occupied_m(tile))
    assert any(found.values()) is wall
