# SPDX-License-Identifier: GPL-3.0-or-later
"""Waypoints, patrols, spins, the way home through observed cells, and the charge kept for it."""

import math
from itertools import pairwise

import pytest

from ground.core import CData, ffi, lib
from tests.core.room import Flight, hovering, new_config

IDLE, HOVER, SPIN, LAND = lib.MISSION_IDLE, lib.MISSION_HOVER, lib.MISSION_SPIN, lib.MISSION_LAND
FLY, PATROL = lib.MISSION_CMD_FLY, lib.MISSION_CMD_PATROL
SQUARE = [(1.2, 0.0), (1.2, 1.2), (0.0, 1.2)]
WALLED_IN = [(1.0, 0.9, 2.9, 0.9), (1.0, 0.9, 1.0, 2.0)]  # the upper right corner
WAYPOINT, SKIPPED, REFUSED = (
    lib.WIRE_EVENT_WAYPOINT,
    lib.WIRE_EVENT_SKIPPED,
    lib.WIRE_EVENT_REFUSED,
)


def give(
    flight: Flight,
    points: list[tuple[float, float]],
    number: int = 1,
    first: int = 0,
    total: int | None = None,
) -> int:
    given = lib_waypoints(points, number, first, len(points) if total is None else total)
    return int(lib.nav_take_waypoints(flight.nav, given))


def lib_waypoints(points: list[tuple[float, float]], number: int, first: int, total: int) -> CData:
    given = ffi.new("wire_waypoints_t *")
    given.list, given.first, given.total, given.count = number, first, total, len(points)
    for i, (x_m, y_m) in enumerate(points):
        given.points_mm[i] = [round(1000 * x_m), round(1000 * y_m)]
    return given


def numbers(flight: Flight, code: int) -> list[int]:
    """Arguments of all events of one code."""
    return [argument for seen, argument in flight.events if seen == code]


def turned_rad(flight: Flight, *until: int) -> float:
    """The angle by which the body truly turns in the meantime."""
    total = 0.0
    while flight.state not in until:
        before = flight.yaw_rad
        flight.step()
        total += math.remainder(flight.yaw_rad - before, math.tau)
    return total


@pytest.mark.parametrize("in_the_air", [False, True])
def test_way_points_are_flown_along_in_their_order(in_the_air: bool) -> None:
    flight = hovering() if in_the_air else Flight()
    assert give(flight, SQUARE) == lib.MISSION_OK
    assert flight.command(FLY) == lib.MISSION_OK
    flight.step()
    passed = []
    while len(passed) < len(SQUARE) and flight.time_ms < 120_000:
        before = len(numbers(flight, WAYPOINT))
        flight.step()
        if len(numbers(flight, WAYPOINT)) > before:
            passed.append((flight.x_m, flight.y_m))
    assert numbers(flight, WAYPOINT) == [0, 1, 2]
    for at, wanted in zip(passed, SQUARE, strict=True):
        assert math.dist(at, wanted) < 0.2
    flight.run_for(1.0)
    assert flight.state == HOVER
    assert flight.nav.mission.task == lib.MISSION_TASK_NONE


def test_a_patrol_goes_round_until_it_is_told_otherwise() -> None:
    flight = hovering()
    give(flight, SQUARE)
    flight.command(PATROL)
    flight.run_for(100.0)
    seen = numbers(flight, WAYPOINT)
    assert len(seen) > 4
    assert seen[0] == 0
    assert all(b == (a + 1) % 3 for a, b in pairwise(seen))
    flight.command(lib.MISSION_CMD_HOLD)
    flight.run_for(20.0)
    assert flight.state == HOVER
    assert len(numbers(flight, WAYPOINT)) == len(seen)


def test_a_patrol_leaves_out_what_it_cannot_reach_and_says_so() -> None:
    flight = hovering([*hovering().walls, *WALLED_IN])
    give(flight, [(-1.0, 0.0), (2.0, 1.5), (2.2, 1.4), (0.5, -1.0)])
    flight.command(PATROL)
    flight.run_for(150.0)
    assert {0, 3} == set(numbers(flight, WAYPOINT))
    assert set(numbers(flight, SKIPPED)) <= {
        lib.MISSION_GOAL_UNREACHABLE,
        lib.MISSION_GOAL_OCCUPIED,
        lib.MISSION_STUCK,
    }
    assert numbers(flight, SKIPPED)
    assert not numbers(flight, REFUSED)


