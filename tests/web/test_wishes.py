# SPDX-License-Identifier: GPL-3.0-or-later
"""Requests of a page beyond plain commands: routes, area, spin, parameters; and their answers."""

import asyncio
import json
import math
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from ground.core import EventCode, MissionCmd, MissionState, RecordKind
from ground.errors import GroundError
from ground.link.rate import LinkRate
from ground.model import Console, History, LinkStats, Odometry, ParameterValue, Point, Pose, Record
from ground.requests import Outgoing, SetParameter, Waypoints
from ground.station.station import Station, station_on
from ground.web.cockpit import AREA, Cockpit
from ground.web.events import events_frame
from ground.web.frames import NOTHING, state_frame
from ground.web.parameters import parameters_frame
from ground.web.wishes import perform
from tests.ground.fakelink import FakeLink
from tests.ground.stations import event, telemetry


def with_cockpit(link: FakeLink, work: Callable[[Cockpit], Awaitable[None]]) -> None:
    async def run() -> None:
        async with station_on(link) as station:
            await work(Cockpit(station))

    asyncio.run(run())


def written(link: FakeLink) -> dict[str, float]:
    return {sent.name: sent.value for sent in link.sent if isinstance(sent, SetParameter)}


@pytest.mark.parametrize(("name", "cmd"), [("fly", MissionCmd.FLY), ("patrol", MissionCmd.PATROL)])
def test_way_points_are_given_and_then_flown(name: str, cmd: MissionCmd) -> None:
    link = FakeLink()
    points = [[0.5, 0], [1, 1.25], [-1, 2], [0, 0], [1, 0], [2, 0]]

    async def work(cockpit: Cockpit) -> None:
        await perform(cockpit, {"do": name, "points": points})

    with_cockpit(link, work)
    given = [point for sent in link.sent if isinstance(sent, Waypoints) for point in sent.points]
    assert given == [Point(float(x), float(y)) for x, y in points]
    assert [act.cmd for act in link.acts] == [cmd]


def test_an_area_is_written_whichever_corners_were_dragged() -> None:
    link = FakeLink()

    async def work(cockpit: Cockpit) -> None:
        await perform(cockpit, {"do": "area", "x0": 2.0, "y0": -1, "x1": -1.5, "y1": 3})

    with_cockpit(link, work)
    assert [written(link)[name] for name in AREA] == [-1.5, -1.0, 2.0, 3.0]


def test_a_spin_sets_its_turns_first() -> None:
    link = FakeLink()

    async def work(cockpit: Cockpit) -> None:
        await perform(cockpit, {"do": "spin", "turns": -2})

    with_cockpit(link, work)
    assert written(link) == {"way.turns": -2.0}
    assert [act.cmd for act in link.acts] == [MissionCmd.SPIN]


NONSENSE: list[dict[str, Any]] = [
    {"do": "fly"},
    {"do": "fly", "points": []},
    {"do": "fly", "points": [[1]]},
    {"do": "fly", "points": [[1, math.nan]]},
    {"do": "patrol", "points": [[0, 0]] * 13},
    {"do": "patrol", "points": [[0, 99]]},
    {"do": "area", "x0": 0, "y0": 0, "x1": 1},
    {"do": "area", "x0": 0, "y0": 0, "x1": 0.1, "y1": 3},
    {"do": "area", "x0": 0, "y0": 0, "x1": 10**400, "y1": 3},
    {"do": "spin", "turns": 21},
    {"do": "spin", "turns": True},
    {"do": "set", "name": "way.height", "value": 5},
    {"do": "set", "name": "way.planner", "value": 0.5},
    {"do": "set", "name": "pm.lowVoltage", "value": 1},
    {"do": "set", "name": "way.nothing", "value": 1},
]


@pytest.mark.parametrize("wish", NONSENSE, ids=str)
def test_nonsense_is_refused_with_words_and_nothing_is_sent(wish: dict[str, Any]) -> None:
    link = FakeLink()

    async def work(cockpit: Cockpit) -> None:
        with pytest.raises(GroundError) as refusal:
            await perform(cockpit, wish)
        assert str(refusal.value)

    with_cockpit(link, work)
    assert link.acts == []
    assert written(link) == {}


