# SPDX-License-Identifier: GPL-3.0-or-later
"""The self-test flies, reaches every stage, and its number changes with any of them."""

import pytest

from ground.core import CData, MissionState, ffi, lib


def start() -> tuple[CData, CData]:
    test, nav = ffi.new("selftest_t *"), ffi.new("nav_t *")
    lib.selftest_start(test, nav)
    return test, nav


def run(test: CData, ticks: int = 1) -> list[int]:
    """The states met during the run."""
    states = [int(test.nav.status.state)]
    while not lib.selftest_step(test, ticks):
        states += [test.nav.status.state] * (states[-1] != test.nav.status.state)
    return states


def test_this_machine_agrees() -> None:
    """If decisions were changed on purpose, put the new number into selftest.c: GOLDEN."""
    test, _ = start()
    run(test)
    assert f"{test.hash:#010x}" == f"{lib.selftest_golden():#010x}"
    assert test.state == lib.SELFTEST_AGREES


def test_it_is_a_whole_flight_through_all_stages() -> None:
    test, nav = start()
    states = run(test)
    met = {MissionState(state).name for state in states}
    assert met == {"IDLE", "TAKEOFF", "SCAN", "PLAN", "FOLLOW", "HOVER", "LAND"}
    assert nav.mission.state == MissionState.IDLE
    assert nav.mission.fault == lib.MISSION_OK
    assert nav.route.revision >= 2
    assert nav.grid.known > 3_000
    assert abs(test.pose.x_m - 2.0) < 0.15
    # The odometry errs, and the map's pose must not follow it: SLAM has worked.
    error_m = abs(nav.slam.filter.pose.x_m - test.pose.x_m)
    assert error_m < 0.5 * abs(test.input.odometry.pose.x_m - test.pose.x_m)


@pytest.mark.parametrize("ticks", [3, 100, 5_000])
def test_slices_of_any_size_give_the_same(ticks: int) -> None:
    test, _ = start()
    run(test, ticks)
    assert (test.ticks, test.state) == (lib.SELFTEST_TICKS, lib.SELFTEST_AGREES)


def test_what_nav_did_before_does_not_matter() -> None:
    test, nav = start()
    ffi.memmove(nav, b"\xa5" * ffi.sizeof("nav_t"), ffi.sizeof("nav_t"))
    lib.selftest_start(test, nav)
    run(test)
    assert test.state == lib.SELFTEST_AGREES


def test_done_stays_done() -> None:
    test, _ = start()
    run(test)
    before = bytes(ffi.buffer(test))
    assert lib.selftest_step(test, 10)
    assert bytes(ffi.buffer(test)) == before


def bend_one_bit(field: CData) -> None:
    """Change a float by the smallest step."""
    bits = ffi.cast("uint32_t *", field)
    bits[0] ^= 1


@pytest.mark.parametrize(
    ("tick", "what"),
    [
        (0, "cfg.follower.speed_mps"),
        (25, "height_sp_m"),
        (200, "slam.filter.pose.yaw_rad"),
        (500, "slam.filter.pose.y_m"),
        (600, "route.points_m"),
    ],
)
def test_one_bit_of_what_is_decided_by_changes_the_number(tick: int, what: str) -> None:
    test, nav = start()
    lib.selftest_step(test, tick)
    owner = nav
    *path, name = what.split(".")
    for part in path:
        owner = getattr(owner, part)
    bend_one_bit(ffi.addressof(owner, name))
    run(test)
    assert (test.state, test.hash == lib.selftest_golden()) == (lib.SELFTEST_DIFFERS, False)


def test_one_cell_or_point_of_the_map_changes_the_number() -> None:
    numbers = set()
    for what in ("cells", "points"):
        test, nav = start()
        lib.selftest_step(test, lib.SELFTEST_TICKS - 1)
        getattr(nav.grid, what)[7] ^= 1
        run(test)
        numbers.add(test.hash)
    assert len(numbers | {lib.selftest_golden()}) == 3


def test_two_at_a_time_do_not_meet() -> None:
    (one, nav), (other, other_nav) = start(), start()
    while not (lib.selftest_step(one, 7) & lib.selftest_step(other, 11)):
        pass
    assert nav.status.state == other_nav.status.state
    assert (one.state, other.state) == (lib.SELFTEST_AGREES, lib.SELFTEST_AGREES)