def test_flying_along_points_ends_at_one_that_cannot_be_reached_with_the_reason() -> None:
    flight = hovering([*hovering().walls, *WALLED_IN])
    give(flight, [(-1.0, 0.0), (2.0, 1.5), (0.5, -1.0)])
    flight.command(FLY)
    flight.step()
    assert flight.run_until(HOVER, most_s=150.0) == HOVER
    assert numbers(flight, WAYPOINT) == [0]
    assert numbers(flight, REFUSED)[0] in (
        lib.MISSION_GOAL_UNREACHABLE,
        lib.MISSION_GOAL_OCCUPIED,
        lib.MISSION_STUCK,
    )


def test_a_patrol_of_points_that_are_all_out_of_reach_ends() -> None:
    flight = hovering([*hovering().walls, *WALLED_IN])
    give(flight, [(2.0, 1.5), (2.2, 1.4)])
    flight.command(PATROL)
    flight.step()
    assert flight.run_until(HOVER, most_s=150.0) == HOVER
    assert len(numbers(flight, REFUSED)) == 1


def test_a_list_comes_in_pieces_in_any_order_and_more_than_once() -> None:
    flight = hovering()
    points = [(0.1 * i, -0.1 * i) for i in range(lib.NAV_WAYPOINTS)]
    pieces = [(points[i : i + 5], i) for i in range(0, len(points), 5)]
    for piece, first in [pieces[2], pieces[0], pieces[2]]:
        assert give(flight, piece, 7, first, len(points)) == lib.MISSION_OK
    assert flight.command(FLY) == lib.MISSION_NO_WAYPOINTS
    assert give(flight, pieces[1][0], 7, pieces[1][1], len(points)) == lib.MISSION_OK
    held = flight.nav.waypoints
    kept = [tuple(held.points_mm[i]) for i in range(held.total)]
    assert kept == [(100 * i, -100 * i) for i in range(lib.NAV_WAYPOINTS)]
    assert flight.command(FLY) == lib.MISSION_OK
    give(flight, points[:2], 8)
    assert flight.command(PATROL) == lib.MISSION_OK
    assert flight.nav.waypoints.total == 2


def test_absurd_lists_are_refused_and_change_nothing() -> None:
    flight = hovering()
    give(flight, SQUARE)
    before = bytes(ffi.buffer(ffi.addressof(flight.nav, "waypoints")))
    for first, total in ((0, lib.NAV_WAYPOINTS + 1), (2, 3), (255, 3), (0, 2)):
        assert give(flight, SQUARE, 2, first, total) == lib.MISSION_BAD_VALUE
    too_many = lib_waypoints(SQUARE, 3, 0, 12)
    too_many.count = lib.WIRE_WAYPOINTS_A_PACKET + 1
    assert lib.nav_take_waypoints(flight.nav, too_many) == lib.MISSION_BAD_VALUE
    assert bytes(ffi.buffer(ffi.addressof(flight.nav, "waypoints"))) == before


@pytest.mark.parametrize("cmd", [FLY, PATROL])
def test_without_good_way_points_it_does_not_set_off(cmd: int) -> None:
    flight = Flight()
    assert flight.command(cmd) == lib.MISSION_NO_WAYPOINTS
    give(flight, [(0.5, 0.0), (9.0, 0.0)])
    assert flight.command(cmd) == lib.MISSION_OUTSIDE_GRID
    assert flight.state == IDLE


@pytest.mark.parametrize("turns", [1.0, -2.0, 2.5])
@pytest.mark.parametrize("in_the_air", [False, True])
def test_a_spin_is_as_many_turns_as_it_was_told(turns: float, in_the_air: bool) -> None:
    cfg = new_config(turns=turns, watch_rad=0.0)
    flight = Flight(cfg=cfg)
    if in_the_air:
        flight.command(lib.MISSION_CMD_TAKE_OFF)
        assert flight.run_until(HOVER) == HOVER
    assert flight.command(lib.MISSION_CMD_SPIN) == lib.MISSION_OK
    flight.step()
    assert flight.run_until(SPIN) == SPIN
    assert turned_rad(flight, HOVER) == pytest.approx(math.tau * turns, abs=0.15)
    assert flight.distance_m(0.0, 0.0) < 0.1


