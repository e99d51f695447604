# SPDX-License-Identifier: GPL-3.0-or-later
"""The collision guard yields to approaching obstacles, and not to what only seems to approach."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import ffi, lib
from tests.core.maps import xy
from tests.core.room import hovering
from tests.core.test_guard import CONFIG, DIRECTIONS, Guard, ranges, towards


@pytest.mark.parametrize("judged", [lib.GRID_ECHO_UNEXPLAINED, lib.GRID_ECHO_STRANGE])
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
        (lib.GRID_ECHO_UNEXPLAINED, 0.05, 0.6),
        (lib.GRID_ECHO_UNEXPLAINED, 0.5, 0.0),
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


def test_a_turn_beside_an_oblique_wall_is_no_intruder() -> None:
    guard = Guard()
    for step in range(20):
        yaw_rad = 0.1 * step
        range_m = {lib.SCAN_LEFT: 1.2 - 0.04 * step}
        guard.watch(1000 + 100 * step, range_m, lib.GRID_ECHO_UNEXPLAINED, yaw_rad)
    assert guard.guard.unexplained
    assert guard.step(ranges(left=0.44), 0.0, 0.0) == (0.0, 0.0)


@given(st.lists(st.floats(0.1, 3.0), min_size=5, max_size=5), st.floats(0.1, 0.7))
def test_giving_way_it_moves_only_where_a_beam_sees_room(
    room_m: list[float], intruder_m: float
) -> None:
    guard = Guard()
    room_m[lib.SCAN_FRONT] = intruder_m
    for time_ms in (900, 1000):
        guard.watch(time_ms, {lib.SCAN_FRONT: intruder_m}, lib.GRID_ECHO_STRANGE)
    velocity = guard.step(room_m, 0.0, 0.0)
    for beam in DIRECTIONS:
        if towards(velocity, beam) > 1e-6:
            assert room_m[beam] > CONFIG.stop_m
            assert math.hypot(*velocity) == pytest.approx(towards(velocity, beam), abs=1e-5)


def test_a_retreat_ends_a_little_farther_away_than_it_began() -> None:
    guard = Guard()
    for step in range(60):
        guard.watch(1000 + 100 * step, {lib.SCAN_FRONT: 1.9 - 0.05 * step}, lib.GRID_ECHO_STRANGE)
        guard.step(ranges(), 0.0, 0.0)
        if guard.status == lib.GUARD_RETREAT:
            break
    for away_m, retreats in ((0.06, True), (0.2, False), (0.06, False)):
        guard.body.pose.x_m = -away_m
        guard.step(ranges(), 0.0, 0.0)
        assert (guard.status == lib.GUARD_RETREAT) == retreats


def test_a_intruder_is_remembered_for_a_while_and_not_longer() -> None:
    guard = Guard()
    for time_ms in (900, 1000):
        guard.watch(time_ms, {lib.SCAN_FRONT: 0.3}, lib.GRID_ECHO_STRANGE)
    assert guard.step(ranges(), 0.0, 0.0)[0] < 0.0
    guard.body.time_ms = 1000 + 1600
    assert guard.step(ranges(), 0.0, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("judged", [lib.GRID_ECHO_UNEXPLAINED, lib.GRID_ECHO_STRANGE])
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
        assert step == 0 or guard.status == lib.GUARD_RETREAT


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


@given(
    st.sampled_from(sorted(DIRECTIONS)),
    st.floats(0.04, 1.0),
    st.sampled_from([lib.GRID_ECHO_STRANGE, lib.GRID_ECHO_UNEXPLAINED]),
)
def test_a_single_echo_of_nothing_moves_nobody_and_a_second_one_does(
    beam: int, false_m: float, judged: int
) -> None:
    guard = Guard()
    true_m, false = dict.fromkeys(DIRECTIONS, 1.5), [1.5] * 5
    false[beam] = false_m
    for step in range(40):
        strange = step % 8 == 7
        hits_m = true_m | {beam: false_m} if strange else true_m
        guard.watch(1000 + 100 * step, hits_m, judged if strange else lib.GRID_ECHO_FAMILIAR)
        assert guard.step(false if strange else [1.5] * 5, 0.0, 0.0) == (0.0, 0.0)
        assert guard.status != lib.GUARD_RETREAT
    guard.watch(5000, true_m | {beam: false_m}, judged)
    moved = guard.step(false, 0.0, 0.0)
    near = false_m < (CONFIG.yield_m * 0.6 if judged == lib.GRID_ECHO_STRANGE else CONFIG.retreat_m)
    assert (towards(moved, beam) < 0.0) == near


@given(
    st.sampled_from(sorted(DIRECTIONS)),
    st.floats(0.45, 0.7),
    st.floats(0.3, 0.9),
    st.sampled_from([lib.GRID_ECHO_STRANGE, lib.GRID_ECHO_UNEXPLAINED]),
)
def test_a_single_false_echo_before_what_stands_there_is_no_approach(
    beam: int, stands_m: float, share: float, judged: int
) -> None:
    guard = Guard()
    false_m = share * (stands_m - 0.26)  # nothing falls as fast as that
    for step in range(60):
        range_m = false_m if step % 20 == 19 else stands_m
        guard.watch(1000 + 100 * step, {beam: range_m}, judged)
        guard.step([range_m if at == beam else -1.0 for at in range(5)], 0.0, 0.0)
        assert guard.status != lib.GUARD_RETREAT, step


@given(st.floats(0.04, 0.13), st.integers(0, 300))
def test_what_is_truly_as_near_as_that_is_fled_a_set_later(near_m: float, late_ms: int) -> None:
    guard = Guard()
    guard.watch(1000, {lib.SCAN_LEFT: 1.5}, lib.GRID_ECHO_FAMILIAR)
    guard.watch(1100, {lib.SCAN_LEFT: near_m}, lib.GRID_ECHO_FAMILIAR)
    guard.step(ranges(left=near_m), 0.0, 0.3)
    assert guard.status == lib.GUARD_STOP
    guard.body.time_ms = 1400 + late_ms
    assert guard.step(ranges(left=near_m), 0.0, 0.0)[1] < 0.0, "no set came that denies it"
    guard.watch(1200, {lib.SCAN_LEFT: near_m}, lib.GRID_ECHO_FAMILIAR)
    assert guard.step(ranges(left=near_m), 0.0, 0.0)[1] < 0.0


def test_walls_that_it_knows_are_nobody_who_comes() -> None:
    flight = hovering()
    for cmd in (lib.MISSION_CMD_GOTO, lib.MISSION_CMD_SPIN):
        assert flight.command(cmd, 0.8, 0.6) == lib.MISSION_OK
        flight.step()
        assert flight.run_until(lib.MISSION_HOVER) == lib.MISSION_HOVER
    flight.run_for(5.0)
    lib.guard_init(ffi.addressof(flight.nav, "guard"))
    flight.run_for(5.0)
    assert not flight.nav.guard.met
