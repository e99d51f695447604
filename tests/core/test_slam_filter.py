# SPDX-License-Identifier: GPL-3.0-or-later
"""The Kalman filter of SLAM against the same algebra written with NumPy's matrices."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ground.core import CData, ffi, lib

N: int = lib.SLAM_STATES
YAW, BIAS, SCALE, DRIFT, DIRECTION = 2, 3, 4, 5, 7
Matrix = NDArray[np.float64]


def noise() -> CData:
    return ffi.new("slam_noise_t *", lib.slam_config_default().noise)


def fresh(x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0) -> CData:
    filter_ = ffi.new("slam_filter_t *")
    lib.slam_filter_init(filter_, noise(), (x_m, y_m, yaw_rad))
    return filter_


def covariance(filter_: CData) -> Matrix:
    full = np.zeros((N, N))
    rows, columns = np.tril_indices(N)
    full[rows, columns] = list(filter_.covariance)
    return full + np.tril(full, -1).T


def any_filter(seed: int) -> CData:
    """A filter with correlated errors of the size that flights have."""
    rng = np.random.default_rng(seed)
    filter_ = fresh(*rng.uniform(-2.0, 2.0, 3))
    size = np.array([0.05, 0.05, 0.02, 1e-3, 0.03, 0.01, 0.01, 0.02, 0.02])
    root = rng.normal(size=(N, N)) * size[:, None] * 0.5 + np.diag(size)
    filter_.covariance = list((root @ root.T)[np.tril_indices(N)])
    filter_.direction_rad = list(rng.uniform(-0.5, 0.5, lib.SLAM_DIRECTIONS))
    return filter_


@pytest.mark.parametrize("seed", range(8))
def test_uncertainty_is_carried_along_a_motion(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    filter_ = any_filter(seed)
    before = covariance(filter_)
    moved, turned, elapsed = rng.uniform(-0.5, 0.5, 2), rng.uniform(-1, 1), rng.uniform(0.2, 2)
    lib.slam_filter_grow(filter_, noise(), tuple(moved), turned, elapsed)
    c, s = math.cos(filter_.pose.yaw_rad), math.sin(filter_.pose.yaw_rad)
    f = np.eye(N)
    f[0, YAW], f[1, YAW] = -moved[1], moved[0]
    f[:2, BIAS] = 0.5 * elapsed * np.array([moved[1], -moved[0]])
    f[YAW, BIAS] = -elapsed
    f[:2, SCALE] = -moved
    f[:2, DRIFT : DRIFT + 2] = -elapsed * np.array([[c, -s], [s, c]])
    f[DRIFT, DRIFT] = f[DRIFT + 1, DRIFT + 1] = 1.0 - elapsed / 13.0
    grown = covariance(filter_) - f @ before @ f.T
    assert grown - np.diag(np.diag(grown)) == pytest.approx(0.0, abs=2e-8)
    assert (np.diag(grown)[:DIRECTION] > 0.0).all()
    assert np.diag(grown)[DIRECTION:] == pytest.approx(0.0, abs=2e-8)


@pytest.mark.parametrize("seed", range(8))
def test_a_fit_of_the_pose_corrects_all_states(seed: int) -> None:
    """It equals a Kalman update with the pose as measurement."""
    rng = np.random.default_rng(200 + seed)
    filter_ = any_filter(seed)
    before = covariance(filter_)
    h = np.eye(3, N)
    r = np.diag(rng.uniform(1e-4, 1e-2, 3))
    gain = before @ h.T @ np.linalg.inv(h @ before @ h.T + r)
    seen = rng.normal(size=3) * 0.02
    prior, posterior = ffi.new("float[3][3]"), ffi.new("float[3][3]")
    assert lib.slam_filter_information(filter_, prior)
    left = np.linalg.inv(np.linalg.inv(before[:3, :3]) + np.linalg.inv(r))
    for a in range(3):
        posterior[a] = list(left[a])
    off = gain[:3] @ seen
    pose = filter_.pose
    was = (pose.x_m, pose.y_m, filter_.bias_rps, filter_.scale, filter_.direction_rad[1])
    lib.slam_filter_correct(filter_, prior, list(off), posterior, (pose.x_m, pose.y_m))
    now = (pose.x_m, pose.y_m, filter_.bias_rps, filter_.scale, filter_.direction_rad[1])
    expected = gain @ seen
    assert np.subtract(now, was) == pytest.approx(expected[[0, 1, 3, 4, 8]], abs=2e-4)
    after = before - gain @ h @ before
    assert covariance(filter_) == pytest.approx(after, abs=2e-5)


@pytest.mark.parametrize("seed", range(8))
def test_a_known_direction_turns_as_a_kalman_update(seed: int) -> None:
    rng = np.random.default_rng(300 + seed)
    filter_ = any_filter(seed)
    before = covariance(filter_)
    sd, slope = 0.02, rng.uniform(-2, 2)
    off = rng.uniform(-0.01, 0.01)
    angle = filter_.direction_rad[0] - off
    relative = angle - filter_.pose.yaw_rad
    h = np.zeros(N)
    h[YAW], h[DIRECTION] = 1.0, -1.0
    h[DRIFT], h[DRIFT + 1] = slope * math.sin(relative), -slope * math.cos(relative)
    spread = ffi.new("float *")
    bearing = ffi.new("slam_bearing_t *", (angle, sd, slope))
    found = lib.slam_filter_off_rad(filter_, bearing, 0, spread)
    assert found == pytest.approx(off, abs=1e-5)
    assert spread[0] ** 2 == pytest.approx(h @ before @ h + sd**2, rel=1e-3)
    yaw_before, bias_before = filter_.pose.yaw_rad, filter_.bias_rps
    lib.slam_filter_turn(filter_, bearing, 0)
    weight = 6.3 / (6.3 + (off / spread[0]) ** 2)
    gain = before @ h / (h @ before @ h + sd**2 / weight**2)
    turned = math.remainder(filter_.pose.yaw_rad - yaw_before, math.tau)
    assert turned == pytest.approx(gain[YAW] * off, abs=1e-5)
    assert filter_.bias_rps - bias_before == pytest.approx(gain[BIAS] * off, abs=1e-6)
    assert covariance(filter_) == pytest.approx(before - np.outer(gain, before @ h), abs=1e-6)


def test_a_wall_seen_again_tells_the_gyro_bias() -> None:
    """A wall is learned, the gyro drifts for a minute, the wall is seen again."""
    true_rps = math.radians(0.1)
    filter_ = fresh()
    first = ffi.new("slam_bearing_t *", (0.3, 0.005, 0.0))
    lib.slam_filter_learn(filter_, first, 0)
    for _ in range(60):
        for _ in range(50):
            lib.slam_filter_move(filter_, (0.0, 0.0, true_rps * 0.02), 0.02)
        lib.slam_filter_grow(filter_, noise(), (0.0, 0.0), 0.0, 1.0)
    again = ffi.new("slam_bearing_t *", (0.3 + filter_.pose.yaw_rad, 0.005, 0.0))
    lib.slam_filter_turn(filter_, again, 0)
    assert filter_.pose.yaw_rad == pytest.approx(0.0, abs=math.radians(0.6))
    assert filter_.bias_rps == pytest.approx(true_rps, abs=math.radians(0.02))


def test_odometry_that_does_not_drift_is_learned_to_be_calm() -> None:
    calm, rough = fresh(), fresh()
    rng = np.random.default_rng(1)
    for filter_, drift in ((calm, 0.0), (rough, 0.02)):
        for _ in range(100):
            filter_.drift_mps = tuple(rng.normal(0.0, drift, 2) if drift else (0.0, 0.0))
            rows = np.diag([1e-4, 1e-4, 1e-4, 1e-8, 1e-4, 1e-6, 1e-6, 0.0, 0.0])
            filter_.covariance = list(rows[np.tril_indices(N)])
            lib.slam_filter_grow(filter_, noise(), (0.2, 0.0), 0.0, 1.0)
    assert math.sqrt(calm.drift_m2ps2) < 0.004
    assert math.sqrt(rough.drift_m2ps2) > 0.012


def test_motion_is_corrected_by_what_is_known_of_its_errors() -> None:
    """Bias, scale and drift are what odometry reads too much."""
    known = ffi.new("slam_filter_t *")
    known.bias_rps, known.scale, known.drift_mps = 0.01, 0.05, (0.02, -0.01)
    step = ffi.new("pose2_t *", (0.1, 0.05, 0.2))[0]
    true = lib.slam_filter_move(known, step, 0.1)
    assert (true.x_m, true.y_m, true.yaw_rad) == pytest.approx((0.093, 0.0485, 0.199), abs=1e-6)
