# SPDX-License-Identifier: GPL-3.0-or-later
"""What the page learns about a goal before the drone is sent: the route, or why it is refused."""

import dataclasses
import math

import numpy as np
import pytest

from ground.core import CellState, MissionReason, MissionState, SelfTest, Source
from ground.model import Health, Odometry, Point, Pose, Ranges, Telemetry
from ground.station.picture import Picture
from ground.web.insight import Known, frontiers, preview
from ground.web.people import LASTING_S, People

SIDE, CELL_M = 128, 0.05
ORIGIN = Point(-3.2, -3.2)
LEFT, RIGHT, BOTTOM, TOP = 20, 109, 30, 99  # cells of the room's walls
WALL, WALL_TO = 64, 80  # across the room, open above


def cell_of(place: Point) -> tuple[int, int]:
    """Row and column of a cell."""
    return (
        math.floor((place.y_m - ORIGIN.y_m) / CELL_M),
        math.floor((place.x_m - ORIGIN.x_m) / CELL_M),
    )


def room() -> np.ndarray:
    """Two halves, connected at the upper end of a wall."""
    states = np.zeros((SIDE, SIDE), np.uint8)
    states[BOTTOM : TOP + 1, LEFT : RIGHT + 1] = CellState.FREE
    states[[BOTTOM, TOP], LEFT : RIGHT + 1] = CellState.OCCUPIED
    states[BOTTOM : TOP + 1, [LEFT, RIGHT]] = CellState.OCCUPIED
    states[BOTTOM:WALL_TO, WALL] = CellState.OCCUPIED
    return states


HERE = Pose(-1.0, -0.5, 0.4, 0.0)
THERE = Point(1.0, -0.5)
FLYING = Known(room(), ORIGIN, CELL_M, HERE, MissionState.HOVER)
WELL = Health(0, 4.0, 0.0, 0, 0, 0, 0, 0, supervisor=1 << 3, self_test=SelfTest.NOT_RUN)


def with_states(states: np.ndarray) -> Known:
    return dataclasses.replace(FLYING, states=states)


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        (Point(0.02, -1.0), MissionReason.GOAL_OCCUPIED),  # in the wall
        (Point(0.15, -1.0), MissionReason.GOAL_OCCUPIED),  # too near to it
        (Point(3.0, 3.0), MissionReason.GOAL_UNREACHABLE),  # behind the walls
        (Point(3.3, 0.0), MissionReason.OUTSIDE_GRID),
        (Point(math.nan, 0.0), MissionReason.BAD_VALUE),
        (Point(math.inf, 0.0), MissionReason.BAD_VALUE),
    ],
)
def test_a_goal_that_cannot_be_is_refused_with_the_reason(
    goal: Point, reason: MissionReason
) -> None:
    answer = preview(FLYING, goal)
    assert (answer.reason, answer.path) == (reason, ())
    assert answer.words


def test_outside_the_area_is_refused() -> None:
    fenced = dataclasses.replace(FLYING, parameters=(("way.areaX1", 0.9),))
    assert preview(fenced, THERE).reason is MissionReason.OUTSIDE_AREA
    assert preview(fenced, Point(0.5, 0.9)).reason is MissionReason.OK


def test_the_way_leads_there_and_keeps_its_distance() -> None:
    answer = preview(FLYING, THERE)
    assert answer.reason is MissionReason.OK
    assert math.dist(dataclasses.astuple(answer.path[-1]), (THERE.x_m, THERE.y_m)) < 0.01
    assert answer.length_m > 3.5, "around the wall"
    assert answer.seen_m == answer.length_m
    assert answer.words == f"{answer.length_m:.1f} m to fly"
    rows, columns = np.nonzero(FLYING.states == CellState.OCCUPIED)
    for a, b in zip(answer.path, answer.path[1:], strict=False):
        for share in np.linspace(0.0, 1.0, 20):
            row = (a.y_m + share * (b.y_m - a.y_m) - ORIGIN.y_m) / CELL_M
            column = (a.x_m + share * (b.x_m - a.x_m) - ORIGIN.x_m) / CELL_M
            off = np.hypot(
                np.maximum(np.abs(rows + 0.5 - row) - 0.5, 0),
                np.maximum(np.abs(columns + 0.5 - column) - 0.5, 0),
            )
            assert off.min() * CELL_M > 0.15


def test_a_way_can_begin_elsewhere() -> None:
    answer = preview(FLYING.seen_from(Point(1.0, 0.5)), THERE)
    assert answer.length_m == pytest.approx(1.0, abs=0.05)
    blocked = FLYING.seen_from(Point(3.1, 3.1))
    assert preview(blocked, THERE).reason is MissionReason.GOAL_UNREACHABLE


def test_a_wider_clearance_closes_a_narrow_way() -> None:
    states = room()
    states[WALL_TO : TOP - 9, WALL] = CellState.OCCUPIED  # leaves 0.45 m
    assert preview(with_states(states), THERE).reason is MissionReason.OK
    shy = dataclasses.replace(with_states(states), parameters=(("way.clearance", 0.3),))
    assert preview(shy, THERE).reason is MissionReason.GOAL_UNREACHABLE


