# SPDX-License-Identifier: GPL-3.0-or-later
"""The map stream through log blocks: whole pieces, each once, whatever the client asks for."""

import itertools
import random

import pytest

from ground.core import TILES, MissionCmd, MissionState
from ground.model import MapPiece
from ground.sim.firmware import BlockReader
from ground.wire import decode_map_piece
from tests.app.drone import UINT16, UINT32, Drone

NAMES = [f"m{i}" for i in range(7)]


@pytest.fixture
def mapped(drone: Drone) -> Drone:
    """Has taken off and looked around."""
    drone.command(MissionCmd.SCAN if drone.state is MissionState.HOVER else MissionCmd.TAKE_OFF)
    drone.run_until(MissionState.HOVER)
    drone.command(MissionCmd.SCAN)
    drone.run(5.0)
    return drone


def block(drone: Drone, order: list[str]) -> BlockReader:
    ids = [drone.logs[f"waymap.{name}"] for name in order]
    return drone.firmware.block_reader(ids, [UINT16 if n == "m6" else UINT32 for n in order])


def ordered(data: bytes, order: list[str]) -> bytes:
    """The 26 bytes of a piece from a block in any order."""
    sizes = [2 if name == "m6" else 4 for name in order]
    ends = list(itertools.accumulate(sizes))
    parts = {n: data[end - size : end] for n, end, size in zip(order, ends, sizes, strict=True)}
    return b"".join(parts[name] for name in NAMES)


def pieces(drone: Drone, order: list[str], count: int) -> list[MapPiece]:
    """Samples at 50 Hz, as pieces; all of them must be whole."""
    reader = block(drone, order)
    found = []
    for _ in range(count):
        drone.run(0.02)
        piece = decode_map_piece(ordered(reader.read(drone.firmware.now_ms()), order))
        assert piece is not None
        found.append(piece)
    return found


@pytest.mark.parametrize("seed", range(4))
def test_pieces_are_whole_in_any_order_of_variables(mapped: Drone, seed: int) -> None:
    order = random.Random(seed).sample(NAMES, len(NAMES)) if seed else NAMES
    found = pieces(mapped, order, 40)
    assert len({piece.tile for piece in found}) > 20


def test_all_getters_of_one_time_stamp_agree(mapped: Drone) -> None:
    reader = block(mapped, NAMES)
    now_ms = mapped.firmware.now_ms() + 1
    first = reader.read(now_ms)
    assert reader.read(now_ms) == first
    assert reader.read(now_ms + 1) != first


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
    latest = {piece.tile: piece for piece in pieces(mapped, NAMES, 4 * TILES + 100)}
    assert len(latest) == TILES
    known = sum(1 for piece in latest.values() for state in piece.states if state)
    assert known == mapped.log("way.known") > 500


def test_worst_tick_is_counted_anew_by_each_sample(drone: Drone) -> None:
    """Simulated time stands still while the app computes, so it must read zero."""
    assert drone.log("way.tickUs") == 0
