# SPDX-License-Identifier: GPL-3.0-or-later
"""The collision guard: whatever is commanded, the drone does not fly into what the ranges show."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import ffi, lib
from tests.core.maps import vec2, xy

CONFIG = lib.guard_config_default()
DIRECTIONS = {
    lib.SCAN_FRONT: (1.0, 0.0),
    lib.SCAN_BACK: (-1.0, 0.0),
    lib.SCAN_LEFT: (0.0, 1.0),
    lib.SCAN_RIGHT: (0.0, -1.0),
}
FAR_M = 3.0
NONE_M = -1.0
beams = st.sampled_from(sorted(DIRECTIONS))
speeds = st.floats(-1.0, 1.0, width=32)
near_ranges = st.floats(0.0, 1.5, width=32)
any_ranges = st.one_of(near_ranges, st.just(NONE_M), st.just(math.nan), st.just(math.inf))
range_sets = st.lists(any_ranges, min_size=5, max_size=5)


class Guard:
    """A guard_t and its configuration."""

    def __init__(self) -> None:
        self.cfg = ffi.new("guard_config_t *", CONFIG)
        self.guard = ffi.new("guard_t *")
        lib.guard_init(self.guard)
        self.body = ffi.new("scan_odometry_t *")

    def step(self, ranges_m: list[float], vx: float, vy: float) -> tuple[float, float]:
        return xy(lib.guard_step(self.guard, self.cfg, ranges_m, self.body, vec2(vx, vy)))

    def watch(
        self, time_ms: int, hits_m: dict[int, float], judged: int, yaw_rad: float = 0
    ) -> None:
        """Process a set of ranges measured at the origin."""
        seen = ffi.new("scan_frame_t *", {"time_ms": time_ms, "pose": (0.0, 0.0, yaw_rad)})
        for beam, range_m in hits_m.items():
            seen.hit |= 1 << beam
            seen.range_m[beam] = range_m
        lib.guard_watch(self.guard, self.cfg, seen, [judged] * lib.SCAN_BEAMS)
        self.body.time_ms = time_ms + 100

    @property
    def status(self) -> int:
        return int(self.guard.status)


def ranges(**near: float) -> list[float]:
    """Ranges that are far except in the named directions."""
    made = [FAR_M] * 5
    for name, range_m in near.items():
        made[getattr(lib, f"SCAN_{name.upper()}")] = range_m
    return made


def towards(velocity: tuple[float, float], beam: int) -> float:
    return velocity[0] * DIRECTIONS[beam][0] + velocity[1] * DIRECTIONS[beam][1]


def valid(range_m: float) -> bool:
    return math.isfinite(range_m) and range_m >= 0.0


@given(range_sets, speeds, speeds)
def test_it_never_flies_towards_what_is_near(ranges_m: list[float], vx: float, vy: float) -> None:
    velocity = Guard().step(ranges_m, vx, vy)
    for beam in DIRECTIONS:
        if valid(ranges_m[beam]) and ranges_m[beam] <= CONFIG.stop_m:
            assert towards(velocity, beam) <= 1e-6


@given(range_sets, speeds, speeds)
def test_it_could_always_still_stop(ranges_m: list[float], vx: float, vy: float) -> None:
    velocity = Guard().step(ranges_m, vx, vy)
    for beam in DIRECTIONS:
        speed = towards(velocity, beam)
        if valid(ranges_m[beam]) and speed > 0.0:
            stopping_m = speed * CONFIG.reaction_s + speed**2 / (2 * CONFIG.brake_mps2)
            assert ranges_m[beam] - stopping_m >= CONFIG.stop_m - 1e-4


@given(range_sets, speeds, speeds)
def test_it_is_never_faster_than_wanted_or_than_a_retreat(
    ranges_m: list[float], vx: float, vy: float
) -> None:
    got = Guard().step(ranges_m, vx, vy)
    assert math.hypot(*got) <= max(math.hypot(vx, vy), CONFIG.retreat_mps) * (1 + 1e-5)


@given(speeds, speeds)
def test_with_room_all_around_it_does_nothing(vx: float, vy: float) -> None:
    guard = Guard()
    assert guard.step(ranges(), vx, vy) == (vx, vy)
    assert guard.status == lib.GUARD_CLEAR


@pytest.mark.parametrize("silent", [NONE_M, math.nan, math.inf])
def test_silence_is_not_an_obstacle(silent: float) -> None:
    guard = Guard()
    assert guard.step([silent] * 5, 0.5, -0.2) == pytest.approx((0.5, -0.2))
    assert guard.status == lib.GUARD_CLEAR
    assert guard.guard.nearest_m > 10.0


@given(beams, st.floats(0.125, 1.0, width=32))
def test_the_nearer_the_slower(beam: int, speed: float) -> None:
    dx, dy = DIRECTIONS[beam]
    allowed = []
    for centimetres in range(100, 15, -1):
        made = [FAR_M] * 5
        made[beam] = centimetres / 100
        allowed.append(towards(Guard().step(made, speed * dx, speed * dy), beam))
    assert all(b <= a + 1e-6 for a, b in itertools.pairwise(allowed))
    assert allowed[-1] == pytest.approx(0.0, abs=1e-6)


@given(beams, st.floats(0.25, 0.5, width=32), speeds)
def test_a_wall_ahead_does_not_hinder_flying_along_it(
    beam: int, range_m: float, speed: float
) -> None:
    made = [FAR_M] * 5
    made[beam] = range_m
    dx, dy = DIRECTIONS[beam]
    got = Guard().step(made, -dy * speed, dx * speed)
    assert got == pytest.approx((-dy * speed, dx * speed))


@given(beams, st.floats(0.0, CONFIG.retreat_m * 0.99), speeds, speeds)
def test_it_backs_straight_away_from_a_single_obstacle(
    beam: int, range_m: float, vx: float, vy: float
) -> None:
    guard = Guard()
    made = [FAR_M] * 5
    made[beam] = range_m
    got = guard.step(made, vx, vy)
    assert guard.status == lib.GUARD_RETREAT
    dx, dy = DIRECTIONS[beam]
    assert got == pytest.approx((-dx * CONFIG.retreat_mps, -dy * CONFIG.retreat_mps), abs=1e-6)
    assert xy(guard.guard.away) == pytest.approx((-dx, -dy), abs=1e-6)


def test_the_nearer_of_two_obstacles_weighs_more() -> None:
    guard = Guard()
    guard.step(ranges(front=0.05, left=0.15), 0.0, 0.0)
    away = xy(guard.guard.away)
    assert away[0] < away[1] < 0.0
    assert math.hypot(*away) == pytest.approx(1.0, abs=1e-5)


def test_it_does_not_back_into_what_is_behind() -> None:
    got = Guard().step(ranges(front=0.10, back=0.15), 0.3, 0.0)
    assert got == pytest.approx((0.0, 0.0), abs=1e-6)
    slowly = Guard().step(ranges(front=0.10, back=0.24), 0.3, 0.0)
    assert -CONFIG.retreat_mps < slowly[0] < 0.0


def test_hemmed_in_evenly_it_stands() -> None:
    guard = Guard()
    got = guard.step(ranges(front=0.1, back=0.1, left=0.1, right=0.1), 0.4, 0.4)
    assert got == pytest.approx((0.0, 0.0), abs=1e-6)
    assert guard.status == lib.GUARD_RETREAT


def test_a_retreat_goes_on_until_there_is_room_again() -> None:
    guard = Guard()
    middle_m = (CONFIG.retreat_m + CONFIG.release_m) / 2
    guard.step(ranges(front=middle_m), 0.0, 0.0)
    assert guard.status != lib.GUARD_RETREAT
    guard.step(ranges(front=CONFIG.retreat_m - 0.01), 0.0, 0.0)
    assert guard.status == lib.GUARD_RETREAT
    guard.step(ranges(front=middle_m), 0.0, 0.0)
    assert guard.status == lib.GUARD_RETREAT
    guard.step(ranges(front=CONFIG.release_m + 0.01), 0.0, 0.0)
    assert guard.status != lib.GUARD_RETREAT
    assert xy(guard.guard.away) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("front_m", "status"),
    [(3.0, lib.GUARD_CLEAR), (0.4, lib.GUARD_SLOW), (0.18, lib.GUARD_STOP)],
)
def test_the_status_says_what_it_did(front_m: float, status: int) -> None:
    guard = Guard()
    guard.step(ranges(front=front_m), 0.5, 0.0)
    assert guard.status == status
    assert guard.guard.nearest_m == pytest.approx(min(front_m, FAR_M))


@given(st.floats(0.05, 0.6))
def test_a_body_with_delay_never_reaches_the_wall(speed: float) -> None:
    guard, x_m, velocity, seen = Guard(), 0.0, 0.0, [1.5] * 10
    for tick in range(600):
        if tick % 5 == 0:
            seen.append(1.5 - x_m)
        command = guard.step(ranges(front=seen[-2]), speed, 0.0)[0]
        velocity += (command - velocity) * 0.02 / 0.15
        x_m += velocity * 0.02
        assert 1.5 - x_m > 0.09  # the propellers' tips
