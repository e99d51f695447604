# SPDX-License-Identifier: GPL-3.0-or-later
"""Packets survive the way through C and back; garbage is refused and never raises."""

import dataclasses
import math
import random
import struct

from hypothesis import given
from hypothesis import strategies as st

from ground.core import (
    MAP_BYTES,
    PACKET_BYTES,
    PATH_POINTS,
    TILES,
    WIRE_VERSION,
    Capability,
    CData,
    CellState,
    EventCode,
    MissionCmd,
    MissionReason,
    MissionState,
    RecordKind,
    WireStatus,
    WireType,
    ffi,
    lib,
)
from ground.link.wire import (
    decode_map_piece,
    decode_message,
    encode_map_piece,
    encode_request,
    is_map_piece,
    pack,
    unpack,
)
from ground.model import Ack, Beat, Event, Hello, History, MapPiece, Point, Record, RoutePiece
from ground.requests import Ask, AskTiles, Command, Heartbeat, HelloRequest, SnapshotRequest

u8 = st.integers(0, 0xFF)
u16 = st.integers(0, 0xFFFF)
u32 = st.integers(0, 0xFFFFFFFF)
metres = st.floats(-1e6, 1e6, width=32)
points = st.builds(Point, metres, metres)
any_float = st.floats(width=32)


def message(kind: WireType) -> CData:
    packet = ffi.new("wire_message_t *")
    packet.type = kind
    return packet


@given(u16, st.sampled_from(MissionCmd), st.builds(Point, any_float, any_float))
def test_command_reaches_the_drone_bit_by_bit(sequence: int, cmd: MissionCmd, goal: Point) -> None:
    status, heard = unpack(encode_request(Command(sequence, cmd, goal)))
    command = heard.body.command
    assert status is WireStatus.OK
    assert heard.type == WireType.COMMAND
    assert (command.sequence, command.cmd) == (sequence, cmd)
    for sent, got in ((goal.x_m, command.goal_m.x), (goal.y_m, command.goal_m.y)):
        assert struct.pack("<f", got) == struct.pack("<f", sent) or math.isnan(sent)


@given(u16)
def test_heartbeat_reaches_the_drone(sequence: int) -> None:
    status, heard = unpack(encode_request(Heartbeat(sequence)))
    assert (status, heard.type) == (WireStatus.OK, WireType.HEARTBEAT)
    assert heard.body.heartbeat.sequence == sequence


def test_requests_reach_the_drone() -> None:
    status, heard = unpack(encode_request(HelloRequest()))
    assert (status, heard.type, heard.body.hello.request) == (WireStatus.OK, WireType.HELLO, 1)
    status, heard = unpack(encode_request(SnapshotRequest()))
    assert (status, heard.type) == (WireStatus.OK, WireType.SNAPSHOT)


@given(st.integers(0, 15), st.integers(0, 3), st.integers(1, 0xFFFF), u16, points)
def test_hello_comes_back(caps: int, epoch: int, cell_mm: int, side: int, origin: Point) -> None:
    packet = message(WireType.HELLO)
    packet.body.hello = (0, caps, epoch, cell_mm, side, (origin.x_m, origin.y_m))
    expected = Hello(Capability(caps), epoch, cell_mm / 1000, side, origin)
    assert decode_message(pack(packet)) == expected


@given(u16, u8, st.sampled_from(MissionReason))
def test_ack_comes_back(sequence: int, cmd: int, reason: MissionReason) -> None:
    packet = message(WireType.ACK)
    packet.body.ack = (sequence, cmd, reason)
    assert decode_message(pack(packet)) == Ack(sequence, cmd, reason)


@given(u8, u8, u8, st.lists(st.tuples(*[st.integers(-32000, 32000)] * 2), max_size=PATH_POINTS))
def test_path_comes_back_to_the_millimetre(
    revision: int, first: int, total: int, places_mm: list[tuple[int, int]]
) -> None:
    packet = message(WireType.PATH)
    path = packet.body.path
    path.revision, path.first, path.total, path.count = revision, first, total, len(places_mm)
    for i, (x_mm, y_mm) in enumerate(places_mm):
        path.points_m[i] = (x_mm / 1000, y_mm / 1000)
    piece = decode_message(pack(packet))
    assert isinstance(piece, RoutePiece)
    assert (piece.revision, piece.first, piece.total) == (revision, first, total)
    back = [(round(p.x_m * 1000), round(p.y_m * 1000)) for p in piece.points]
    assert back == places_mm