def test_what_nobody_has_seen_is_said() -> None:
    states = room()
    states[:, WALL + 10 : RIGHT] = CellState.UNKNOWN
    answer = preview(with_states(states), THERE)
    assert answer.reason is MissionReason.OK
    assert 0.5 < answer.seen_m < answer.length_m - 0.3
    assert "not seen yet" in answer.words


def test_on_the_ground_it_must_be_fit_to_fly() -> None:
    standing = dataclasses.replace(FLYING, state=MissionState.IDLE, health=WELL)
    assert preview(standing, THERE).reason is MissionReason.OK
    flat = dataclasses.replace(WELL, battery_v=3.2)
    locked = dataclasses.replace(WELL, supervisor=1 << 6)
    assert preview(dataclasses.replace(standing, health=flat), THERE).reason is (
        MissionReason.BATTERY_LOW
    )
    assert preview(dataclasses.replace(standing, health=locked), THERE).reason is (
        MissionReason.CANNOT_FLY
    )
    assert preview(dataclasses.replace(FLYING, health=flat), THERE).reason is MissionReason.OK


def test_the_tree_is_the_planners_own() -> None:
    answer = preview(FLYING, THERE)
    assert answer.tree
    occupied = {tuple(cell) for cell in np.argwhere(FLYING.states == CellState.OCCUPIED)}
    for x0, y0, x1, y1 in answer.tree:
        assert {cell_of(Point(x0, y0)), cell_of(Point(x1, y1))}.isdisjoint(occupied)


def test_a_known_room_has_no_frontiers() -> None:
    assert frontiers(FLYING) == ()


def test_frontiers_lie_where_the_room_was_not_seen() -> None:
    states = room()
    states[:, WALL + 10 :] = CellState.UNKNOWN
    found = frontiers(with_states(states))
    assert sum(f.first for f in found) == 1
    assert all(f.gain_cells >= 40 for f in found)
    for frontier in found:
        row, column = cell_of(frontier.place)
        assert states[row, column] == CellState.FREE
        assert column == WALL + 9
    best = next(f for f in found if f.first)
    assert cell_of(best.place)[0] > WALL_TO - 15, "beside the way through"


def test_nothing_is_known_before_the_drone_spoke() -> None:
    assert Known.of(Picture()) is None


def test_what_is_known_is_a_copy() -> None:
    picture = seeing(None)
    known = Known.of(picture)
    assert known is not None
    picture.map.states.fill(CellState.OCCUPIED)
    picture.parameters["way.clearance"] = 0.5
    assert (known.states == room()).all()
    assert known.parameters == ()


# --- people --------------------------------------------------------------------------------------


def seeing(front_m: float | None, drone_ms: int = 1000, yaw_rate_rps: float = 0.0) -> Picture:
    """A drone in the room that looks ahead."""
    picture = Picture()
    picture.map.states[:] = room()
    picture.take(
        Telemetry(drone_ms, HERE, Point(0.0, 0.0), MissionState.HOVER, MissionReason.OK, 100),
        0.0,
    )
    picture.take(Ranges(drone_ms, front_m, None, None, None, None), 0.0)
    picture.take(Odometry(drone_ms, HERE, 0.0, 0.0, 0.0, 0.0, yaw_rate_rps), 0.0)
    picture.source = Source.SLAM
    return picture


def test_an_echo_in_free_space_is_somebody() -> None:
    (place,) = People().look(seeing(0.5), 0.0)
    assert place.x_m == pytest.approx(HERE.x_m + 0.5, abs=0.05)
    assert place.y_m == pytest.approx(HERE.y_m, abs=0.01)


@pytest.mark.parametrize(
    "picture",
    [seeing(1.0), seeing(0.9), seeing(None), seeing(0.5, yaw_rate_rps=1.0)],
    ids=["the wall", "near the wall", "no echo", "turning"],
)
def test_what_the_map_explains_is_nobody(picture: Picture) -> None:
    assert People().look(picture, 0.0) == ()


def test_a_set_of_ranges_is_looked_at_once() -> None:
    people = People()
    assert people.look(seeing(0.5), 0.0)
    assert people.look(seeing(0.5), 0.1) == ()
    assert people.look(seeing(0.5, drone_ms=1100), 0.2)


def test_who_is_drawn_into_the_map_is_still_somebody_and_then_a_thing() -> None:
    people, drawn = People(), seeing(0.5, drone_ms=1100)
    assert people.look(seeing(0.5), 0.0)
    drawn.map.states[cell_of(Point(HERE.x_m + 0.5, HERE.y_m))] = CellState.OCCUPIED
    drawn.map.revision += 1
    assert people.look(drawn, 1.0)
    drawn.take(Ranges(2000, 0.5, None, None, None, None), 0.0)
    assert people.look(drawn, 1.1 + LASTING_S) == ()


def test_a_drone_that_does_not_correct_itself_tells_of_nobody() -> None:
    picture = seeing(0.5)
    picture.source = Source.ODOMETRY
    assert People().look(picture, 0.0) == ()
