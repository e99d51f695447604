# SPDX-License-Identifier: GPL-3.0-or-later
"""Flying by hand: the drone follows the stick, but never into a wall or too far."""

import cmath
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ground.core import MissionCmd, MissionReason, ffi, lib
from tests.core.room import ROOM, TICK_MS, Flight, gap_m, hovering, new_config

STICK_MS = 60  # as often as the ground sends
DRONE_RADIUS_M = 0.07


def steer(
    flight: Flight, ahead: float = 0.0, left: float = 0.0, turn: float = 0.0, up: float = 0.0
) -> MissionReason:
    stick = ffi.new("wire_steer_t *", (1, (ahead, left), turn, up))
    return MissionReason(lib.nav_steer(flight.nav, stick))


def held(flight: Flight, time_s: float, **stick: float) -> set[MissionReason]:
    """Hold this stick for some time; return all answers."""
    answers = set()
    for tick in range(round(1000 * time_s / TICK_MS)):
        if tick % (STICK_MS // TICK_MS) == 0:
            answers.add(steer(flight, **stick))
        flight.step()
    return answers


def settled(flight: Flight) -> Flight:
    """Let it hover until its heading rests, since a hovering drone looks to and fro."""
    held(flight, 1.0)
    return flight


@pytest.fixture
def flight() -> Flight:
    return settled(hovering())


@pytest.mark.parametrize(("ahead", "left"), [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -0.3)])
def test_it_flies_where_the_stick_points(flight: Flight, ahead: float, left: float) -> None:
    x_m, y_m, yaw_rad = flight.x_m, flight.y_m, flight.yaw_rad
    assert held(flight, 2.0, ahead=ahead, left=left) == {MissionReason.OK}
    went_m = complex(flight.x_m - x_m, flight.y_m - y_m)
    wanted = complex(ahead, left) * complex(math.cos(yaw_rad), math.sin(yaw_rad))
    assert abs(went_m - 2.0 * wanted) < 0.12
    assert flight.state == lib.MISSION_HOVER


def test_let_go_it_stands_within_half_a_second_and_stays(flight: Flight) -> None:
    held(flight, 1.5, ahead=0.5)
    held(flight, 0.5)
    assert math.hypot(*flight.velocity) < 0.05
    x_m, y_m = flight.x_m, flight.y_m
    flight.run_for(6.0)
    assert flight.distance_m(x_m, y_m) < 0.06
    assert flight.state == lib.MISSION_HOVER


def test_without_another_stick_it_comes_to_rest_by_itself(flight: Flight) -> None:
    held(flight, 1.0, ahead=0.5)
    flight.run_for(0.5)
    assert math.hypot(*flight.velocity) > 0.3, "the last one counts for half a second"
    flight.run_for(0.5)
    assert math.hypot(*flight.velocity) < 0.05
    x_m, y_m = flight.x_m, flight.y_m
    flight.run_for(5.0)
    assert flight.distance_m(x_m, y_m) < 0.06


