# SPDX-License-Identifier: GPL-3.0-or-later
"""Lost in a known map: the drone notices, relocalises, draws nothing meanwhile, and continues."""

import itertools
import math

import pytest

from ground.core import CData, ffi, lib
from tests.core.room import Flight, Segment, box_walls, hovering

IDLE, HOVER, LAND, FAULT = (
    lib.MISSION_IDLE,
    lib.MISSION_HOVER,
    lib.MISSION_LAND,
    lib.MISSION_FAULT,
)
RELOCALISE = lib.MISSION_RELOCALISE
GOTO, RELOCALISE_CMD = lib.MISSION_CMD_GOTO, lib.MISSION_CMD_RELOCALISE
HOME_WALLS = [
    *box_walls(-2.0, -1.6, 2.6, 1.8),
    *box_walls(1.4, -1.6, 2.6, -0.7),
    *box_walls(-2.0, 0.7, -1.3, 1.3),
    *box_walls(0.3, 1.3, 1.1, 1.8),
]
PLACES = [(-1.2, -0.9, 2.0), (1.8, 0.9, -1.0), (0.4, -0.5, 0.3)]
CORRIDOR = box_walls(-2.0, -0.45, 2.0, 0.45)
ALCOVE = [*box_walls(-2.0, -0.45, 2.0, 0.45), *box_walls(0.6, 0.45, 1.6, 1.6)]
EMPTY_PLACE = box_walls(-1.0, -1.0, 1.0, 1.0)


def mapped() -> Flight:
    """A drone that has explored its home and landed."""
    flight = hovering(HOME_WALLS)
    assert flight.command(lib.MISSION_CMD_EXPLORE) == lib.MISSION_OK
    assert flight.run_until(IDLE, FAULT, most_s=400.0) == IDLE
    return flight


def carried(flight: Flight, place: tuple[float, float, float]) -> Flight:
    """Lift the drone and put it down there."""
    for _ in range(50):
        flight.z_m = 0.6
        flight.sense()
        lib.nav_step(flight.nav, flight.input)
        flight.time_ms += 20
    flight.carry(*place)
    flight.run_for(0.5)
    return flight


def off_m(flight: Flight) -> float:
    """Distance of the map pose to the truth; the map frame is the room's here."""
    return flight.distance_m(flight.nav.pose.x_m, flight.nav.pose.y_m)


def cells(flight: Flight) -> bytes:
    return bytes(ffi.buffer(flight.nav.grid.cells))


@pytest.fixture(scope="module")
def explored() -> bytes:
    """The whole state of a nav that has explored, to start from again."""
    return bytes(ffi.buffer(mapped().nav))


def again(explored: bytes) -> Flight:
    flight = Flight(list(HOME_WALLS))
    ffi.memmove(flight.nav, explored, len(explored))
    flight.time_ms = flight.nav.input.odometry.time_ms + 20
    flight.x_m, flight.y_m = flight.nav.input.odometry.pose.x_m, flight.nav.input.odometry.pose.y_m
    flight.yaw_rad = flight.nav.input.odometry.pose.yaw_rad
    return flight


@pytest.mark.parametrize("place", PLACES)
def test_carried_elsewhere_it_finds_itself_and_reaches_its_goal(
    explored: bytes, place: tuple[float, float, float]
) -> None:
    flight = carried(again(explored), place)
    assert flight.nav.mission.lost and flight.nav.status.confidence == 0
    assert flight.command(GOTO, 0.5, 0.3) == lib.MISSION_OK
    assert flight.run_until(RELOCALISE) == RELOCALISE
    before = cells(flight)
    while flight.state == RELOCALISE:
        assert cells(flight) == before
        flight.step()
    assert (lib.WIRE_EVENT_FOUND, 0) in flight.events
    assert not any(bytes(ffi.buffer(ffi.addressof(flight.nav, "planner")))), "its memory is shared"
    assert off_m(flight) < 0.15
    assert flight.run_until(HOVER, FAULT, LAND) == HOVER
    assert flight.distance_m(0.5, 0.3) < 0.25
    assert flight.nearest_m > 0.1


def test_home_is_where_it_took_off_though_it_did_not_know_where_that_was(explored: bytes) -> None:
    flight = carried(again(explored), PLACES[0])
    assert flight.command(lib.MISSION_CMD_TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT, LAND) == HOVER
    assert flight.command(lib.MISSION_CMD_HOME) == lib.MISSION_OK
    assert flight.run_until(IDLE, FAULT) == IDLE
    assert flight.distance_m(*PLACES[0][:2]) < 0.3


