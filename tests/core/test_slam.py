# SPDX-License-Identifier: GPL-3.0-or-later
"""SLAM as a whole: flights of minutes through random rooms, and what it reports when it fails."""

import math
from functools import cache

import numpy as np
import pytest

from ground.core import CData, ffi, lib
from tests.bench.slam.drive import Driven, drive
from tests.bench.slam.flights import Flight, make_flight
from tests.bench.slam.scores import Score, errors, score

SEEDS = (30, 31, 32)  # a room with furniture, two rooms, a corridor that closes


@cache
def flown(seed: int, profile: str) -> tuple[Flight, Driven, Score]:
    flight = make_flight(seed, profile)
    made = drive(flight.odometry, flight.ranges_m, flight.centre_m, flight.cell_m)
    return flight, made, score(flight, made)


@pytest.mark.parametrize("seed", SEEDS)
def test_drift_is_corrected(seed: int) -> None:
    _, _, judged = flown(seed, "real")
    assert judged.ratio > 1.5
    assert judged.slam.aligned_m < 0.15
    assert judged.map_m < 0.15


@pytest.mark.parametrize("seed", SEEDS)
def test_a_gyro_that_turns_half_a_degree_a_second_is_found_out(seed: int) -> None:
    flight, made, judged = flown(seed, "hard")
    turned_rad = flight.odometry[-1, 2] - flight.truth[-1, 2]
    true_rps = turned_rad / (0.02 * len(flight.truth))
    assert judged.ratio > 4.0
    assert made.bias_rps[-1] == pytest.approx(true_rps, rel=0.3, abs=math.radians(0.03))


@pytest.mark.parametrize("seed", SEEDS)
def test_good_odometry_is_left_alone(seed: int) -> None:
    _, made, judged = flown(seed, "perfect")
    assert judged.slam.aligned_m < 0.06
    assert abs(made.scale[-1]) < 0.02


def test_the_last_pose_is_known_as_well_as_the_others() -> None:
    """No pose is judged with hindsight: errors do not grow towards the end."""
    flight, made, _ = flown(30, "real")
    half = len(flight.truth) // 2
    early = errors(flight.truth[:half], made.poses[:half])
    late = errors(flight.truth[half:], made.poses[half:])
    assert late.aligned_m < early.aligned_m + 0.05


def test_it_knows_how_far_off_it_may_be() -> None:
    """Errors in the start frame are nearly always within two of its standard deviations."""
    assert np.mean([flown(seed, "real")[2].within_2_sd for seed in SEEDS]) > 0.85


def test_the_deviation_is_no_larger_than_needed() -> None:
    _, made, judged = flown(30, "real")
    assert made.sd_m.mean() < 4.0 * judged.slam.raw_m
    assert made.sd_m[0] < 0.06


def scanning(ticks: int, slam: CData, grid: CData, x_m: float = 0.0) -> float:
    """Fly along x between two walls, open at both ends, a set every fifth tick; the last x."""
    frame = ffi.new("scan_frame_t *")
    taken = ffi.new("scan_frame_t *")
    pose = ffi.new("pose2_t *")
    for tick in range(ticks):
        x_m += 0.008
        lib.slam_predict(slam, (x_m, 0.0, 0.0), 0.02)
        if tick % 5 == 0:
            frame.time_ms = 100_000 + round(x_m * 2500)
            frame.pose = (x_m, 0.0, 0.0)
            frame.hit = 1 << lib.SCAN_LEFT | 1 << lib.SCAN_RIGHT
            frame.range_m = [0.0, 0.0, 1.0, 1.2]
            lib.slam_update(slam, frame)
        elif not lib.slam_work(slam, grid) and lib.slam_take(slam, taken, pose):
            lib.grid_insert(grid, taken, pose[0])
    return x_m


def started() -> tuple[CData, CData]:
    slam, grid = ffi.new("slam_t *"), ffi.new("grid_t *")
    config = ffi.new("slam_config_t *", lib.slam_config_default())
    lib.slam_init(slam, config, True, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    lib.grid_init(grid, ffi.new("grid_config_t *", lib.grid_config_default()), (0.0, 0.0), 0.05)
    return slam, grid


def test_a_filter_that_broke_down_says_so_and_begins_anew() -> None:
    slam, grid = started()
    x_m = scanning(300, slam, grid)
    assert slam.confidence > 30
    assert max(slam.walls.found) > 0
    slam.filter.covariance = [math.nan] * lib.SLAM_PAIRS
    said = set()
    for _ in range(20):
        x_m = scanning(5, slam, grid, x_m)
        said.add(slam.confidence)
    assert 0 in said
    assert list(slam.walls.found) == [0, 0], "their directions would count as known exactly"
    scanning(200, slam, grid, x_m)
    assert slam.confidence > 20
    assert np.isfinite(list(slam.filter.covariance)).all()
    assert abs(lib.slam_pose(slam).y_m) < 0.05


def test_confidence_falls_where_nothing_answers() -> None:
    slam, grid = started()
    scanning(200, slam, grid)
    before = slam.confidence
    frame = ffi.new("scan_frame_t *")
    for step in range(200):
        x_m = 1.6 + 0.05 * step
        lib.slam_predict(slam, (x_m, 0.0, 0.0), 0.1)
        frame.time_ms, frame.pose, frame.hit = 200_000 + 100 * step, (x_m, 0.0, 0.0), 0
        lib.slam_update(slam, frame)
        while lib.slam_work(slam, grid):
            pass
        while lib.slam_take(slam, ffi.new("scan_frame_t *"), ffi.new("pose2_t *")):
            pass
        lib.slam_work(slam, grid)
    assert slam.confidence < 0.5 * before


def test_without_slam_odometry_passes_through() -> None:
    slam, grid = started()
    slam.enabled = False
    x_m = scanning(300, slam, grid)
    assert lib.slam_pose(slam).x_m == pytest.approx(x_m, abs=1e-4)
    assert lib.slam_pose(slam).y_m == 0.0
