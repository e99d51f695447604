# SPDX-License-Identifier: GPL-3.0-or-later
"""How nav reacts to trouble: link, battery, sensors, values, events."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import ffi, lib
from tests.core.maps import raw_bytes
from tests.core.room import READY, TWO_ROOMS, Flight, hovering, new_config

IDLE, HOVER, FAULT, LAND = (
    lib.MISSION_IDLE,
    lib.MISSION_HOVER,
    lib.MISSION_FAULT,
    lib.MISSION_LAND,
)
GOTO, TAKE_OFF, HOLD = lib.MISSION_CMD_GOTO, lib.MISSION_CMD_TAKE_OFF, lib.MISSION_CMD_HOLD


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


@pytest.mark.parametrize("beam", range(lib.SCAN_BEAMS))
def test_a_single_sensor_that_is_stuck_lands_it(beam: int) -> None:
    flight = hovering()
    sense, stuck_m = flight.sense, flight.input.range_m[beam]
    assert stuck_m > 0.0

    def broken() -> None:
        sense()
        flight.input.range_m[beam] = stuck_m

    flight.sense = broken  # type: ignore[method-assign]
    assert flight.run_until(LAND, most_s=20.0) == LAND
    assert flight.fault == lib.MISSION_BLIND


@pytest.mark.parametrize(
    ("gone", "positioning", "reason"),
    [
        ("FLOW_LOST", "NONE", "FLOW_LOST"),
        ("FLOW_LOST", "LIGHTHOUSE", "OK"),
        ("ESTIMATOR_SETTLED", "NONE", "ESTIMATOR"),
        ("ESTIMATOR_SETTLED", "LIGHTHOUSE", "ESTIMATOR"),
    ],
)
def test_without_what_tells_its_motion_it_lands(gone: str, positioning: str, reason: str) -> None:
    flight = hovering()
    flight.input.positioning = getattr(lib, f"NAV_POSITIONING_{positioning}")
    flight.run_for(1.0)
    flight.flags ^= getattr(lib, f"NAV_{gone}")
    flight.run_for(0.9)
    assert flight.state == HOVER, "over a dark tile"
    flight.run_for(1.0)
    assert flight.state == (HOVER if reason == "OK" else LAND)
    assert flight.fault == getattr(lib, f"MISSION_{reason}")


def test_a_jump_of_the_estimate_lands_it() -> None:
    flight = hovering()
    flight.x_m += 1.0
    flight.step()
    assert flight.state == LAND
    assert flight.fault == lib.MISSION_ESTIMATOR


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


def test_unsure_of_its_motion_it_stands_and_then_lands() -> None:
    flight = hovering()
    flight.command(GOTO, 1.4, 1.4)
    assert flight.run_until(lib.MISSION_FOLLOW) == lib.MISSION_FOLLOW
    flight.run_for(1.0)
    flight.flags &= ~lib.NAV_ESTIMATOR_SETTLED
    for _ in range(40):
        setpoint = flight.step()
        assert setpoint.yaw_rate_rps == 0.0
    assert math.hypot(*flight.velocity) < 0.1
    assert flight.run_until(IDLE, most_s=10.0) == IDLE
    assert flight.fault == lib.MISSION_ESTIMATOR


def test_a_hand_that_never_lets_it_rest_makes_it_land() -> None:
    flight = hovering()
    walls, states = list(flight.walls), set()
    for _ in range(200):
        x, y = flight.x_m + 0.25 * math.cos(flight.yaw_rad), flight.y_m
        y += 0.25 * math.sin(flight.yaw_rad)
        flight.walls = [
            *walls,
            (x - 0.1, y - 0.1, x + 0.1, y + 0.1),
            (x - 0.1, y + 0.1, x + 0.1, y - 0.1),
        ]
        flight.run_for(1.0)
        states.add(flight.state)
        if flight.state == IDLE:
            break
    assert {lib.MISSION_AVOID, IDLE} <= states
    assert flight.fault == lib.MISSION_STUCK


def test_with_nobody_listening_and_no_way_home_it_lands() -> None:
    flight = hovering(TWO_ROOMS)
    flight.command(GOTO, 1.8, 0.0)
    flight.step()
    assert flight.run_until(HOVER) == HOVER
    flight.walls.append((0.8, 1.1, 0.8, 2.0))
    flight.flags &= ~lib.NAV_LINK_ALIVE
    assert flight.run_until(IDLE, most_s=200.0) == IDLE
    assert flight.distance_m(0.0, 0.0) > 0.8


@given(st.floats(0.0625, 0.5, width=32))
def test_the_ground_is_told_the_size_of_a_cell_to_a_millimetre(cell_m: float) -> None:
    nav = ffi.new("nav_t *")
    lib.nav_init(nav, new_config(cell_m=cell_m))
    assert lib.nav_hello(nav).cell_mm == math.floor(1000 * cell_m + 0.5)
