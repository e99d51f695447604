# SPDX-License-Identifier: GPL-3.0-or-later
"""Encodes and decodes the app channel and the map stream, through the core's C encoder."""

from __future__ import annotations

import math

from ground.core import (
    MAP_BYTES,
    NO_POINT,
    PACKET_BYTES,
    PATH_POINTS,
    Capability,
    CData,
    EventCode,
    MissionReason,
    MissionState,
    RecordKind,
    WireStatus,
    WireType,
    ffi,
    lib,
)
from ground.model import (
    Ack,
    AppMessage,
    Beat,
    Event,
    Hello,
    History,
    MapPiece,
    Point,
    Record,
    RoutePiece,
)
from ground.requests import (
    AppRequest,
    Ask,
    AskTiles,
    Command,
    Heartbeat,
    HelloRequest,
    SnapshotRequest,
    Steer,
    Waypoints,
)

SEQUENCES = 1 << 16
"""Period of the sequence numbers of commands, events, records and heartbeats."""


def encode_request(request: AppRequest) -> bytes:
    """Encode a request as a packet for the drone."""
    message = ffi.new("wire_message_t *")
    match request:
        case Command(sequence, cmd, goal):
            message.type = WireType.COMMAND
            message.body.command.sequence = sequence
            message.body.command.cmd = cmd
            message.body.command.goal_m = (goal.x_m, goal.y_m)
        case Waypoints():
            message.type = WireType.WAYPOINTS
            _put_waypoints(message.body.waypoints, request)
        case Steer(sequence, stick):
            message.type = WireType.STEER
            message.body.steer.sequence = sequence
            message.body.steer.velocity_mps = (stick.ahead_mps, stick.left_mps)
            message.body.steer.yaw_rate_rps = stick.yaw_rate_rps
            message.body.steer.climb_mps = stick.climb_mps
        case Heartbeat(sequence, drone_ms):
            message.type = WireType.HEARTBEAT
            message.body.heartbeat.sequence = sequence
            message.body.heartbeat.time_ms = drone_ms % (1 << 32)
        case HelloRequest():
            message.type = WireType.HELLO
            message.body.hello.request = 1
        case SnapshotRequest():
            message.type = WireType.SNAPSHOT
        case MapPiece():
            message.type = WireType.MAP
            message.body.map = list(encode_map_piece(request))
        case Ask(what, first, count):
            message.type = WireType.ASK
            message.body.ask = (what, first, count)
        case AskTiles(tiles):
            message.type = WireType.TILES
            message.body.tiles = (len(tiles), list(tiles))
    return pack(message)


def _put_waypoints(body: CData, request: Waypoints) -> None:
    body.sequence, body.list = request.sequence, request.list
    body.first, body.total, body.count = request.first, request.total, len(request.points)
    for i, point in enumerate(request.points):
        body.points_mm[i] = [round(1000 * point.x_m), round(1000 * point.y_m)]


def pack(message: CData) -> bytes:
    """Encode a wire_message_t; empty if its type is unknown."""
    packet = ffi.new("uint8_t[]", PACKET_BYTES)
    length = lib.wire_encode(message, packet)
    return bytes(ffi.buffer(packet, length))


def unpack(packet: bytes) -> tuple[WireStatus, CData]:
    """Decode a packet; the wire_message_t is valid only if the status is OK."""
    message = ffi.new("wire_message_t *")
    status = lib.wire_decode(ffi.from_buffer("uint8_t[]", packet), len(packet), message)
    return WireStatus(status), message


def decode_message(packet: bytes) -> AppMessage | None:
    """Decode a packet from the drone; None if this version does not know it."""
    status, message = unpack(packet)
    if status is not WireStatus.OK:
        return None
    try:
        return _to_model(message)
    except ValueError:  # an enumerator that this version does not know
        return None


