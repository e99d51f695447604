# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports a recording: the final map, and the poses of the flight."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from ground.checks import write_report
from ground.map.files import save_map, save_table
from ground.model import Odometry, Telemetry
from ground.progress import waiting
from ground.record.reader import Heard, read_session
from ground.station.picture import Picture

POSE_COLUMNS = (
    "time_s", "x_m", "y_m", "z_m", "yaw_rad",
    "odometry_x_m", "odometry_y_m", "odometry_yaw_rad",
)  # fmt: skip
"""Drone time, the pose in the map, and the firmware's own estimate at that time."""


def export_recording(
    recording: Path, file: Path, poses: Path | None, json_file: Path | None, out: Console
) -> bool:
    """Write the map and, if wanted, a table with a line per pose."""
    picture = Picture()
    rows: list[tuple[float, ...]] = []
    with waiting(out, f"reading {recording}"):
        session = read_session(recording)
    for word in session:
        if isinstance(word, Heard):
            picture.take(word.message, word.time_s)
            if isinstance(word.message, Telemetry):
                rows.append(_row(word.message, picture.odometry))
    save_map(picture.map, file)
    out.print(f"{file}: {picture.map.known_cells} known cells")
    if poses:
        save_table(poses, POSE_COLUMNS, rows)
        out.print(f"{poses}: {len(rows)} poses")
    if json_file:
        figures = {"file": str(file), "known_cells": picture.map.known_cells, "poses": len(rows)}
        write_report(json_file, figures, [])
    return True


def _row(telemetry: Telemetry, odometry: Odometry | None) -> tuple[float, ...]:
    pose = telemetry.pose
    row = (telemetry.drone_ms / 1000, pose.x_m, pose.y_m, pose.z_m, pose.yaw_rad)
    if odometry is None:
        return (*row, *(float("nan"),) * 3)
    return (*row, odometry.pose.x_m, odometry.pose.y_m, odometry.pose.yaw_rad)
