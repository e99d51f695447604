# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole pipeline in a room: missions end where they should, and instances share nothing."""

import math

import pytest

from ground.core import ffi, lib
from tests.core.maps import raw_bytes
from tests.core.room import READY, ROOM, TWO_ROOMS, Flight, hovering, new_config

IDLE, FOLLOW, HOVER, FAULT, LAND = (
    lib.MISSION_IDLE,
    lib.MISSION_FOLLOW,
    lib.MISSION_HOVER,
    lib.MISSION_FAULT,
    lib.MISSION_LAND,
)
GOTO, HOME = lib.MISSION_CMD_GOTO, lib.MISSION_CMD_HOME
TAKE_OFF, HOLD = lib.MISSION_CMD_TAKE_OFF, lib.MISSION_CMD_HOLD
DRONE_RADIUS_M = 0.07


@pytest.mark.parametrize("planner", [lib.NAV_PLANNER_RRTSTAR, lib.NAV_PLANNER_GRID])
@pytest.mark.parametrize("yaw_mode", range(lib.FOLLOWER_YAW_MODES))
def test_it_flies_through_a_door_to_a_goal_that_nobody_has_seen(
    planner: int, yaw_mode: int
) -> None:
    cfg = new_config(planner=planner)
    cfg.follower.yaw_mode = yaw_mode
    flight = Flight(TWO_ROOMS, cfg)
    assert flight.command(GOTO, 1.9, -1.0) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT) == HOVER
    assert flight.distance_m(1.9, -1.0) < 0.25
    assert flight.nearest_m > DRONE_RADIUS_M + 0.03
    assert (lib.WIRE_EVENT_ARRIVED, lib.MISSION_TASK_GOTO) in flight.events


@pytest.mark.parametrize("yaw_mode", [lib.FOLLOWER_YAW_FORWARD, lib.FOLLOWER_YAW_KEEP])
def test_it_looks_before_it_flies_over_known_ground_that_it_has_not_seen_lately(
    yaw_mode: int,
) -> None:
    flight = Flight(ROOM)
    flight.nav.cfg.follower.yaw_mode = yaw_mode
    flight.nav.cfg.watch_rad = 0.0  # what was measured on watch is drawn later, and then seen again
    assert flight.command(GOTO, 1.0, 1.0) == lib.MISSION_OK
    assert flight.run_until(HOVER) == HOVER
    x_m, y_m = flight.x_m, flight.y_m
    lib.seen_forget(ffi.addressof(flight.nav, "seen"))
    assert flight.command(GOTO, -1.0, -0.5) == lib.MISSION_OK
    way_rad = math.atan2(-0.5 - y_m, -1.0 - x_m)
    swept_rad = []
    while flight.distance_m(x_m, y_m) < 0.2:
        flight.step()
        beams = (flight.yaw_rad + lib.scan_bearing_rad(beam) for beam in range(lib.SCAN_BEAMS))
        swept_rad.append(min(abs(math.remainder(beam - way_rad, math.tau)) for beam in beams))
    assert min(swept_rad) < 0.2
    assert flight.run_until(HOVER) == HOVER
    assert flight.distance_m(-1.0, -0.5) < 0.25


@pytest.mark.parametrize("height_m", [900.0, -900.0])
def test_it_climbs_from_the_floor_whatever_the_estimator_says(height_m: float) -> None:
    flight = Flight(ROOM)
    flight.z_m = height_m
    flight.step()
    assert flight.command(TAKE_OFF) == lib.MISSION_OK
    heights_m = [flight.step().height_m for _ in range(60)]
    assert max(heights_m) <= flight.nav.cfg.height_m
    assert heights_m[-1] > 0.3


def test_it_comes_home_and_lands() -> None:
    flight = hovering(TWO_ROOMS)
    assert flight.command(GOTO, -1.2, 1.0) == lib.MISSION_OK
    flight.step()
    assert flight.run_until(HOVER) == HOVER
    assert flight.command(HOME) == lib.MISSION_OK
    assert flight.run_until(IDLE) == IDLE
    assert flight.distance_m(0.0, 0.0) < 0.3
    assert flight.z_m < 0.05
    assert lib.MISSION_RETURN in flight.states


def test_exploring_sees_the_other_room_and_ends_on_the_ground() -> None:
    flight = Flight(TWO_ROOMS)
    assert flight.command(lib.MISSION_CMD_EXPLORE) == lib.MISSION_OK
    assert flight.run_until(IDLE, FAULT, most_s=600.0) == IDLE
    assert any(code == lib.WIRE_EVENT_EXPLORED for code, _ in flight.events)
    assert flight.nav.status.known_cells > 0.8 * 4.9 * 4.0 / 0.05**2
    assert flight.nearest_m > DRONE_RADIUS_M + 0.03


