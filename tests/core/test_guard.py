# SPDX-License-Identifier: GPL-3.0-or-later
"""The reflex: whatever is wanted, nothing flies into what the ranges show."""

import itertools
import math
import random

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
        """Take a set seen from the origin."""
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
    """Far everywhere but in the named directions."""
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


@pytest.mark.parametrize("judged", [lib.GRID_ECHO_UNTOLD, lib.GRID_ECHO_STRANGE])
@given(speed=st.floats(0.3, 0.7))
def test_it_gives_way_to_what_comes_as_fast_as_that(judged: int, speed: float) -> None:
    guard = Guard()
    for step in range(60):
        range_m = 1.9 - speed * step * 0.1
        guard.watch(1000 + 100 * step, {lib.SCAN_FRONT: range_m}, judged)
        velocity = guard.step(ranges(front=range_m), 0.0, 0.0)
        if guard.status == lib.GUARD_RETREAT:
            break
    assert CONFIG.yield_m < range_m < CONFIG.yield_m + speed
    assert -CONFIG.yield_mps - 1e-6 <= velocity[0] < -0.8 * speed


@pytest.mark.parametrize(
    ("judged", "speed", "yield_m"),
    [
        (lib.GRID_ECHO_FAMILIAR, 0.5, 0.6),
        (lib.GRID_ECHO_UNTOLD, 0.05, 0.6),
        (lib.GRID_ECHO_UNTOLD, 0.5, 0.0),
    ],
)
def test_walls_noise_and_what_it_is_told_to_ignore_do_not_move_it(
    judged: int, speed: float, yield_m: float
) -> None:
    guard = Guard()
    guard.cfg.yield_m = yield_m
    for step in range(15):
        range_m = 1.0 - speed * step * 0.1
        guard.watch(1000 + 100 * step, {lib.SCAN_LEFT: range_m}, judged)
        assert guard.step(ranges(left=range_m), 0.0, 0.0) == (0.0, 0.0)


def test_a_turn_beside_an_oblique_wall_is_no_comer() -> None:
    guard = Guard()
    for step in range(20):
        yaw_rad = 0.1 * step
        guard.watch(
            1000 + 100 * step, {lib.SCAN_LEFT: 1.2 - 0.04 * step}, lib.GRID_ECHO_UNTOLD, yaw_rad
        )
    assert guard.guard.untold
    assert guard.step(ranges(left=0.44), 0.0, 0.0) == (0.0, 0.0)


@given(st.lists(st.floats(0.1, 3.0), min_size=5, max_size=5), st.floats(0.1, 0.7))
def test_giving_way_it_moves_only_where_a_beam_sees_room(
    room_m: list[float], comer_m: float
) -> None:
    guard = Guard()
    room_m[lib.SCAN_FRONT] = comer_m
    guard.watch(1000, {lib.SCAN_FRONT: comer_m}, lib.GRID_ECHO_STRANGE)
    velocity = guard.step(room_m, 0.0, 0.0)
    for beam in DIRECTIONS:
        if towards(velocity, beam) > 1e-6:
            assert room_m[beam] > CONFIG.stop_m
            assert math.hypot(*velocity) == pytest.approx(towards(velocity, beam), abs=1e-5)


def test_a_comer_is_remembered_for_a_while_and_not_longer() -> None:
    guard = Guard()
    guard.watch(1000, {lib.SCAN_FRONT: 0.3}, lib.GRID_ECHO_STRANGE)
    assert guard.step(ranges(), 0.0, 0.0)[0] < 0.0
    guard.body.time_ms = 1000 + 1600
    assert guard.step(ranges(), 0.0, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("judged", [lib.GRID_ECHO_UNTOLD, lib.GRID_ECHO_STRANGE])
def test_who_stands_still_is_no_reason_to_flee_for_ever_but_is_not_approached(judged: int) -> None:
    guard = Guard()
    for step in range(50):
        guard.watch(1000 + 100 * step, {lib.SCAN_FRONT: 0.33}, judged)
    assert guard.step(ranges(front=0.33), 0.0, 0.0) == (0.0, 0.0)
    assert guard.status != lib.GUARD_RETREAT
    guard.body.pose.yaw_rad = 0.6  # between two beams now
    vx, vy = guard.step(ranges(), 0.3, -0.2)
    assert vx * math.cos(0.6) - vy * math.sin(0.6) <= 0.01


def test_who_walks_on_slowly_is_given_way_to_all_the_time() -> None:
    guard = Guard()
    for step in range(60):
        ahead_m = 0.34 - 0.03 * abs(step % 20 - 10) / 10
        bearing_rad = 0.05 * step
        guard.watch(
            1000 + 100 * step, {lib.SCAN_FRONT: ahead_m}, lib.GRID_ECHO_STRANGE, bearing_rad
        )
        guard.body.pose.yaw_rad = bearing_rad
        guard.step(ranges(front=ahead_m), 0.0, 0.0)
        assert guard.status == lib.GUARD_RETREAT


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(-3.0, 3.0))
def test_echoes_tell_how_much_faster_odometry_is(off_x: float, off_y: float, yaw: float) -> None:
    guard = Guard()
    for step in range(40):
        seen = ffi.new("scan_frame_t *", {"time_ms": 1000 + 100 * step, "hit": 15})
        seen.pose = (off_x * 0.1 * step, off_y * 0.1 * step, yaw)  # truly it stands still
        seen.range_m = [1.0, 1.3, 1.7, 0.6]
        lib.guard_watch(guard.guard, guard.cfg, seen, [lib.GRID_ECHO_FAMILIAR] * lib.SCAN_BEAMS)
    slip = xy(lib.guard_slip(guard.guard, yaw))
    forward = off_x * math.cos(yaw) + off_y * math.sin(yaw)
    left = off_y * math.cos(yaw) - off_x * math.sin(yaw)
    assert slip == pytest.approx((forward, left), abs=0.01)


def test_one_who_comes_on_one_side_is_no_error_of_odometry() -> None:
    guard = Guard()
    for step in range(12):
        hits = {lib.SCAN_FRONT: 1.8 - 0.1 * step, lib.SCAN_BACK: 1.0}
        guard.watch(1000 + 100 * step, hits, lib.GRID_ECHO_FAMILIAR)
    assert xy(lib.guard_slip(guard.guard, 0.0)) == (0.0, 0.0)


@given(st.integers(0, 2**32 - 1))
def test_a_beam_that_tells_anything_is_restless_and_a_steady_one_is_not(seed: int) -> None:
    guard, luck = Guard(), random.Random(seed)
    most = 0
    for step in range(300):
        hits = {lib.SCAN_FRONT: luck.uniform(0.3, 1.0), lib.SCAN_LEFT: luck.choice((0.5, 0.6))}
        hits[lib.SCAN_RIGHT] = 0.4 if step % 8 == 0 else 0.9  # a false echo now and then
        guard.watch(1000 + 100 * step, hits, lib.GRID_ECHO_FAMILIAR)
        most = max(most, guard.guard.restless[lib.SCAN_FRONT])
    restless = guard.guard.restless
    assert most >= lib.GUARD_RESTLESS
    assert max(restless[lib.SCAN_LEFT], restless[lib.SCAN_RIGHT]) < lib.GUARD_RESTLESS / 2