def _to_model(message: CData) -> AppMessage | None:
    body = message.body
    match WireType(message.type):
        case WireType.HELLO:
            return None if body.hello.request else _hello(body.hello)
        case WireType.ACK:
            return Ack(body.ack.sequence, body.ack.cmd, MissionReason(body.ack.reason))
        case WireType.PATH:
            return _route_piece(body.path)
        case WireType.EVENT:
            return _event(body.event)
        case WireType.HEARTBEAT:
            beat = body.heartbeat
            return Beat(
                beat.sequence,
                beat.time_ms,
                MissionState(beat.state),
                beat.path_revision,
                beat.path_total,
                beat.next_event,
                beat.next_record,
            )
        case WireType.HISTORY:
            history = body.history
            records = tuple(_record(history.records[i]) for i in range(history.count))
            return History(history.first, records)
        case _:
            return None


def _hello(hello: CData) -> Hello | None:
    origin = _point(hello.origin_m)
    if not hello.cell_mm or not (math.isfinite(origin.x_m) and math.isfinite(origin.y_m)):
        return None
    return Hello(
        capabilities=Capability(hello.capabilities),
        epoch=hello.epoch,
        cell_m=hello.cell_mm / 1000,
        side_cells=hello.side_cells,
        origin=origin,
    )


def _route_piece(path: CData) -> RoutePiece | None:
    if path.count > PATH_POINTS:
        return None
    points = tuple(_point(path.points_m[i]) for i in range(path.count))
    return RoutePiece(path.revision, path.first, path.total, points)


def _record(record: CData) -> Record:
    return Record(
        record.time_ms,
        RecordKind(record.kind),
        record.x_mm / 1000,
        record.y_mm / 1000,
        record.yaw_1e4_rad / 10_000,
    )


def _event(event: CData) -> Event:
    code = EventCode(event.code)
    if code is EventCode.STATE:
        MissionState(event.argument)
    elif code in (EventCode.REFUSED, EventCode.FAULT, EventCode.SKIPPED):
        MissionReason(event.argument)
    return Event(event.sequence, event.time_ms, code, event.argument, _point(event.place_m))


def _point(vector: CData) -> Point:
    return Point(vector.x, vector.y)


def encode_map_piece(piece: MapPiece) -> bytes:
    """Encode one tile, with as many of its points as fit."""
    eighths = bytearray([NO_POINT]) * len(piece.states)
    for cell, place in piece.points:
        eighths[cell] = place
    tile = ffi.new("wire_tile_t *", {"tile": piece.tile, "states": list(piece.states)})
    tile.eighths = list(eighths)
    wire = ffi.new("wire_map_t *")
    lib.wire_map_begin(wire, piece.tile, piece.epoch)
    lib.wire_map_add(wire, tile)
    lib.wire_map_end(wire)
    return bytes(ffi.buffer(wire.bytes))


def is_map_piece(data: bytes) -> bool:
    """Whether the checksum matches."""
    wire, epoch = ffi.new("wire_map_t *"), ffi.new("uint8_t *")
    return len(data) == MAP_BYTES and bool(
        lib.wire_map_open(wire, ffi.from_buffer("uint8_t[]", data), epoch)
    )


def decode_map_piece(data: bytes) -> list[MapPiece]:
    """The tiles of one packet of the map stream; none if its checksum does not match."""
    if len(data) != MAP_BYTES:
        return []
    wire, epoch, tile = (ffi.new(f"{kind} *") for kind in ("wire_map_t", "uint8_t", "wire_tile_t"))
    if not lib.wire_map_open(wire, ffi.from_buffer("uint8_t[]", data), epoch):
        return []
    tiles = []
    while lib.wire_map_read(wire, tile):
        eighths = bytes(ffi.buffer(tile.eighths))
        points = tuple((i, place) for i, place in enumerate(eighths) if place != NO_POINT)
        states = bytes(ffi.buffer(tile.states))
        tiles.append(MapPiece(tile.tile, epoch[0], states, points, bool(tile.whole)))
    return tiles
