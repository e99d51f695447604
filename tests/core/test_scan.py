# SPDX-License-Identifier: GPL-3.0-or-later
"""Ranges are paired with the pose at which they were measured, and each set is used once."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import ffi, lib

TICK_MS = 20
NONE_M = -1.0
LEVEL = (0.0, 0.0)


class Scanner:
    """A scan_t fed tick by tick; keeps the last frame."""

    def __init__(self, **changes: float | list[float]) -> None:
        self.cfg = ffi.new("scan_config_t *", lib.scan_config_default())
        self.cfg.offset_m = [0.0] * lib.SCAN_RANGES
        for name, value in changes.items():
            setattr(self.cfg, name, value)
        self.scan = ffi.new("scan_t *")
        lib.scan_init(self.scan, self.cfg)
        self.frame = ffi.new("scan_frame_t *")

    def step(
        self,
        time_ms: int,
        ranges_m: list[float],
        x_m: float = 0.0,
        yaw_rad: float = 0.0,
        tilt_rad: tuple[float, float] = LEVEL,
        height_m: float = 0.5,
    ) -> bool:
        pose = {"x_m": x_m, "y_m": 0.0, "yaw_rad": yaw_rad}
        roll_rad, pitch_rad = tilt_rad
        odometry = ffi.new("scan_odometry_t *", (time_ms, pose, height_m, roll_rad, pitch_rad))
        return bool(lib.scan_step(self.scan, odometry, ranges_m, self.frame))


def ranges(
    front: float = 1.0, back: float = 1.0, left: float = 1.0, right: float = 1.0
) -> list[float]:
    return [front, back, left, right, NONE_M]


def beams(mask: int) -> set[int]:
    return {beam for beam in range(lib.SCAN_BEAMS) if mask >> beam & 1}


def test_on_all_four_sides_a_wall_is_as_far_from_the_middle_of_the_body() -> None:
    offset_m = list(lib.scan_config_default().offset_m)
    scanner = Scanner(offset_m=offset_m)
    assert scanner.step(0, ranges())
    assert list(scanner.frame.range_m) == pytest.approx([1.0 + offset_m[0]] * lib.SCAN_BEAMS)
    assert 0.01 < offset_m[0] < 0.03  # half a Crazyflie's deck


@given(st.floats(-2.0, 2.0), st.integers(5, 11), st.integers(0, 180))
def test_a_set_gets_the_pose_of_its_measurement(
    rate_rps: float, ticks: int, latency_ms: int
) -> None:
    scanner = Scanner(latency_ms=latency_ms)
    still = ranges(front=2.0)
    scanner.step(0, still)
    for tick in range(1, ticks):
        scanner.step(
            tick * TICK_MS, still, x_m=tick * 0.02, yaw_rad=tick * TICK_MS * rate_rps / 1000
        )
    now_ms = ticks * TICK_MS
    new = scanner.step(now_ms, ranges(front=1.9), ticks * 0.02, now_ms * rate_rps / 1000)
    measured_ms = max(now_ms - latency_ms, 0)
    assert new
    assert scanner.frame.pose.yaw_rad == pytest.approx(measured_ms * rate_rps / 1000, abs=1e-4)
    assert scanner.frame.pose.x_m == pytest.approx(measured_ms * 0.001, abs=1e-4)


def test_the_pose_is_interpolated_across_the_half_turn() -> None:
    scanner = Scanner(latency_ms=10)
    scanner.step(0, ranges(), yaw_rad=math.pi - 0.1)
    scanner.step(20, ranges(front=1.5), yaw_rad=-math.pi + 0.1)
    assert abs(scanner.frame.pose.yaw_rad) == pytest.approx(math.pi, abs=1e-5)


def test_a_set_is_used_once() -> None:
    scanner = Scanner()
    fresh = [scanner.step(t * TICK_MS, ranges(front=1.0 + t // 5 * 0.1)) for t in range(20)]
    assert [t for t, new in enumerate(fresh) if new] == [0, 5, 10, 15]


def test_silence_on_all_sensors_counts_as_a_set_every_period() -> None:
    scanner = Scanner(period_ms=100)
    fresh = [scanner.step(t * TICK_MS, [NONE_M] * 5) for t in range(21)]
    assert [t for t, new in enumerate(fresh) if new] == [5, 10, 15, 20]
    assert scanner.frame.hit == 0
    assert beams(scanner.frame.clear) == set(range(lib.SCAN_BEAMS))


def test_ranges_that_never_change_grow_old() -> None:
    scanner = Scanner()
    for t in range(100):
        scanner.step(t * TICK_MS, ranges())
    assert lib.scan_age_ms(scanner.scan, 99 * TICK_MS) == 99 * TICK_MS


def test_an_echo_is_a_hit_and_no_echo_clears_only_a_little() -> None:
    scanner = Scanner()
    far_m = scanner.cfg.max_range_m + 0.5
    assert scanner.step(0, [0.5, NONE_M, far_m, math.nan, NONE_M])
    frame = scanner.frame
    assert beams(frame.hit) == {lib.SCAN_FRONT}
    assert beams(frame.clear) == {lib.SCAN_BACK, lib.SCAN_LEFT, lib.SCAN_RIGHT}
    assert frame.range_m[lib.SCAN_FRONT] == pytest.approx(0.5)
    for beam in beams(frame.clear):
        assert frame.range_m[beam] == pytest.approx(scanner.cfg.no_return_clear_m)


def test_an_echo_too_near_says_nothing() -> None:
    scanner = Scanner()
    scanner.step(0, ranges(left=scanner.cfg.min_range_m / 2))
    assert beams(scanner.frame.hit | scanner.frame.clear) == set(range(4)) - {lib.SCAN_LEFT}


def test_the_sensor_sits_away_from_the_centre() -> None:
    offset_m = [0.02, 0.03, 0.04, 0.05, 0.0]
    scanner = Scanner(offset_m=offset_m)
    scanner.step(0, ranges())
    for beam in range(lib.SCAN_BEAMS):
        assert scanner.frame.range_m[beam] == pytest.approx(1.0 + offset_m[beam])


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_tilt_is_taken_out(roll_rad: float, pitch_rad: float) -> None:
    scanner = Scanner()
    scanner.step(0, ranges(), tilt_rad=(roll_rad, pitch_rad), height_m=2.0)
    expected = {
        lib.SCAN_FRONT: math.cos(pitch_rad),
        lib.SCAN_BACK: math.cos(pitch_rad),
        lib.SCAN_LEFT: math.cos(roll_rad),
        lib.SCAN_RIGHT: math.cos(roll_rad),
    }
    for beam, level_m in expected.items():
        assert scanner.frame.range_m[beam] == pytest.approx(level_m, abs=2e-3)


@pytest.mark.parametrize(
    ("tilt_rad", "down"),
    [
        ((0.0, -0.35), "SCAN_FRONT"),  # nose down
        ((0.0, 0.35), "SCAN_BACK"),
        ((-0.35, 0.0), "SCAN_LEFT"),  # left side down
        ((0.35, 0.0), "SCAN_RIGHT"),
    ],
)
def test_a_beam_that_met_the_floor_is_dropped(tilt_rad: tuple[float, float], down: str) -> None:
    scanner = Scanner()
    scanner.step(0, ranges(1.4, 1.4, 1.4, 1.4), tilt_rad=tilt_rad, height_m=0.4)
    assert beams(scanner.frame.hit) == set(range(lib.SCAN_BEAMS)) - {getattr(lib, down)}


def test_the_beams_point_forward_back_left_and_right() -> None:
    bearings = [lib.scan_bearing_rad(beam) for beam in range(lib.SCAN_BEAMS)]
    assert [math.cos(b) for b in bearings] == pytest.approx([1, -1, 0, 0], abs=1e-6)
    assert [math.sin(b) for b in bearings] == pytest.approx([0, 0, 1, -1], abs=1e-6)


def test_time_may_wrap_around() -> None:
    scanner = Scanner(latency_ms=30)
    start_ms = 2**32 - 3 * TICK_MS
    for t in range(6):
        time_ms = (start_ms + t * TICK_MS) % 2**32
        scanner.step(time_ms, ranges(front=1.0 + t * 0.1), x_m=t * 0.1)
    assert scanner.frame.pose.x_m == pytest.approx(0.35, abs=1e-5)