@given(u16, u32, st.sampled_from(EventCode), st.sampled_from(MissionState), points)
def test_event_comes_back(
    sequence: int, time_ms: int, code: EventCode, argument: int, place: Point
) -> None:
    packet = message(WireType.EVENT)
    packet.body.event = (sequence, time_ms, code, argument, (place.x_m, place.y_m))
    assert decode_message(pack(packet)) == Event(sequence, time_ms, code, argument, place)


@given(st.builds(Beat, u16, u32, st.sampled_from(MissionState), u8, u8, u16, u16))
def test_beat_comes_back(beat: Beat) -> None:
    packet = message(WireType.HEARTBEAT)
    packet.body.heartbeat = dataclasses.astuple(beat)
    assert decode_message(pack(packet)) == beat


records = st.builds(
    Record,
    u32,
    st.sampled_from(RecordKind),
    *[st.integers(-32000, 32000).map(lambda mm: mm / 1000)] * 2,
    st.integers(-31416, 31416).map(lambda units: units / 10_000),
)


@given(st.builds(History, u16, st.lists(records, min_size=1, max_size=2).map(tuple)))
def test_history_comes_back(history: History) -> None:
    packet = message(WireType.HISTORY)
    body = packet.body.history
    body.first, body.count = history.first, len(history.records)
    for i, record in enumerate(history.records):
        numbers = [round(1000 * record.x_m), round(1000 * record.y_m), round(1e4 * record.yaw_rad)]
        body.records[i] = (record.drone_ms, *numbers, record.kind)
    assert decode_message(pack(packet)) == history


@given(st.sampled_from(WireType), u16, u8)
def test_what_is_asked_for_reaches_the_drone(what: WireType, first: int, count: int) -> None:
    status, heard = unpack(encode_request(Ask(what, first, count)))
    ask = heard.body.ask
    assert (status, heard.type) == (WireStatus.OK, WireType.ASK)
    assert (ask.what, ask.first, ask.count) == (what, first, count)


@given(st.lists(u8, max_size=lib.WIRE_TILES_A_PACKET))
def test_the_tiles_asked_for_reach_the_drone(tiles: list[int]) -> None:
    status, heard = unpack(encode_request(AskTiles(tuple(tiles))))
    assert (status, heard.type) == (WireStatus.OK, WireType.TILES)
    assert list(heard.body.tiles.tiles)[: heard.body.tiles.count] == tiles


@given(st.binary(max_size=40))
def test_garbage_is_refused_without_raising(data: bytes) -> None:
    heard = decode_message(data)
    if heard is not None:
        assert data[0] == WIRE_VERSION
        assert len(data) <= PACKET_BYTES


@given(st.sampled_from(WireType), st.binary(max_size=34))
def test_garbage_behind_a_good_header_never_raises(kind: WireType, data: bytes) -> None:
    decode_message(bytes([WIRE_VERSION, kind]) + data)


@given(st.binary(min_size=1, max_size=5))
def test_longer_or_shorter_packets_are_refused(tail: bytes) -> None:
    packet = message(WireType.ACK)
    packet.body.ack = (1, 2, MissionReason.OK)
    good = pack(packet)
    assert decode_message(good) is not None
    assert decode_message(good + tail) is None
    assert decode_message(good[: -len(tail)]) is None


def test_what_this_build_does_not_know_is_refused() -> None:
    packet = message(WireType.ACK)
    packet.body.ack = (1, 2, 200)
    assert decode_message(pack(packet)) is None
    packet = message(WireType.EVENT)
    packet.body.event = (1, 2, EventCode.STATE, 200, (0, 0))
    assert decode_message(pack(packet)) is None
    packet = message(WireType.HELLO)
    packet.body.hello = (0, 0, 0, 50, 128, (math.nan, 0))
    assert decode_message(pack(packet)) is None


cells = st.lists(st.sampled_from(CellState), min_size=64, max_size=64)


@given(st.integers(0, TILES - 1), st.integers(0, 3), cells, st.randoms())
def test_map_piece_comes_back(
    tile: int, epoch: int, states: list[CellState], choice: random.Random
) -> None:
    occupied = [i for i, state in enumerate(states) if state is CellState.OCCUPIED]
    places = [(i, choice.randrange(64)) for i in occupied if choice.random() < 0.5]
    packed = encode_map_piece(MapPiece(tile, epoch, bytes(states), tuple(places)))
    assert is_map_piece(packed)
    (back,) = decode_map_piece(packed)
    assert (back.tile, back.epoch, list(back.states)) == (tile, epoch, states)
    assert set(back.points) <= set(places)
    assert back.whole == (set(back.points) == set(places))


@given(st.binary(max_size=40))
def test_map_garbage_never_raises(data: bytes) -> None:
    assert bool(decode_map_piece(data)) <= is_map_piece(data)
    assert is_map_piece(data) <= (len(data) == MAP_BYTES)
