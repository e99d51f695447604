# SPDX-License-Identifier: GPL-3.0-or-later
"""Bytes of the app channel and of the map stream to words and back, through the C encoder."""

from __future__ import annotations

import math

from ground.core import (
    MAP_BYTES,
    MAP_POINTS,
    PACKET_BYTES,
    PATH_POINTS,
    Capability,
    CData,
    EventCode,
    MissionReason,
    MissionState,
    WireStatus,
    WireType,
    ffi,
    lib,
)
from ground.model import (
    Ack,
    AppMessage,
    AppRequest,
    Beat,
    Command,
    Event,
    Heartbeat,
    Hello,
    HelloRequest,
    MapPiece,
    Point,
    RoutePiece,
    SnapshotRequest,
    Waypoints,
)

SEQUENCES = 1 << 16


def encode_request(request: AppRequest) -> bytes:
    """The packet that says this to the drone."""
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
        case Heartbeat(sequence):
            message.type = WireType.HEARTBEAT
            message.body.heartbeat.sequence = sequence
        case HelloRequest():
            message.type = WireType.HELLO
            message.body.hello.request = 1
        case SnapshotRequest():
            message.type = WireType.SNAPSHOT
        case MapPiece():
            message.type = WireType.MAP
            message.body.map = list(encode_map_piece(request))
    return pack(message)


def _put_waypoints(body: CData, request: Waypoints) -> None:
    body.sequence, body.list = request.sequence, request.list
    body.first, body.total, body.count = request.first, request.total, len(request.points)
    for i, point in enumerate(request.points):
        body.points_mm[i] = [round(1000 * point.x_m), round(1000 * point.y_m)]


def pack(message: CData) -> bytes:
    """Bytes of a wire_message_t; empty if its type is unknown."""
    packet = ffi.new("uint8_t[]", PACKET_BYTES)
    length = lib.wire_encode(message, packet)
    return bytes(ffi.buffer(packet, length))


def unpack(packet: bytes) -> tuple[WireStatus, CData]:
    """Status and wire_message_t of some bytes; the message means something only if OK."""
    message = ffi.new("wire_message_t *")
    status = lib.wire_decode(ffi.from_buffer("uint8_t[]", packet), len(packet), message)
    return WireStatus(status), message


def decode_message(packet: bytes) -> AppMessage | None:
    """What the drone says, or None if this is nothing that a drone of our version says."""
    status, message = unpack(packet)
    if status is not WireStatus.OK:
        return None
    try:
        return _to_model(message)
    except ValueError:  # an enumerator that this build does not know
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
            return Beat(beat.sequence, beat.time_ms, MissionState(beat.state))
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
    """Bytes of one tile, with as many of its points as there is room for."""
    points = piece.points[:MAP_POINTS]
    c = ffi.new("wire_map_piece_t *", (piece.tile, piece.epoch, list(piece.states), len(points)))
    for i, (cell, eighths) in enumerate(points):
        c.point_cell[i], c.point_eighths[i] = cell, eighths
    data = ffi.new("uint8_t[]", MAP_BYTES)
    lib.wire_map_encode(c, data)
    return bytes(ffi.buffer(data))


def decode_map_piece(data: bytes) -> MapPiece | None:
    """One tile of the map stream, or None if its check does not match."""
    if len(data) != MAP_BYTES:
        return None
    piece = ffi.new("wire_map_piece_t *")
    if not lib.wire_map_decode(ffi.from_buffer("uint8_t[]", data), piece):
        return None
    points = tuple(
        (piece.point_cell[i], piece.point_eighths[i])
        for i in range(min(piece.point_count, MAP_POINTS))
    )
    return MapPiece(piece.tile, piece.epoch, bytes(ffi.buffer(piece.states)), points)