def test_two_navs_flown_in_turns_equal_each_flown_alone() -> None:
    def start(seed: int, goal: tuple[float, float]) -> Flight:
        flight = Flight(TWO_ROOMS, new_config(seed=seed))
        assert flight.command(GOTO, *goal) == lib.MISSION_OK
        return flight

    plans = [(1, (1.9, -1.0)), (2, (-1.5, 1.5))]
    alone = []
    for plan in plans:
        flight = start(*plan)
        flight.run_for(25.0)
        alone.append(raw_bytes(flight.nav))
    together = [start(*plan) for plan in plans]
    for _ in range(1250):
        for flight in together:
            flight.step()
    assert [raw_bytes(flight.nav) for flight in together] == alone
    assert alone[0] != alone[1]


@pytest.mark.parametrize(
    ("missing", "extra", "reason"),
    [
        ("NAV_HAS_FLOW", 0, "NO_FLOW_DECK"),
        ("NAV_HAS_RANGER", 0, "NO_RANGER_DECK"),
        ("NAV_ESTIMATOR_SETTLED", 0, "ESTIMATOR"),
        ("NAV_CAN_FLY", 0, "CANNOT_FLY"),
        ("NAV_IS_FLYING", lib.NAV_TUMBLED, "TUMBLED"),
    ],
)
def test_it_does_not_take_off_without(missing: str, extra: int, reason: str) -> None:
    flight = Flight(flags=READY & ~getattr(lib, missing) | extra)
    for cmd in (TAKE_OFF, GOTO, lib.MISSION_CMD_EXPLORE):
        assert flight.command(cmd) == getattr(lib, f"MISSION_{reason}")
    flight.run_for(1.0)
    assert flight.states == [IDLE]


def test_it_does_not_take_off_with_a_low_battery() -> None:
    flight = Flight(battery_v=3.35)
    assert flight.command(TAKE_OFF) == lib.MISSION_BATTERY_LOW


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ((float("nan"), 0.0), "BAD_VALUE"),
        ((0.0, float("inf")), "BAD_VALUE"),
        ((50.0, 0.0), "OUTSIDE_GRID"),
        ((0.0, -3.3), "OUTSIDE_GRID"),
    ],
)
def test_a_goal_that_cannot_be_is_refused_at_once(goal: tuple[float, float], reason: str) -> None:
    for flight in (Flight(), hovering()):
        before = flight.state
        assert flight.command(GOTO, *goal) == getattr(lib, f"MISSION_{reason}")
        flight.step()
        assert flight.state == before


def test_a_goal_outside_the_fence_is_refused() -> None:
    cfg = new_config()
    cfg.area_min_m, cfg.area_max_m = (-1.0, -1.0), (1.0, 1.0)
    assert Flight(cfg=cfg).command(GOTO, 1.5, 0.0) == lib.MISSION_OUTSIDE_AREA


def test_a_goal_in_a_wall_is_refused_once_the_wall_is_known() -> None:
    flight = hovering()
    assert flight.command(GOTO, 2.88, 0.0) == lib.MISSION_GOAL_OCCUPIED
    assert flight.state == HOVER


def test_a_goal_that_is_walled_off_is_refused_with_the_reason() -> None:
    walls = [*ROOM, (0.8, -2.0, 0.8, 2.0)]
    flight = Flight(walls)
    assert flight.command(GOTO, 1.5, 0.0) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT) == HOVER
    refusals = [argument for code, argument in flight.events if code == lib.WIRE_EVENT_REFUSED]
    assert refusals
    assert refusals[-1] in (lib.MISSION_GOAL_UNREACHABLE, lib.MISSION_STUCK)
    assert flight.x_m < 0.8 - DRONE_RADIUS_M


def test_noise_at_the_goal_is_looked_at_from_near_before_the_goal_is_given_up() -> None:
    flight = hovering()
    assert flight.command(GOTO, 2.0, 1.0) == lib.MISSION_OK
    flight.run_until(FOLLOW)
    grid = ffi.addressof(flight.nav, "grid")
    cell = ffi.new("grid_cell_t *")
    assert lib.grid_locate(grid, (2.0, 1.0), cell)
    for ix in (cell.ix - 1, cell.ix, cell.ix + 1):
        lib.grid_set_value(grid, ix, cell.iy, 10)
    assert flight.run_until(HOVER, FAULT) == HOVER
    assert lib.WIRE_EVENT_REFUSED not in [code for code, _ in flight.events]
    assert math.dist((flight.x_m, flight.y_m), (2.0, 1.0)) < 0.15


def test_a_goal_that_turns_out_too_near_to_a_wall_is_served_from_beside_it() -> None:
    flight = Flight()
    assert flight.command(GOTO, 2.8, 0.0) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT) == HOVER
    assert lib.WIRE_EVENT_ARRIVED in [code for code, _ in flight.events]
    assert 0.1 < flight.distance_m(2.8, 0.0) < 0.3


