# SPDX-License-Identifier: GPL-3.0-or-later
"""Who moves about just now: echoes where the map knows nothing but free space, as the drone judges
them (grid_classify_echo)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ground.core import GRID_SIDE_CELLS, CellState, MissionState, Source, ffi, lib
from ground.coregrid import lay_out
from ground.map.groundmap import GroundMap
from ground.model import Odometry, Point, Pose, Ranges
from ground.station.picture import Picture

REACH_CELLS = 5  # with a wall so near, an echo is no surprise
LASTING_S = 10.0  # what came where it was free, and stays for longer, is no person
STEADY_RPS = 0.4  # turning faster, the ranges' age puts echoes in wrong places
STEADY_RAD = 0.25  # the same of roll and pitch


class People:
    """Looks at each new set of ranges. Owned by one loop."""

    def __init__(self) -> None:
        self._states: NDArray[np.uint8] = np.zeros((GRID_SIDE_CELLS, GRID_SIDE_CELLS), np.uint8)
        self._came_s = np.full(self._states.shape, -math.inf)
        self._grid = ffi.new("grid_t *")
        self._drawn: tuple[int, int | None] | None = None
        self._looked_ms = -1

    def look(self, picture: Picture, now_s: float) -> tuple[Point, ...]:
        """Where somebody was seen since the last call. now_s: any clock that runs on."""
        self._take_map(picture.map, now_s)
        ranges, telemetry = picture.ranges, picture.telemetry
        if ranges is None or telemetry is None or ranges.drone_ms == self._looked_ms:
            return ()
        self._looked_ms = ranges.drone_ms
        if not _believed(picture) or not _steady(picture.odometry):
            return ()
        self._lay_out(picture.map, now_s)
        ends = _ends(telemetry.pose, ranges)
        return tuple(end for end in ends if self._is_strange(end))

    def _take_map(self, now: GroundMap, now_s: float) -> None:
        """Note what came where it was free."""
        version = (now.revision, now.epoch)
        if version == self._drawn:
            return
        self._drawn = version
        occupied = now.states == CellState.OCCUPIED
        self._came_s[occupied & (self._states == CellState.FREE)] = now_s
        self._came_s[~occupied] = -math.inf
        self._states = now.states.copy()

    def _lay_out(self, now: GroundMap, now_s: float) -> None:
        young = self._came_s > now_s - LASTING_S
        lasting = np.where(young, np.uint8(CellState.FREE), self._states)
        lay_out(self._grid, lasting, now.origin, now.cell_m)

    def _is_strange(self, end: Point) -> bool:
        place = ffi.new("vec2_t *", (end.x_m, end.y_m))[0]
        return bool(lib.grid_classify_echo(self._grid, place, REACH_CELLS) == lib.GRID_ECHO_STRANGE)


def _believed(picture: Picture) -> bool:
    """The drone knows well enough where it is in its map."""
    lost = picture.state is MissionState.RELOCALISE
    return picture.state.airborne and not lost and picture.source is not Source.ODOMETRY


def _steady(odometry: Odometry | None) -> bool:
    if odometry is None:
        return True
    tilt_rad = max(abs(odometry.roll_rad), abs(odometry.pitch_rad))
    return abs(odometry.yaw_rate_rps) < STEADY_RPS and tilt_rad < STEADY_RAD


def _ends(pose: Pose, ranges: Ranges) -> list[Point]:
    """Where the level beams ended."""
    cfg = lib.scan_config_default()
    measured = {
        lib.SCAN_FRONT: ranges.front_m,
        lib.SCAN_BACK: ranges.back_m,
        lib.SCAN_LEFT: ranges.left_m,
        lib.SCAN_RIGHT: ranges.right_m,
    }
    ends = []
    for beam, range_m in measured.items():
        if range_m is None or not cfg.min_range_m <= range_m <= cfg.max_range_m:
            continue
        way = lib.geometry_sincos(pose.yaw_rad + lib.scan_bearing_rad(beam))
        reach_m = range_m + cfg.offset_m[beam]
        ends.append(Point(pose.x_m + reach_m * way.cos, pose.y_m + reach_m * way.sin))
    return ends