def test_in_a_place_that_is_not_in_its_map_it_lands_and_says_so(explored: bytes) -> None:
    flight = again(explored)
    flight.walls = EMPTY_PLACE
    carried(flight, (0.1, -0.2, 0.5))
    before = cells(flight)
    assert flight.command(GOTO, 0.5, 0.3) == lib.MISSION_OK
    assert flight.run_until(LAND, HOVER, FAULT) == LAND
    assert flight.run_until(IDLE) == IDLE
    assert flight.fault == lib.MISSION_LOST
    assert (lib.WIRE_EVENT_FAULT, lib.MISSION_LOST) in flight.events
    assert cells(flight) == before and flight.nav.mission.lost


def test_told_to_in_the_air_it_looks_for_itself_whatever_it_believed(explored: bytes) -> None:
    flight = again(explored)
    assert flight.command(RELOCALISE_CMD) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT, LAND) == HOVER
    assert flight.command(RELOCALISE_CMD) == lib.MISSION_OK
    assert flight.run_until(RELOCALISE) == RELOCALISE
    assert flight.run_until(HOVER, FAULT, LAND) == HOVER
    assert off_m(flight) < 0.15 and not flight.nav.mission.lost


def test_a_tumble_makes_it_doubt_its_pose(explored: bytes) -> None:
    flight = again(explored)
    assert flight.command(lib.MISSION_CMD_TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(HOVER) == HOVER
    flight.flags |= lib.NAV_TUMBLED
    flight.step()
    assert flight.state == FAULT and flight.nav.mission.lost


@pytest.mark.parametrize("place", PLACES[:2])
def test_carried_elsewhere_in_flight_it_notices_and_finds_itself(
    explored: bytes, place: tuple[float, float, float]
) -> None:
    flight = again(explored)
    assert flight.command(lib.MISSION_CMD_TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(HOVER) == HOVER
    flight.run_for(5.0)
    assert not flight.nav.mission.lost
    flight.carry(*place)
    assert flight.command(GOTO, 0.3, -0.2) == lib.MISSION_OK
    assert flight.run_until(RELOCALISE, most_s=30.0) == RELOCALISE
    assert flight.fault == lib.MISSION_LOST
    assert flight.run_until(HOVER, LAND, most_s=120.0) == HOVER
    assert off_m(flight) < 0.2


def test_standing_on_the_ground_it_does_not_lose_itself(explored: bytes) -> None:
    flight = again(explored)
    flight.run_for(5.0)
    assert not flight.nav.mission.lost


def test_a_height_that_errs_for_a_moment_is_no_hand_that_lifts_it(explored: bytes) -> None:
    flight = again(explored)
    for ticks, lost in ((15, False), (30, True)):
        for _ in range(ticks):
            flight.z_m = 0.6
            flight.sense()
            lib.nav_step(flight.nav, flight.input)
            flight.time_ms += 20
        assert flight.nav.mission.lost == lost
        flight.run_for(0.1)


def farthest(flight: Flight, came_rad: float | None) -> float:
    """Direction of the longest beam with room in it; back only if no other has."""
    pose, ranges_m = flight.nav.pose, flight.input.range_m
    reach_m: dict[float, float] = {
        pose.yaw_rad + lib.scan_bearing_rad(beam): ranges_m[beam] if ranges_m[beam] >= 0 else 1.2
        for beam in range(lib.SCAN_BEAMS)
    }
    roomy = {way for way, range_m in reach_m.items() if range_m > 0.55}
    if came_rad is not None:
        onward = {way for way in roomy if abs(math.remainder(way - came_rad, math.tau)) < 2.35}
        roomy = onward or roomy
    return max(roomy, key=reach_m.__getitem__)


@pytest.mark.parametrize(
    ("walls", "place", "least"),
    [
        (HOME_WALLS, PLACES[0], 1),
        (CORRIDOR, (1.4, 0.0, 0.1), 4),
        (CORRIDOR, (-1.4, 0.05, 0.0), 4),
        (ALCOVE, (1.3, 0.0, 0.0), 4),
    ],
)
def test_it_moves_where_a_beam_reaches_farthest_and_back_only_from_an_end(
    explored: bytes, walls: list[Segment], place: tuple[float, float, float], least: int
) -> None:
    flight = again(explored)
    flight.walls = walls
    carried(flight, place)
    assert flight.command(lib.MISSION_CMD_TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(RELOCALISE) == RELOCALISE
    motion = flight.nav.reloc_motion
    moves: list[float] = []
    turns: list[tuple[int, bool]] = []  # after how many moves, and whether to the left
    while flight.state == RELOCALISE:
        moving = motion.moving
        flight.sense()
        wanted_rad = farthest(flight, moves[-1] if moves else None)
        flight.step()
        if motion.moving and not moving:
            assert abs(math.remainder(motion.came_rad - wanted_rad, math.tau)) < 0.05
            moves.append(motion.came_rad)
        if not motion.moving and not moving and flight.setpoint.yaw_rate_rps:
            turns.append((len(moves), flight.setpoint.yaw_rate_rps > 0.0))
    senses = [left for (_, left), _ in itertools.groupby(turns)]
    assert all(a != b for a, b in itertools.pairwise(senses)), "errors of the gyro cancel out"
    assert len(moves) >= least


def test_without_a_map_there_is_nothing_to_look_in() -> None:
    assert Flight().command(RELOCALISE_CMD) == lib.MISSION_NO_MAP


def test_forgetting_the_map_ends_being_lost(explored: bytes) -> None:
    flight = carried(again(explored), PLACES[1])
    assert flight.command(lib.MISSION_CMD_FORGET) == lib.MISSION_OK
    assert not flight.nav.mission.lost
    assert flight.command(GOTO, 0.4, 0.0) == lib.MISSION_OK
    assert flight.run_until(HOVER, RELOCALISE, FAULT) == HOVER


def pieces(nav: CData) -> list[CData]:
    """The whole map in tiles, as the ground keeps it."""
    kept = []
    for _ in range(2 * lib.GRID_TILES):
        piece = ffi.new("uint8_t[]", lib.WIRE_MAP_BYTES)
        lib.nav_next_map_piece(nav, piece)
        kept.append(piece)
    return kept


def states(flight: Flight) -> list[int]:
    side = range(lib.GRID_SIDE_CELLS)
    return [lib.grid_state(ffi.addressof(flight.nav, "grid"), ix, iy) for iy in side for ix in side]


def test_after_a_restart_it_takes_its_map_back_and_finds_itself_in_it(explored: bytes) -> None:
    old = again(explored)
    lib.nav_resend_map(old.nav)
    kept = pieces(old.nav)
    flight = Flight(list(HOME_WALLS))
    flight.nav.epoch = old.nav.epoch
    flight.carry(*PLACES[2])
    assert all(lib.nav_take_map_piece(flight.nav, piece) for piece in kept)
    assert states(flight) == states(old)
    assert flight.command(GOTO, -0.8, 0.2) == lib.MISSION_OK
    assert flight.run_until(HOVER, FAULT, LAND) == HOVER
    assert RELOCALISE in flight.states and off_m(flight) < 0.15
    assert flight.distance_m(-0.8, 0.2) < 0.25


def test_a_piece_is_refused_in_the_air_damaged_or_of_another_map(explored: bytes) -> None:
    piece = pieces(again(explored).nav)[0]
    flying = hovering(HOME_WALLS)
    assert not lib.nav_take_map_piece(flying.nav, piece)
    flight = again(explored)
    other = bytearray(ffi.buffer(piece))
    other[3] ^= 1
    assert not lib.nav_take_map_piece(flight.nav, ffi.from_buffer("uint8_t[]", bytes(other)))
    flight.nav.epoch = (flight.nav.epoch + 1) % lib.WIRE_MAP_EPOCHS
    assert not lib.nav_take_map_piece(flight.nav, piece)
    assert not flight.nav.mission.lost


def test_it_turns_to_and_fro_while_it_looks(explored: bytes) -> None:
    flight = carried(again(explored), PLACES[0])
    assert flight.command(lib.MISSION_CMD_TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(RELOCALISE) == RELOCALISE
    turned, rates = 0.0, set()
    while flight.state == RELOCALISE:
        rate = flight.step().yaw_rate_rps
        turned += rate * 0.02
        rates.add(math.copysign(1.0, rate) if abs(rate) > 0.5 else 0.0)
    assert {1.0, -1.0} <= rates
    assert turned < 2.0 * math.tau