@pytest.mark.parametrize("hits", [1, 2])
def test_a_way_that_only_noise_closes_is_found_again(hits: int) -> None:
    flight = Flight(TWO_ROOMS)
    assert flight.command(GOTO, -1.6, -1.6) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT) == HOVER
    assert flight.command(GOTO, 1.9, -1.0) == lib.MISSION_OK
    assert flight.run_until(FOLLOW) == FOLLOW
    grid = ffi.addressof(flight.nav, "grid")
    cell = ffi.new("grid_cell_t *")
    for step in range(21):
        assert lib.grid_locate(grid, (0.8, 1.05 + 0.05 * step), cell)
        value = max(lib.grid_value(grid, cell.ix, cell.iy), lib.GRID_OCCUPIED_MIN - 1 + 3 * hits)
        lib.grid_set_value(grid, cell.ix, cell.iy, value)
    lib.clearance_mark(ffi.addressof(flight.nav, "clearance"), grid)
    assert flight.run_until(HOVER, FAULT) == HOVER
    assert flight.distance_m(1.9, -1.0) < 0.25
    assert flight.nearest_m > DRONE_RADIUS_M + 0.03


@pytest.mark.parametrize("landed", [False, True])
def test_what_the_map_shows_to_be_walled_off_is_refused_within_two_seconds(landed: bool) -> None:
    flight = Flight([*ROOM, (0.8, -2.0, 0.8, 2.0)])
    flight.command(GOTO, 1.5, 0.0)
    flight.run_until(HOVER, FAULT)
    if landed:
        flight.command(lib.MISSION_CMD_LAND)
        flight.run_until(IDLE)
        flight.run_for(1.0)
    flight.events.clear()
    asked_ms = flight.time_ms
    assert flight.command(GOTO, 1.5, 0.0) == lib.MISSION_OK
    while not any(code == lib.WIRE_EVENT_REFUSED for code, _ in flight.events):
        flight.step()
        assert flight.time_ms - asked_ms <= 2000
    assert (lib.WIRE_EVENT_REFUSED, lib.MISSION_GOAL_UNREACHABLE) in flight.events
    assert flight.state == (IDLE if landed else HOVER)


@pytest.mark.parametrize("cmd", [HOME, lib.MISSION_CMD_LAND, HOLD, lib.MISSION_CMD_SCAN])
def test_on_the_ground_there_is_nothing_to(cmd: int) -> None:
    assert Flight().command(cmd) == lib.MISSION_NOT_FLYING


@pytest.mark.parametrize("cmd", [0, lib.MISSION_CMDS, 255])
def test_an_unknown_command_is_refused(cmd: int) -> None:
    assert Flight().command(cmd) == lib.MISSION_UNKNOWN_COMMAND


def test_in_the_air_there_is_no_taking_off() -> None:
    assert hovering().command(TAKE_OFF) == lib.MISSION_FLYING


def test_landing_ends_the_motors() -> None:
    flight = hovering()
    assert flight.command(lib.MISSION_CMD_LAND) == lib.MISSION_OK
    assert flight.run_until(IDLE, most_s=10.0) == IDLE
    assert not flight.setpoint.motors


def test_it_backs_away_from_what_comes_near_and_goes_on() -> None:
    flight = hovering()
    visitor = (flight.x_m + 0.1, -0.3, flight.x_m + 0.1, 0.3)
    flight.walls.append(visitor)
    assert flight.run_until(lib.MISSION_AVOID, most_s=2.0) == lib.MISSION_AVOID
    assert flight.run_until(HOVER, most_s=20.0) == HOVER
    assert flight.x_m < visitor[0] - 0.15


def test_a_door_that_closes_is_not_flown_through() -> None:
    flight = Flight(list(TWO_ROOMS))
    flight.command(GOTO, 1.9, -1.0)
    while flight.y_m < 0.5:
        flight.step()
    flight.walls.append((0.8, 1.1, 0.8, 2.0))
    assert flight.run_until(HOVER, FAULT, most_s=200.0) == HOVER
    assert flight.x_m < 0.8 or flight.distance_m(1.9, -1.0) < 0.25
    assert flight.nearest_m > DRONE_RADIUS_M


def test_forgetting_the_map_in_flight_plans_anew() -> None:
    flight = Flight(TWO_ROOMS)
    flight.command(GOTO, 1.9, -1.0)
    assert flight.run_until(lib.MISSION_FOLLOW) == lib.MISSION_FOLLOW
    flight.run_for(1.0)
    assert flight.command(lib.MISSION_CMD_FORGET) == lib.MISSION_OK
    flight.step()
    assert flight.nav.status.known_cells == 0 or flight.state != lib.MISSION_FOLLOW
    assert flight.run_until(HOVER, FAULT) == HOVER
    assert flight.distance_m(1.9, -1.0) < 0.25
    assert flight.nearest_m > DRONE_RADIUS_M + 0.03


def test_forgetting_begins_a_new_epoch() -> None:
    flight = hovering()
    before = lib.nav_hello(flight.nav)
    flight.command(lib.MISSION_CMD_FORGET)
    after = lib.nav_hello(flight.nav)
    assert after.epoch == (before.epoch + 1) % lib.WIRE_MAP_EPOCHS
    assert flight.nav.grid.known == 0