@pytest.mark.parametrize("ahead", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("turned_rad", [0.0, 0.4, math.pi / 2, 3.0])
def test_the_guard_keeps_it_from_the_wall(ahead: float, turned_rad: float) -> None:
    flight = hovering()
    flight.nav.cfg.follower.speed_mps = 1.0
    settled(flight)
    while abs(math.remainder(flight.yaw_rad - turned_rad, math.tau)) > 0.05:
        held(flight, 0.06, turn=0.5)
    held(flight, 12.0, ahead=ahead)
    assert flight.nearest_m > DRONE_RADIUS_M + 0.05
    assert flight.state in (lib.MISSION_HOVER, lib.MISSION_AVOID)


def test_it_maps_meanwhile(flight: Flight) -> None:
    known = flight.nav.status.known_cells
    held(flight, 3.0, ahead=0.4)
    assert flight.nav.status.known_cells > known


@pytest.mark.parametrize("side", [1, 1j, -1, -1j])
def test_the_fence_holds_on_every_side(side: complex) -> None:
    flight = Flight(list(ROOM), new_config())
    flight.nav.cfg.area_min_m, flight.nav.cfg.area_max_m = (-1.0, -1.0), (1.0, 1.0)
    flight.nav.cfg.follower.speed_mps = 1.0
    assert flight.command(MissionCmd.TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(lib.MISSION_HOVER) == lib.MISSION_HOVER
    settled(flight)
    for speed_mps, seconds, nearest_m, farthest_m in ((1.0, 6.0, 0.9, 1.05), (-0.3, 2.0, 0.2, 0.6)):
        stick = speed_mps * side * cmath.rect(1.0, -flight.yaw_rad)
        held(flight, seconds, ahead=stick.real, left=stick.imag)
        off = complex(flight.x_m, flight.y_m) / side
        assert nearest_m < off.real < farthest_m
        assert abs(off.imag) < 0.2


def test_it_turns_and_keeps_its_new_heading(flight: Flight) -> None:
    before_rad = flight.yaw_rad
    held(flight, 1.5, turn=0.6)
    assert math.remainder(flight.yaw_rad - before_rad, math.tau) == pytest.approx(0.9, abs=0.1)
    x_m, y_m = flight.x_m, flight.y_m
    held(flight, 1.0)
    assert flight.distance_m(x_m, y_m) < 0.05


@pytest.mark.parametrize(("up", "limit_m"), [(1.0, 2.0), (-1.0, 0.2)])
def test_height_stays_within_its_limits_and_where_it_was_left(
    flight: Flight, up: float, limit_m: float
) -> None:
    held(flight, 6.0, up=up)
    assert flight.z_m == pytest.approx(limit_m, abs=0.02)
    flight.run_for(3.0)
    assert flight.z_m == pytest.approx(limit_m, abs=0.02)
    assert flight.command(MissionCmd.GOTO, 0.0, 0.5) == lib.MISSION_OK
    flight.run_for(5.0)
    assert flight.z_m == pytest.approx(flight.nav.cfg.height_m, abs=0.05), (
        "a task flies as it is set"
    )


def test_it_does_not_climb_into_a_ceiling(flight: Flight) -> None:
    before_m = flight.z_m
    for _ in range(100):
        flight.measured_m[lib.SCAN_UP] = flight.ranges_m[lib.SCAN_UP] = 0.35
        steer(flight, up=0.4)
        flight.step()
    assert flight.z_m < before_m + 0.05


NOT_A_STICK = [math.nan, math.inf, -math.inf, 4.1, -1.0e30]


@pytest.mark.parametrize("part", ["ahead", "left", "turn", "up"])
@pytest.mark.parametrize("value", NOT_A_STICK)
def test_no_number_and_what_is_out_of_range_are_refused(
    flight: Flight, part: str, value: float
) -> None:
    x_m, y_m = flight.x_m, flight.y_m
    assert held(flight, 0.5, **{part: value}) == {MissionReason.BAD_VALUE}
    assert flight.distance_m(x_m, y_m) < 0.05


def test_it_is_steered_only_while_it_holds_its_place() -> None:
    flight = Flight(list(ROOM))
    assert steer(flight, ahead=0.3) is MissionReason.NOT_FLYING
    assert flight.command(MissionCmd.TAKE_OFF) == lib.MISSION_OK
    flight.step()
    assert steer(flight, ahead=0.3) is MissionReason.BUSY
    assert flight.run_until(lib.MISSION_HOVER) == lib.MISSION_HOVER
    assert steer(flight, ahead=0.3) is MissionReason.OK
    assert flight.command(MissionCmd.LAND) == lib.MISSION_OK
    flight.step()
    assert steer(flight, ahead=0.3) is MissionReason.BUSY
    assert flight.run_until(lib.MISSION_IDLE) == lib.MISSION_IDLE


def test_a_hundred_sticks_into_a_wall_are_no_reason_to_land(flight: Flight) -> None:
    for _ in range(30):
        held(flight, 2.0, ahead=0.5)
        held(flight, 2.0, ahead=-0.1)
    assert flight.state in (lib.MISSION_HOVER, lib.MISSION_AVOID)


parts = st.floats(-1.0, 1.0)


@given(st.lists(st.tuples(parts, parts, parts, parts), min_size=3, max_size=6))
@settings(max_examples=8, deadline=None)
def test_whoever_steers_hits_nothing(sticks: list[tuple[float, float, float, float]]) -> None:
    flight = hovering()
    for ahead, left, turn, up in sticks:
        scale = 2.0 / max(2.0, math.hypot(ahead, left) + abs(turn) + abs(up))
        held(flight, 2.0, ahead=scale * ahead, left=scale * left, turn=scale * turn, up=scale * up)
    assert flight.nearest_m > DRONE_RADIUS_M


def test_a_wall_that_it_is_flown_up_to_is_nobody_who_comes() -> None:
    flight = settled(hovering())
    lib.nav_command(flight.nav, ffi.new("nav_command_t *", (MissionCmd.FORGET, (0.0, 0.0))))
    assert flight.run_until(lib.MISSION_HOVER) == lib.MISSION_HOVER
    flight.states.clear()
    while gap_m(flight.walls, flight.x_m, flight.y_m) > 0.5:
        held(flight, 0.06, left=0.3)
    assert flight.states == [lib.MISSION_HOVER]