def test_a_spin_that_is_held_ends() -> None:
    flight = hovering()
    flight.command(lib.MISSION_CMD_SPIN)
    flight.run_for(2.0)
    flight.command(lib.MISSION_CMD_HOLD)
    flight.step()
    yaw_rad = flight.yaw_rad
    flight.run_for(3.0)
    assert flight.state == HOVER
    assert abs(math.remainder(flight.yaw_rad - yaw_rad, math.tau)) < 0.6


def test_the_way_home_is_through_what_was_observed() -> None:
    """It avoids unknown cells on the straight path, unless there is no other."""
    flight = beyond(-0.4, 1.2)
    flight.command(lib.MISSION_CMD_HOME)
    flight.step()
    assert flight.run_until(lib.MISSION_RETURN, most_s=20.0) == lib.MISSION_RETURN
    assert max(abs(p.y) for p in route(flight)) > 0.4
    assert flight.run_until(IDLE) == IDLE
    assert flight.distance_m(0.0, 0.0) < 0.2


def test_where_only_the_unknown_is_left_the_way_home_leads_there() -> None:
    flight = beyond(-3.0, 3.0)
    flight.command(lib.MISSION_CMD_HOME)
    flight.step()
    assert flight.run_until(IDLE) == IDLE
    assert flight.distance_m(0.0, 0.0) < 0.2


def beyond(low_m: float, high_m: float) -> Flight:
    """At (2, 0), no beam towards home, and a strip of the map across the way there was never
    observed."""
    flight = Flight(cfg=new_config(turns=0.125, watch_rad=0.0))
    flight.command(lib.MISSION_CMD_GOTO, 2.0, 0.0)
    flight.step()
    assert flight.run_until(HOVER) == HOVER
    flight.command(lib.MISSION_CMD_SPIN)
    flight.step()
    assert flight.run_until(HOVER) == HOVER
    flight.run_for(1.0)
    grid = flight.nav.grid
    for x in range(lib.GRID_SIDE_CELLS):
        for y in range(lib.GRID_SIDE_CELLS):
            x_m = grid.origin_m.x + (x + 0.5) * grid.cell_m
            y_m = grid.origin_m.y + (y + 0.5) * grid.cell_m
            if 0.9 < x_m < 1.2 and low_m < y_m < high_m:
                lib.grid_set_value(ffi.addressof(flight.nav, "grid"), x, y, lib.GRID_UNKNOWN)
    return flight


def route(flight: Flight) -> list[CData]:
    return [flight.nav.route.points_m[i] for i in range(flight.nav.route.count)]


def drain(flight: Flight, fall_vps: float, most_s: float = 500.0) -> float:
    """Lower the voltage until the drone has landed; return the voltage that is left."""
    end_ms = flight.time_ms + 1000 * most_s
    while flight.state != IDLE and flight.time_ms < end_ms:
        flight.battery_v -= fall_vps * 0.02
        flight.step()
    assert flight.state == IDLE
    return flight.battery_v


@pytest.mark.parametrize("fall_vps", [0.002, 0.01, 0.02])
def test_it_comes_home_while_the_battery_lasts_for_it(fall_vps: float) -> None:
    flight = hovering()
    give(flight, [(2.3, 1.5), (2.3, -1.5)])
    flight.command(PATROL)
    left_v = drain(flight, fall_vps)
    assert flight.fault == lib.MISSION_BATTERY_LOW
    assert flight.distance_m(0.0, 0.0) < 0.3
    limit_v = flight.nav.cfg.low_battery_v
    assert limit_v - 0.05 < left_v < limit_v + 40 * fall_vps + 0.1


def test_near_home_it_flies_longer_than_far_from_it() -> None:
    def turns_back_at_v(points: list[tuple[float, float]]) -> float:
        flight = hovering()
        give(flight, points)
        flight.command(PATROL)
        while flight.fault != lib.MISSION_BATTERY_LOW:
            flight.battery_v -= 0.01 * 0.02
            flight.step()
        return flight.battery_v

    assert turns_back_at_v([(0.4, 0.0), (0.0, 0.4)]) < turns_back_at_v([(2.3, 1.5), (2.3, 1.0)])


def test_when_the_way_is_too_far_for_what_is_left_it_lands_where_it_is() -> None:
    flight = hovering()
    flight.command(lib.MISSION_CMD_GOTO, 2.3, 1.5)
    flight.step()
    assert flight.run_until(HOVER) == HOVER
    flight.battery_v = 3.3
    drain(flight, 0.08)
    assert flight.fault == lib.MISSION_BATTERY_EMPTY
    assert flight.distance_m(0.0, 0.0) > 0.5
