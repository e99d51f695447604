# SPDX-License-Identifier: GPL-3.0-or-later
"""Geometry against mathematics in double precision, within the bounds that the header states."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, lib
from tests.core.maps import pose, vec2, xy

f32 = np.float32
angles = st.floats(-1000.0, 1000.0, width=32)
metres = st.floats(-100.0, 100.0, width=32)
small = st.floats(-3.125, 3.125, width=32)
any_float = st.floats(width=32)
ATAN_BOUND_RAD = 4e-7
NEAR_BOUND = 2e-7
FAR_BOUND = 1e-4


poses = st.builds(pose, metres, metres, small)


def turn_between(a_rad: float, b_rad: float) -> float:
    return abs(math.remainder(a_rad - b_rad, math.tau))


def assert_same_pose(a: CData, b: CData, tolerance: float = 1e-4) -> None:
    assert xy(lib.pose2_position(a)) == pytest.approx(xy(lib.pose2_position(b)), abs=tolerance)
    assert turn_between(a.yaw_rad, b.yaw_rad) < tolerance


@given(angles)
def test_sine_and_cosine_keep_the_stated_error(angle_rad: float) -> None:
    got = lib.geometry_sincos(angle_rad)
    bound = NEAR_BOUND + (FAR_BOUND - NEAR_BOUND) * abs(angle_rad) / 1000.0
    assert got.sin == pytest.approx(math.sin(angle_rad), abs=bound)
    assert got.cos == pytest.approx(math.cos(angle_rad), abs=bound)


def test_sine_and_cosine_at_every_quarter() -> None:
    for quarter in range(-8, 9):
        angle_rad = float(f32(quarter * math.pi / 2))
        got = lib.geometry_sincos(angle_rad)
        assert got.sin == pytest.approx(math.sin(angle_rad), abs=1e-6)
        assert got.cos == pytest.approx(math.cos(angle_rad), abs=1e-6)


@given(any_float)
def test_sine_and_cosine_stay_on_the_circle_whatever_comes(angle_rad: float) -> None:
    got = lib.geometry_sincos(angle_rad)
    assert got.sin**2 + got.cos**2 == pytest.approx(1.0, abs=1e-5)


@given(st.floats(-1e6, 1e6, width=32), st.floats(-1e6, 1e6, width=32))
def test_the_angle_of_a_vector_keeps_the_stated_error(y: float, x: float) -> None:
    if abs(x) + abs(y) > 1e-30:
        assert turn_between(lib.geometry_atan2(y, x), math.atan2(y, x)) <= ATAN_BOUND_RAD


@pytest.mark.parametrize("degree", range(-180, 181, 15))
def test_the_angle_of_a_vector_all_around(degree: int) -> None:
    angle_rad = math.radians(degree)
    got = lib.geometry_atan2(math.sin(angle_rad), math.cos(angle_rad))
    assert -math.pi - 1e-6 <= got <= math.pi + 1e-6
    assert turn_between(got, angle_rad) <= ATAN_BOUND_RAD


@given(small)
def test_towards_an_angle_is_a_unit_vector_of_that_angle(angle_rad: float) -> None:
    got = lib.vec2_towards(angle_rad)
    assert lib.vec2_norm(got) == pytest.approx(1.0, abs=1e-6)
    assert turn_between(lib.geometry_atan2(got.y, got.x), angle_rad) < 1e-6


def test_the_angle_of_no_vector_is_zero() -> None:
    assert lib.geometry_atan2(0.0, 0.0) == 0.0


@given(angles)
def test_a_wrapped_angle_is_the_same_direction(angle_rad: float) -> None:
    got = lib.geometry_wrap_rad(angle_rad)
    assert abs(got) <= f32(math.pi)
    assert turn_between(got, angle_rad) <= 1e-4


@pytest.mark.parametrize("angle_rad", [math.nan, math.inf, -math.inf])
def test_wrapping_what_is_not_finite_gives_zero(angle_rad: float) -> None:
    assert lib.geometry_wrap_rad(angle_rad) == 0.0


@given(any_float, metres, metres)
def test_clamp_stays_between(value: float, a: float, b: float) -> None:
    low, high = min(a, b), max(a, b)
    got = lib.geometry_clamp(value, low, high)
    if math.isnan(value):
        assert got == low
    else:
        assert got == min(max(value, low), high)


@given(any_float)
def test_finite_means_finite(value: float) -> None:
    assert lib.geometry_is_finite(value) == math.isfinite(value)


@given(metres, metres, st.floats(2**-10, 50.0, width=32))
def test_a_limited_vector_keeps_its_direction(x: float, y: float, most: float) -> None:
    got = lib.vec2_limit(vec2(x, y), most)
    norm = math.hypot(x, y)
    assert math.hypot(*xy(got)) == pytest.approx(min(norm, most), rel=1e-5, abs=1e-20)
    assert got.x * y == pytest.approx(got.y * x, abs=1e-3)


@given(metres, metres, small)
def test_a_turned_vector_keeps_its_length(x: float, y: float, angle_rad: float) -> None:
    got = lib.vec2_rotate(vec2(x, y), angle_rad)
    expected = complex(x, y) * complex(math.cos(angle_rad), math.sin(angle_rad))
    assert xy(got) == pytest.approx((expected.real, expected.imag), abs=1e-4)
    assert lib.vec2_norm(got) == pytest.approx(math.hypot(x, y), abs=1e-4)


@given(metres, metres, metres, metres)
def test_vector_arithmetic(ax: float, ay: float, bx: float, by: float) -> None:
    a, b = vec2(ax, ay), vec2(bx, by)
    assert xy(lib.vec2_sub(lib.vec2_add(a, b), b)) == pytest.approx((ax, ay), abs=1e-4)
    assert lib.vec2_dot(a, b) == pytest.approx(ax * bx + ay * by, abs=1e-2)
    assert lib.vec2_distance(a, b) == pytest.approx(math.hypot(ax - bx, ay - by), abs=1e-4)
    assert xy(lib.vec2_scale(a, -2.0)) == (-2.0 * ax, -2.0 * ay)


@given(poses)
def test_a_pose_and_its_inverse_cancel(a: CData) -> None:
    origin = pose()
    assert_same_pose(lib.pose2_compose(a, lib.pose2_inverse(a)), origin)
    assert_same_pose(lib.pose2_compose(lib.pose2_inverse(a), a), origin)


@given(poses, poses, poses)
def test_composition_is_associative(a: CData, b: CData, c: CData) -> None:
    left = lib.pose2_compose(lib.pose2_compose(a, b), c)
    right = lib.pose2_compose(a, lib.pose2_compose(b, c))
    assert_same_pose(left, right, 1e-3)


@given(poses, poses, metres, metres)
def test_applying_twice_is_applying_the_composition(a: CData, b: CData, x: float, y: float) -> None:
    twice = lib.pose2_apply(a, lib.pose2_apply(b, vec2(x, y)))
    once = lib.pose2_apply(lib.pose2_compose(a, b), vec2(x, y))
    assert xy(twice) == pytest.approx(xy(once), abs=1e-3)


def test_yaw_turns_forward_to_the_left() -> None:
    ahead = lib.pose2_apply(pose(1.0, 2.0, math.pi / 2), vec2(3.0, 0.0))
    assert xy(ahead) == pytest.approx((1.0, 5.0), abs=1e-6)


@given(poses, poses)
def test_interpolation_meets_both_ends(a: CData, b: CData) -> None:
    assert_same_pose(lib.pose2_interpolate(a, b, 0.0), a)
    assert_same_pose(lib.pose2_interpolate(a, b, 1.0), b)


@given(poses, poses, st.floats(0.0, 1.0, width=32))
def test_interpolation_turns_the_short_way(a: CData, b: CData, fraction: float) -> None:
    between = lib.pose2_interpolate(a, b, fraction)
    whole = turn_between(a.yaw_rad, b.yaw_rad)
    assert turn_between(a.yaw_rad, between.yaw_rad) == pytest.approx(fraction * whole, abs=1e-5)
