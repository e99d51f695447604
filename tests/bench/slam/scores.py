# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of a flight's poses and map: absolute trajectory error by evo, distance to walls."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Final

import numpy as np
from evo.core.metrics import APE, PoseRelation, StatisticsType
from evo.core.trajectory import PoseTrajectory3D

from tests.bench.slam.drive import Driven, Method, drive
from tests.bench.slam.flights import Flight
from tests.bench.slam.rooms import Array, gap_m
from tests.bench.slam.routes import TICK_S

_EVERY_TICKS: Final = 5
"""Poses are judged ten times a second."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Absolute trajectory error: root mean square over a flight."""

    raw_m: float
    """As the frames stand: they agree at the start."""
    aligned_m: float
    """After the rigid motion that fits best."""


@dataclass(frozen=True, slots=True)
class Score:
    """One flight."""

    name: str
    kind: str
    slam: Errors
    odometry: Errors
    map_m: float
    """Mean distance of occupied cells to the nearest wall."""
    confidence: float
    """Of the last tick [%]."""
    within_2_sd: float
    """Share of the time that the true error along an axis is within two standard deviations."""

    @property
    def ratio(self) -> float:
        """How many times smaller the aligned error is than the odometry's."""
        return self.odometry.aligned_m / max(self.slam.aligned_m, 1e-6)


def trajectory(poses: Array) -> PoseTrajectory3D:
    """Poses (x, y, yaw) per tick as an evo trajectory."""
    kept = poses[::_EVERY_TICKS]
    zero = np.zeros(len(kept))
    half = 0.5 * kept[:, 2]
    return PoseTrajectory3D(
        positions_xyz=np.column_stack([kept[:, 0], kept[:, 1], zero]),
        orientations_quat_wxyz=np.column_stack([np.cos(half), zero, zero, np.sin(half)]),
        timestamps=np.arange(len(kept)) * (_EVERY_TICKS * TICK_S),
    )


def errors(truth: Array, estimate: Array) -> Errors:
    """Translation part, in metres."""

    def rms(reference: PoseTrajectory3D, judged: PoseTrajectory3D) -> float:
        metric = APE(PoseRelation.translation_part)
        metric.process_data((reference, judged))
        return float(metric.get_statistic(StatisticsType.rmse))

    reference, judged = trajectory(truth), trajectory(estimate)
    aligned = copy.deepcopy(judged)
    aligned.align(reference, correct_scale=False)
    return Errors(rms(reference, judged), rms(reference, aligned))


def honesty(truth: Array, driven: Driven) -> float:
    """Share of errors within what the pose's own deviation predicts: 0.95 if it is right."""
    off_m = np.abs(driven.poses[::_EVERY_TICKS, :2] - truth[::_EVERY_TICKS, :2])
    return float((off_m < 2.0 * driven.sd_m[::_EVERY_TICKS, None]).mean())


def score(flight: Flight, driven: Driven) -> Score:
    """Score the core's poses and map."""
    occupied = driven.occupied
    return Score(
        flight.name,
        flight.kind,
        errors(flight.truth, driven.poses),
        errors(flight.truth, flight.odometry),
        float(gap_m(flight.walls, occupied).mean()) if len(occupied) else float("nan"),
        float(driven.confidence[-1]),
        honesty(flight.truth, driven),
    )


def fly(flight: Flight, method: Method = "slam") -> Score:
    """Run the core, or its competitor, on the flight and score it."""
    made = drive(flight.odometry, flight.ranges_m, flight.centre_m, flight.cell_m, method=method)
    return score(flight, made)
