# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts what the drone says into foxglove.* messages, so that Foxglove shows a recording.

Frames: `map`, `odometry` (the firmware's estimate, which drifts) and `drone`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Grid_pb2 import Grid
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame

from ground.core import CellState
from ground.map.groundmap import GroundMap
from ground.model import (
    Console,
    Event,
    Hello,
    Incoming,
    LinkChange,
    MapPacket,
    Odometry,
    Point,
    Pose,
    Ranges,
    RoutePiece,
    Telemetry,
)
from ground.record.writer import RecordFile
from ground.station.picture import Picture
from ground.words import event_words

MAP_EVERY_NS = 1_000_000_000
_SHADES = np.zeros(len(CellState), np.uint8)
_SHADES[CellState.UNKNOWN], _SHADES[CellState.FREE], _SHADES[CellState.OCCUPIED] = 128, 255, 0


class FoxgloveView:
    """Writes views into the recording: /view/pose, frames, path, grid, scan, log, odometry."""

    def __init__(self, file: RecordFile) -> None:
        self._file = file
        self._picture = Picture()
        self._grid: tuple[int, int] = (-1, 0)  # revision and time [ns] of the last grid written

    def take(self, message: Incoming, now_ns: int) -> None:
        """Write the views that this message changes."""
        match message:
            case Telemetry():
                self._pose(message, now_ns)
            case Odometry():
                self._show("odometry", _pose_in_frame("odometry", message.pose, now_ns), now_ns)
            case Ranges():
                self._show("scan", _scan(message, now_ns), now_ns)
            case Hello() | MapPacket():
                self._picture.take(message, now_ns / 1e9)
                self._map(now_ns)
            case RoutePiece():
                before = self._picture.route
                self._picture.take(message, now_ns / 1e9)
                if self._picture.route != before:
                    self._show("path", _path(self._picture.route, now_ns), now_ns)
            case Event():
                self._log(event_words(message)[0], "drone", now_ns)
            case Console(text):
                self._log(text, "console", now_ns)
            case LinkChange(_, detail):
                self._log(detail, "link", now_ns)

    def _pose(self, telemetry: Telemetry, now_ns: int) -> None:
        pose = telemetry.pose
        self._show("pose", _pose_in_frame("map", pose, now_ns), now_ns)
        frame = FrameTransform(parent_frame_id="map", child_frame_id="drone")
        _stamp(frame, now_ns)
        _vector(frame.translation, pose)
        _turn(frame.rotation, pose.yaw_rad)
        self._show("frames", frame, now_ns)

    def end(self, now_ns: int) -> None:
        """Write the map as it is at the end."""
        self._map(now_ns, 0)

    def _map(self, now_ns: int, every_ns: int = MAP_EVERY_NS) -> None:
        grid, (revision, written_ns) = self._picture.map, self._grid
        if grid.revision != revision and now_ns - written_ns >= every_ns:
            self._grid = grid.revision, now_ns
            self._show("grid", _grid(grid, now_ns), now_ns)

    def _log(self, text: str, name: str, now_ns: int) -> None:
        line = Log(level=Log.Level.INFO, message=text, name=name)
        _stamp(line, now_ns)
        self._show("log", line, now_ns)

    def _show(self, name: str, message: Any, now_ns: int) -> None:  # noqa: ANN401
        self._file.show(f"/view/{name}", message, now_ns)


def _stamp(message: Any, now_ns: int) -> None:  # noqa: ANN401
    message.timestamp.FromNanoseconds(now_ns)


def _vector(vector: Any, pose: Pose) -> None:  # noqa: ANN401
    vector.x, vector.y, vector.z = pose.x_m, pose.y_m, pose.z_m


def _turn(quaternion: Any, yaw_rad: float) -> None:  # noqa: ANN401
    quaternion.z, quaternion.w = math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)


def _pose_in_frame(frame: str, pose: Pose, now_ns: int) -> PoseInFrame:
    message = PoseInFrame(frame_id=frame)
    _stamp(message, now_ns)
    _vector(message.pose.position, pose)
    _turn(message.pose.orientation, pose.yaw_rad)
    return message


def _path(route: Sequence[Point], now_ns: int) -> PosesInFrame:
    message = PosesInFrame(frame_id="map")
    _stamp(message, now_ns)
    for point in route:
        pose = message.poses.add()
        pose.position.x, pose.position.y, pose.orientation.w = point.x_m, point.y_m, 1.0
    return message


def _scan(ranges: Ranges, now_ns: int) -> LaserScan:
    """Make a scan of four beams, counter-clockwise: front, left, back, right."""
    beams = (ranges.front_m, ranges.left_m, ranges.back_m, ranges.right_m)
    message = LaserScan(frame_id="drone", start_angle=0.0, end_angle=1.5 * math.pi)
    _stamp(message, now_ns)
    message.pose.orientation.w = 1.0
    message.ranges.extend(math.inf if beam is None else beam for beam in beams)
    return message


def _grid(grid: GroundMap, now_ns: int) -> Grid:
    """Make a grid with one byte per cell: 0 occupied, 128 unknown, 255 free."""
    side = len(grid.states)
    message = Grid(frame_id="map", column_count=side, row_stride=side, cell_stride=1)
    _stamp(message, now_ns)
    message.pose.position.x, message.pose.position.y = grid.origin.x_m, grid.origin.y_m
    message.pose.orientation.w = 1.0
    message.cell_size.x = message.cell_size.y = grid.cell_m
    message.fields.add(name="free", offset=0, type=PackedElementField.NumericType.UINT8)
    message.data = _SHADES[grid.states].tobytes()
    return message
