# SPDX-License-Identifier: GPL-3.0-or-later
"""A recorded flight without ground truth: how sharply do beams unseen by SLAM draw the map?

The file holds `odometry` (N x 3: m, m, rad) and `tof_mm` (N x 4 x 8: front, back, left, right;
eight columns of 45/8 degrees, negative where invalid). The two middle columns stand for a beam of
the Multi-ranger; the other six of each sensor judge.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from tests.bench.slam.beams import BEARINGS_RAD, NONE_M
from tests.bench.slam.drive import TICK_MS, drive
from tests.bench.slam.rooms import Array

SAMPLE_HZ: Final = 14.7
_COLUMN_RAD: Final = np.radians(45.0 / 8.0)
_MIDDLE: Final = (3, 4)
_HELD_OUT: Final = (0, 1, 2, 5, 6, 7)
_SENSOR_OFFSET_M: Final = 0.02
_JUDGED_TO_M: Final = 2.0
_SAME_WALL_M: Final = 0.4
_CELL_M: Final = 0.05
_SCAN: Final = {"latency_ms": 0}
"""Ranges and odometry of a sample are of the same moment."""


@dataclass(frozen=True, slots=True)
class Crispness:
    """How well the held-out columns of a whole flight agree with each other."""

    n80_cells: int
    """As many cells of 5 cm hold 80 % of the points."""
    early_late_rms_m: float
    """From points of the last third to the nearest of the first third, where there is one."""


def held_out_points(poses: Array, tof_mm: Array) -> tuple[Array, Array]:
    """What the held-out columns saw, and in which sample."""
    points, samples = [], []
    for sensor, bearing in enumerate(BEARINGS_RAD):
        for column in _HELD_OUT:
            depth_m = tof_mm[:, sensor, column] / 1000.0  # along the sensor's axis
            aside_m = -depth_m * np.tan((column - 3.5) * _COLUMN_RAD)
            seen = (depth_m > 0.0) & (depth_m < _JUDGED_TO_M)
            angle = poses[seen, 2] + bearing
            c, s = np.cos(angle), np.sin(angle)
            ahead_m, left_m = depth_m[seen] + _SENSOR_OFFSET_M, aside_m[seen]
            x = poses[seen, 0] + c * ahead_m - s * left_m
            y = poses[seen, 1] + s * ahead_m + c * left_m
            points.append(np.column_stack([x, y]))
            samples.append(np.flatnonzero(seen))
    return np.concatenate(points), np.concatenate(samples)


def crispness(poses: Array, tof_mm: Array) -> Crispness:
    """Compute the crispness for poses of all samples."""
    points, samples = held_out_points(poses, tof_mm)
    cells = np.floor(points / _CELL_M).astype(int)
    counts = np.sort(np.unique(cells, axis=0, return_counts=True)[1])[::-1]
    n80 = int(np.searchsorted(counts.cumsum(), 0.8 * counts.sum())) + 1
    early = points[samples < len(poses) / 3]
    late = points[samples >= 2 * len(poses) / 3]
    gaps, _ = cKDTree(early).query(late, distance_upper_bound=_SAME_WALL_M)
    gaps = gaps[np.isfinite(gaps)]
    return Crispness(n80, float(np.sqrt((gaps**2).mean())))


def _beams(tof_mm: Array) -> Array:
    """Mean of the two middle columns where both are valid."""
    pair = tof_mm[:, :, _MIDDLE].astype(float)
    return np.where((pair > 0).all(axis=2), pair.mean(axis=2) / 1000.0, NONE_M)


def slam_poses(odometry: Array, tof_mm: Array) -> Array:
    """The core's pose of each sample, without hindsight, in the odometry frame."""
    count = len(odometry)
    at_s = np.arange(count) / SAMPLE_HZ
    ticks_s = np.arange(0.0, at_s[-1] + 1.0, TICK_MS / 1000.0)
    yaw = np.unwrap(odometry[:, 2])
    smooth = [np.interp(ticks_s, at_s, column) for column in (*odometry[:, :2].T, yaw)]
    start = odometry[0]
    c, s = np.cos(start[2]), np.sin(start[2])
    turn = np.array([[c, -s], [s, c]])
    local = np.column_stack([(np.stack(smooth[:2], axis=1) - start[:2]) @ turn, smooth[2] - yaw[0]])
    latest = np.searchsorted(at_s, ticks_s + 1e-9, side="right") - 1
    low, high = local[:, :2].min(axis=0) - 2.5, local[:, :2].max(axis=0) + 2.5
    middle = 0.5 * (low + high)
    cell_m = max(_CELL_M, float((high - low).max()) / 128.0)
    made = drive(
        local, _beams(tof_mm)[latest], (float(middle[0]), float(middle[1])), cell_m, scan=_SCAN
    )
    kept = made.poses[np.searchsorted(ticks_s, at_s - 1e-9)]
    return np.column_stack([kept[:, :2] @ turn.T + start[:2], kept[:, 2] + start[2]])


def judge(path: Path) -> dict[str, Crispness]:
    """Judge the held-out columns with odometry alone and with the core."""
    with np.load(path) as recorded:
        odometry = recorded["odometry"].astype(float)
        tof_mm = recorded["tof_mm"].astype(float)
    return {
        "odometry": crispness(odometry, tof_mm),
        "slam": crispness(slam_poses(odometry, tof_mm), tof_mm),
    }
