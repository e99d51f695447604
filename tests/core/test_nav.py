# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole pipeline in a room: missions that end where they should, and nothing shared."""

import pytest

from ground.core import lib
from tests.core.maps import raw_bytes
from tests.core.room import READY, ROOM, TWO_ROOMS, Flight, new_config

IDLE, HOVER, FAULT, LAND = (
    lib.MISSION_IDLE,
    lib.MISSION_HOVER,
    lib.MISSION_FAULT,
    lib.MISSION_LAND,
)
GOTO, HOME = lib.MISSION_CMD_GOTO, lib.MISSION_CMD_HOME
TAKE_OFF, HOLD = lib.MISSION_CMD_TAKE_OFF, lib.MISSION_CMD_HOLD
DRONE_RADIUS_M = 0.07


def hovering(walls: list[tuple[float, float, float, float]] = ROOM) -> Flight:
    flight = Flight(list(walls))
    assert flight.command(TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT) == HOVER
    return flight


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


@pytest.mark.parametrize(
    ("policy", "end"), [("GO_ON", HOVER), ("HOLD", HOVER), ("HOME", IDLE), ("LAND", IDLE)]
)
def test_when_the_ground_falls_silent(policy: str, end: int) -> None:
    flight = hovering()
    cfg = new_config(lost=getattr(lib, f"NAV_LOST_{policy}"))
    assert lib.nav_configure(flight.nav, cfg) == lib.MISSION_OK
    flight.flags &= ~lib.NAV_LINK_ALIVE
    flight.run_for(4.5)
    assert flight.state == HOVER
    flight.run_for(40.0)
    assert flight.state == end
    assert (flight.fault == lib.MISSION_LINK_LOST) == (policy != "GO_ON")


def test_a_low_battery_brings_it_home() -> None:
    flight = hovering()
    flight.command(GOTO, 1.4, 1.4)
    flight.step()
    assert flight.run_until(HOVER) == HOVER
    flight.battery_v = 3.25
    assert flight.run_until(IDLE, most_s=60.0) == IDLE
    assert flight.fault == lib.MISSION_BATTERY_LOW
    assert flight.distance_m(0.0, 0.0) < 0.3


def test_an_empty_battery_lands_at_once() -> None:
    flight = hovering()
    flight.battery_v = 3.0
    assert flight.run_until(LAND, most_s=3.0) == LAND
    assert flight.fault == lib.MISSION_BATTERY_EMPTY


def test_a_short_dip_of_the_battery_is_load() -> None:
    flight = hovering()
    for volts in (3.0, 4.0) * 3:
        flight.battery_v = volts
        flight.run_for(1.0)
    assert flight.state == HOVER


@pytest.mark.parametrize(
    ("flags", "reason"),
    [(READY | lib.NAV_TUMBLED, "TUMBLED"), (READY & ~lib.NAV_CAN_FLY, "CANNOT_FLY")],
)
def test_what_cannot_fly_stops_its_motors(flags: int, reason: str) -> None:
    flight = hovering()
    flight.flags = flags
    assert not flight.step().motors
    assert flight.state == FAULT
    assert flight.fault == getattr(lib, f"MISSION_{reason}")


def test_frozen_ranges_land_it() -> None:
    flight = hovering()
    flight.sense, frozen = lambda: None, flight.sense  # type: ignore[method-assign]
    frozen()
    for _ in range(100):
        flight.time_ms += 20
        flight.input.odometry.time_ms = flight.time_ms
        flight.setpoint = lib.nav_step(flight.nav, flight.input)
    assert flight.state == LAND
    assert flight.fault == lib.MISSION_RANGES_FROZEN


def test_a_jump_of_the_estimate_lands_it() -> None:
    flight = hovering()
    flight.x_m += 1.0
    flight.step()
    assert flight.state == LAND
    assert flight.fault == lib.MISSION_ESTIMATOR


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


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("height_m", 0.0),
        ("height_m", float("nan")),
        ("clearance_m", -1.0),
        ("cell_m", 1.0),
        ("low_battery_v", float("inf")),
        ("lost_time_s", 0.0),
        ("planner", 7),
        ("slam", 9),
        ("lost", 200),
        ("area_min_m", (float("nan"), 0.0)),
        ("area_max_m", (1000.0, 0.0)),
    ],
)
def test_an_absurd_value_is_refused_and_changes_nothing(name: str, value: float) -> None:
    flight = hovering()
    before = raw_bytes(flight.nav)
    assert lib.nav_configure(flight.nav, new_config(**{name: value})) == lib.MISSION_BAD_VALUE
    assert raw_bytes(flight.nav) == before


def test_the_default_configuration_is_good() -> None:
    assert lib.nav_config_check(new_config()) == lib.MISSION_OK


def test_an_empty_area_does_not_take_off() -> None:
    cfg = new_config()
    cfg.area_min_m, cfg.area_max_m = (1.0, 1.0), (-1.0, -1.0)
    assert Flight(cfg=cfg).command(TAKE_OFF) == lib.MISSION_BAD_AREA


def test_events_that_nobody_took_leave_a_gap_in_the_sequence() -> None:
    flight = hovering()
    flight.listen = lambda: None  # type: ignore[method-assign]
    for _ in range(10):
        flight.command(lib.MISSION_CMD_SCAN)
        flight.step()
        flight.command(HOLD)
        flight.step()
    assert flight.nav.event_count == lib.NAV_EVENTS
    first = flight.nav.events[flight.nav.event_first].sequence
    assert first == flight.nav.event_sequence - lib.NAV_EVENTS
