# SPDX-License-Identifier: GPL-3.0-or-later
"""Packets: what is encoded is decoded, and nothing else is."""

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib

u8 = st.integers(0, 255)
u16 = st.integers(0, 2**16 - 1)
u32 = st.integers(0, 2**32 - 1)
floats = st.floats(width=32, allow_nan=False)
vectors = st.fixed_dictionaries({"x": floats, "y": floats})
millimetres = st.integers(-32767, 32767).map(lambda mm: mm / 1000)
way_points = st.fixed_dictionaries({"x": millimetres, "y": millimetres})


def of(**fields: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries(fields)


def path(points: list[dict[str, float]]) -> st.SearchStrategy[dict[str, Any]]:
    return of(revision=u8, first=u8, total=u8, count=st.just(len(points)), points_m=st.just(points))


def listed(points: list[list[int]]) -> st.SearchStrategy[dict[str, Any]]:
    return of(
        sequence=u16,
        list=u8,
        first=u8,
        total=u8,
        count=st.just(len(points)),
        points_mm=st.just(points),
    )


signed = st.integers(-0x8000, 0x7FFF)
lists = st.lists(
    st.lists(signed, min_size=2, max_size=2), max_size=lib.WIRE_WAYPOINTS_A_PACKET
).flatmap(listed)
record = of(time_ms=u32, x_mm=signed, y_mm=signed, yaw_1e4_rad=signed, kind=u8)
histories = st.lists(record, max_size=lib.WIRE_RECORDS_A_PACKET).flatmap(
    lambda records: of(first=u16, count=st.just(len(records)), records=st.just(records))
)
tile_lists = st.lists(u8, max_size=lib.WIRE_TILES_A_PACKET).flatmap(
    lambda tiles: of(count=st.just(len(tiles)), tiles=st.just(tiles))
)
paths = st.lists(way_points, max_size=lib.WIRE_PATH_POINTS).flatmap(path)
BODIES = {
    lib.WIRE_HELLO: (
        "hello",
        of(request=u8, capabilities=u8, epoch=u8, cell_mm=u16, side_cells=u16, origin_m=vectors),
    ),
    lib.WIRE_COMMAND: ("command", of(sequence=u16, cmd=u8, goal_m=vectors)),
    lib.WIRE_ACK: ("ack", of(sequence=u16, cmd=u8, reason=u8)),
    lib.WIRE_PATH: ("path", paths),
    lib.WIRE_WAYPOINTS: ("waypoints", lists),
    lib.WIRE_EVENT: (
        "event",
        of(sequence=u16, time_ms=u32, code=u8, argument=u8, place_m=vectors),
    ),
    lib.WIRE_HEARTBEAT: (
        "heartbeat",
        of(
            sequence=u16,
            time_ms=u32,
            state=u8,
            path_revision=u8,
            path_total=u8,
            next_event=u16,
            next_record=u16,
        ),
    ),
    lib.WIRE_HISTORY: ("history", histories),
    lib.WIRE_ASK: ("ask", of(what=u8, first=u16, count=u8)),
    lib.WIRE_TILES: ("tiles", tile_lists),
    lib.WIRE_STEER: (
        "steer",
        of(sequence=u16, velocity_mps=vectors, yaw_rate_rps=floats, climb_mps=floats),
    ),
}
kinds = st.sampled_from(sorted(BODIES))
messages = kinds.flatmap(lambda kind: st.tuples(st.just(kind), BODIES[kind][1]))
TYPES = {*BODIES, lib.WIRE_SNAPSHOT, lib.WIRE_MAP}


def plain(value: CData) -> CData:
    """A C value as dictionaries, lists and numbers."""
    kind = ffi.typeof(value) if isinstance(value, ffi.CData) else None
    if kind is None:
        return value
    if kind.kind == "array":
        return [plain(item) for item in value]
    return {name: plain(getattr(value, name)) for name, _ in kind.fields}


def make(kind: int, fields: dict[str, Any]) -> CData:
    return ffi.new("wire_message_t *", {"type": kind, "body": {BODIES[kind][0]: fields}})


def encode(message: CData) -> bytes:
    packet = ffi.new("uint8_t[]", lib.WIRE_PACKET_BYTES)
    return bytes(ffi.buffer(packet, lib.wire_encode(message, packet)))


def decode(packet: bytes) -> tuple[int, Any]:
    message = ffi.new("wire_message_t *")
    return lib.wire_decode(packet, len(packet), message), message


@given(messages)
def test_every_packet_comes_back(sent: tuple[int, dict[str, Any]]) -> None:
    kind, fields = sent
    packet = encode(make(kind, fields))
    assert 2 < len(packet) <= lib.WIRE_PACKET_BYTES
    assert packet[:2] == bytes([lib.WIRE_VERSION, kind])
    status, message = decode(packet)
    assert status == lib.WIRE_OK
    assert message.type == kind
    got = plain(getattr(message.body, BODIES[kind][0]))
    if kind == lib.WIRE_PATH:
        for point, wanted in zip(got.pop("points_m"), fields["points_m"], strict=False):
            assert point == pytest.approx(wanted, abs=1e-5)
    if kind == lib.WIRE_WAYPOINTS:
        assert got.pop("points_mm")[: fields["count"]] == fields["points_mm"]
    if kind in (lib.WIRE_HISTORY, lib.WIRE_TILES):
        listed_as = "records" if kind == lib.WIRE_HISTORY else "tiles"
        assert got.pop(listed_as)[: fields["count"]] == fields[listed_as]
    assert all(got[name] == fields[name] for name in got)


def test_the_bytes_of_a_command() -> None:
    message = make(lib.WIRE_COMMAND, {"sequence": 0x1234, "cmd": 2, "goal_m": {"x": 1.5, "y": -2}})
    assert encode(message) == bytes([lib.WIRE_VERSION, 2]) + struct.pack(
        "<HBff", 0x1234, 2, 1.5, -2.0
    )


def test_a_snapshot_is_two_bytes() -> None:
    packet = encode(ffi.new("wire_message_t *", {"type": lib.WIRE_SNAPSHOT}))
    assert packet == bytes([lib.WIRE_VERSION, lib.WIRE_SNAPSHOT])
    assert decode(packet)[0] == lib.WIRE_OK


@given(u8)
def test_a_message_of_no_type_is_not_encoded(kind: int) -> None:
    packet = encode(ffi.new("wire_message_t *", {"type": kind}))
    assert bool(packet) == (kind in TYPES)


@given(messages, st.integers(0, 60))
def test_another_length_is_refused(sent: tuple[int, dict[str, Any]], size: int) -> None:
    packet = encode(make(*sent))
    other = packet[:size].ljust(size, b"\0")
    status, message = decode(other)
    if size == len(packet):
        assert status == lib.WIRE_OK
        return
    if sent[0] == lib.WIRE_PATH and size < 6:
        assert status != lib.WIRE_OK
        return
    assert status == (lib.WIRE_SHORT if size < len(packet) else lib.WIRE_LONG)
    assert message.type == 0


@given(st.binary(max_size=64))
def test_garbage_is_either_refused_or_a_packet(packet: bytes) -> None:
    status, message = decode(packet)
    if status == lib.WIRE_OK:
        assert message.type in TYPES
        assert message.body.path.count <= lib.WIRE_PATH_POINTS or message.type != lib.WIRE_PATH
        assert len(encode(message)) == len(packet)


@given(st.sampled_from(sorted(TYPES)), u8, st.binary(max_size=30))
def test_only_this_version_is_understood(kind: int, version: int, rest: bytes) -> None:
    packet = (bytes([version, kind]) + rest)[: lib.WIRE_PACKET_BYTES]
    refused = decode(packet)[0] == lib.WIRE_BAD_VERSION
    assert refused == (version != lib.WIRE_VERSION)


@given(u8.filter(lambda kind: kind not in TYPES), st.binary(max_size=28))
def test_an_unknown_type_is_named(kind: int, rest: bytes) -> None:
    assert decode(bytes([lib.WIRE_VERSION, kind]) + rest)[0] == lib.WIRE_BAD_TYPE


@pytest.mark.parametrize("size", [6, 30, 806])
def test_a_path_that_claims_too_many_points_is_refused(size: int) -> None:
    packet = bytes([lib.WIRE_VERSION, lib.WIRE_PATH, 0, 0, 200, 200]).ljust(size, b"\0")
    assert decode(packet)[0] != lib.WIRE_OK


@pytest.mark.parametrize("far_m", [33.0, 1e9, float("inf")])
def test_way_points_beyond_the_range_stop_at_its_end(far_m: float) -> None:
    points = [{"x": far_m, "y": -far_m}]
    fields = {"revision": 1, "first": 0, "total": 1, "count": 1, "points_m": points}
    _, message = decode(encode(make(lib.WIRE_PATH, fields)))
    assert plain(message.body.path.points_m[0]) == pytest.approx({"x": 32.767, "y": -32.767})
