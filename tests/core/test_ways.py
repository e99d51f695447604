# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths that are hard to find: gaps that rounding to cells closes, halls without returns."""

from ground.core import lib
from tests.core.room import ROOM, Flight, box_walls, new_config

HOVER, FAULT, LAND = (
    lib.MISSION_HOVER,
    lib.MISSION_FAULT,
    lib.MISSION_LAND,
)
GOTO = lib.MISSION_CMD_GOTO
DRONE_RADIUS_M = 0.07
GAP_M = 0.5
CELL_M = 0.1
WALL_X_M = 0.8


def slotted(gap_m: float) -> Flight:
    """A room with a wall across it, and a slot in that."""
    x_m = WALL_X_M
    lower, upper = (x_m, -2.0, x_m, -gap_m / 2), (x_m, gap_m / 2, x_m, 2.0)
    return Flight([*ROOM, lower, upper], new_config(cell_m=CELL_M))


def test_a_gap_that_only_rounding_closes_is_flown_through() -> None:
    flight = slotted(GAP_M)
    assert flight.command(GOTO, 1.9, -1.0) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT) == HOVER
    assert flight.distance_m(1.9, -1.0) < 0.25
    assert flight.nearest_m > DRONE_RADIUS_M + 0.03


def test_a_gap_that_is_too_narrow_is_refused_untouched() -> None:
    flight = slotted(0.2)
    flight.command(GOTO, 1.9, -1.0)
    assert flight.run_until(HOVER, FAULT) == HOVER
    refusals = [argument for code, argument in flight.events if code == lib.WIRE_EVENT_REFUSED]
    assert refusals == [lib.MISSION_GOAL_UNREACHABLE]
    assert flight.x_m < WALL_X_M
    assert flight.nearest_m > DRONE_RADIUS_M


def test_a_new_task_keeps_as_far_from_obstacles_as_it_is_told() -> None:
    flight = slotted(GAP_M)
    flight.command(GOTO, 1.9, -1.0)
    assert flight.run_until(HOVER, FAULT) == HOVER
    reach = flight.nav.clearance.reach
    flight.command(GOTO, 2.0, 0.0)
    assert flight.nav.clearance.reach > reach


def test_in_a_hall_a_beam_that_sees_nothing_for_long_is_not_taken_for_dead() -> None:
    flight = Flight([(-3.0, -1.0, 3.0, -1.0), *box_walls(-9.0, -9.0, 9.0, 9.0)])
    for x_m in (2.5, -2.5, 2.5):
        assert flight.command(GOTO, x_m, 0.0) == lib.MISSION_OK
        flight.step()
        assert flight.run_until(HOVER, FAULT, LAND) == HOVER
    assert lib.WIRE_EVENT_FAULT not in [code for code, _ in flight.events]