class Unwilling(FakeLink):
    """The app restores values that it refuses, and its console says why."""

    def send(self, message: Outgoing) -> None:
        super().send(message)
        if isinstance(message, SetParameter):
            words = f"WAYFLIE: {message.name} refused: a value is out of range\n"
            self.say(Console(words), ParameterValue(message.name, 0.4))


def test_what_the_drone_puts_back_is_told_with_its_reason() -> None:
    async def work(cockpit: Cockpit) -> None:
        with pytest.raises(GroundError, match=r"stays 0\.4: a value is out of range"):
            await perform(cockpit, {"do": "set", "name": "way.height", "value": 0.5})

    with_cockpit(Unwilling(), work)


def test_parameters_come_with_range_unit_and_help() -> None:
    station = Station(FakeLink())
    assert json.loads(parameters_frame(Cockpit(station)))["rows"] == []
    station.picture.take(ParameterValue("way.height", 0.6000000238), 0.0)
    (row,) = json.loads(parameters_frame(Cockpit(station)))["rows"]
    assert row.pop("help")
    assert row == {
        "group": "Flying",
        "name": "way.height",
        "type": "float",
        "min": 0.2,
        "max": 2.0,
        "default": 0.4,
        "value": 0.6,
        "unit": "m",
        "choices": [],
    }


def test_state_tells_area_odometry_and_the_last_correction() -> None:
    station = Station(FakeLink())
    cockpit = Cockpit(station)
    frame = json.loads(state_frame(cockpit, NOTHING)[0])
    assert (frame["area"], frame["odometry"], frame["status"]["correction"]) == (None, None, None)
    for name, value in zip(AREA, (-1.0, -2.0, 3.0, 4.0), strict=True):
        station.picture.take(ParameterValue(name, value), 0.0)
    pose = Pose(1.0, 2.0, 0.4, 0.25)
    station.picture.take(Odometry(5000, pose, 0.0, 0.0, 0.0, 0.0, 0.0), 0.0)
    station.picture.take(telemetry(5000, MissionState.FOLLOW, 1.0, 0.0), 0.0)
    moved = Record(3000, RecordKind.MATCHED, 0.03, 0.04, 0.0)
    station.picture.take_history(History(0, (moved,)), 1)
    frame = json.loads(state_frame(cockpit, NOTHING)[0])
    assert frame["area"] == [-1.0, -2.0, 3.0, 4.0]
    assert frame["odometry"] == [1.0, 2.0, 0.25]
    correction = frame["status"]["correction"]
    assert correction == {"ago_s": 2.0, "moved_m": pytest.approx(0.05), "turned_deg": 0.0}


def test_a_turn_moves_what_is_far_from_the_origin() -> None:
    station = Station(FakeLink())
    station.picture.take(telemetry(5000, MissionState.FOLLOW, 2.0, 0.0), 0.0)
    turned = Record(4000, RecordKind.MATCHED, 0.0, 0.0, 0.01)
    station.picture.take_history(History(0, (turned,)), 1)
    correction = json.loads(state_frame(Cockpit(station), NOTHING)[0])["status"]["correction"]
    assert correction["moved_m"] == pytest.approx(0.02, rel=0.01)
    assert correction["turned_deg"] == pytest.approx(math.degrees(0.01), abs=1e-3)


def test_the_log_is_whole_and_says_what_is_missing() -> None:
    station = Station(FakeLink())
    told = [event(EventCode.STATE, MissionState.HOVER, 100 * n) for n in range(30)]
    for one in told[5:]:
        station.picture.take(one, 0.0)
    frame = json.loads(events_frame(Cockpit(station)))
    assert [row["n"] for row in frame["rows"]] == [one.sequence for one in reversed(told[5:])]
    assert frame["missing"] == told[5].sequence


def test_the_link_rate_is_of_the_last_seconds() -> None:
    rate = LinkRate()
    for second in range(20):
        lost = 0 if second < 10 else 5 * (second - 9)
        rate.look(LinkStats(log_packets=20 * second, lost_packets=lost), float(second))
    assert rate.per_s == pytest.approx(20.0)
    assert rate.loss == pytest.approx(0.2)
