# SPDX-License-Identifier: GPL-3.0-or-later
"""The station when links change and drones restart, and with answers meant for others."""

import asyncio
from collections.abc import Callable
from dataclasses import replace

import pytest

from ground.core import CellState, EventCode, MissionCmd, MissionReason, MissionState, RecordKind
from ground.errors import LinkLost
from ground.model import (
    Ack,
    Beat,
    Event,
    History,
    LinkChange,
    LinkState,
    MapPiece,
    ParameterValue,
    Point,
    Record,
)
from ground.requests import (
    Command,
    EmergencyStop,
    HelloRequest,
    Outgoing,
    SetParameter,
    SnapshotRequest,
)
from ground.station.station import Station, station_on
from tests.ground.fakelink import LOCKED, FakeLink
from tests.ground.stations import GOAL, heard, packet_of, telemetry, with_station

ANEW = LinkChange(LinkState.RESTARTED, "the drone was restarted")
PIECE = MapPiece(0, 0, bytes([CellState.FREE] * 64), ())


def deaf_to(*kinds: type[Outgoing]) -> FakeLink:
    """A link that acknowledges nothing of these kinds."""
    return FakeLink(lambda message: not isinstance(message, kinds))


def test_nothing_of_a_flight_is_left_when_the_drone_begins_anew() -> None:
    link = FakeLink()

    async def work(station: Station) -> None:
        link.say(telemetry(100, MissionState.HOVER), packet_of(PIECE))
        await heard(link)
        assert station.picture.map.known_cells == 64
        link.say(ANEW)
        await heard(link)
        assert station.picture.telemetry is None
        assert station.picture.map.known_cells == 0

    with_station(link, work)


def test_over_a_link_that_is_there_again_everything_is_asked_for() -> None:
    link = FakeLink()

    async def work(station: Station) -> None:
        asked = link.sent.count(SnapshotRequest())
        link.say(LinkChange(LinkState.RECONNECTING, "looking for the drone"))
        link.say(LinkChange(LinkState.CONNECTED, "connected"))
        await heard(link)
        assert link.sent.count(SnapshotRequest()) == asked + 1
        link.say(LinkChange(LinkState.SILENT, "nothing heard"))
        link.say(LinkChange(LinkState.CONNECTED, "heard again"))
        await heard(link)
        assert link.sent.count(SnapshotRequest()) == asked + 1

    with_station(link, work)


def test_a_map_that_was_begun_anew_lies_where_hello_says() -> None:
    link = FakeLink()

    async def work(station: Station) -> None:
        link.say(packet_of(PIECE))
        await heard(link)
        asked = link.count(HelloRequest)
        link._hears = lambda message: False
        link.say(packet_of(replace(PIECE, epoch=1)))
        await heard(link)
        assert link.count(HelloRequest) == asked + 1

    with_station(link, work)


@pytest.mark.parametrize("request_of", [Command, SetParameter])
def test_who_waits_for_an_answer_is_told_that_the_drone_began_anew(
    request_of: type[Outgoing],
) -> None:
    link = deaf_to(request_of)

    async def work(station: Station) -> None:
        asyncio.get_running_loop().call_soon(link.say, ANEW)
        if request_of is Command:
            await station.command(MissionCmd.GOTO, GOAL)
        else:
            await station.set_parameter("way.height", 0.5)

    with pytest.raises(LinkLost, match="restarted"):
        with_station(link, work)


def test_who_waits_for_the_end_is_told_whether_the_link_was_lost() -> None:
    async def ended(end: Callable[[FakeLink], object]) -> None:
        link = FakeLink()
        async with station_on(link) as station:
            end(link)
            await station.ended()

    asyncio.run(ended(lambda link: link._inbox.put_nowait(None)))
    with pytest.raises(LinkLost, match="broken"):
        asyncio.run(ended(FakeLink.lose))


def refused_by_others(link: FakeLink) -> Callable[[Command], None]:
    """Before the right answer comes one to somebody else's command."""
    return lambda command: link.say(
        Ack((command.sequence + 1) % (1 << 16), command.cmd, MissionReason.BUSY)
    )


def test_the_answer_to_another_command_is_not_taken() -> None:
    link = FakeLink()
    link.on_command = refused_by_others(link)
    with_station(link, lambda station: station.command(MissionCmd.GOTO, GOAL))
    assert len(link.acts) == 1


def test_the_value_of_another_parameter_is_not_taken() -> None:
    link = deaf_to(SetParameter)

    async def work(station: Station) -> None:
        link.say(ParameterValue("way.speed", 0.9), ParameterValue("way.height", 0.5))
        assert await station.set_parameter("way.height", 0.5) == 0.5

    with_station(link, work)


def test_a_stop_is_repeated_while_the_supervisor_says_something_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("ground.station.station.REPEAT_S", 0.001)
    link = deaf_to(EmergencyStop)

    async def work(station: Station) -> None:
        link.say(replace(LOCKED, supervisor=0))
        await heard(link)
        stopping = asyncio.create_task(station.emergency_stop())
        while link.count(EmergencyStop) < 4:
            assert not stopping.done()
            await asyncio.sleep(0)
        link.say(LOCKED)
        await stopping

    with_station(link, work)


def event(sequence: int) -> Event:
    return Event(sequence, 100, EventCode.ARRIVED, 0, GOAL)


def test_events_are_news_once_and_only_if_they_came_after_the_station() -> None:
    link, told = FakeLink(), list[int]()

    async def work(station: Station) -> None:
        with station.listen(Event) as listener:
            link.say(Beat(0, 50, MissionState.IDLE, next_event=10))
            link.say(event(8), event(10), event(10), event(9), event(11))
            await heard(link)
            while (message := await listener.next(0.01)) is not None:
                assert isinstance(message, Event)
                told.append(message.sequence)
        assert [each.sequence for each in station.picture.events] == [8, 9, 10, 11]

    with_station(link, work)
    assert told == [10, 11]


def test_records_of_the_way_count_up_to_the_first_that_is_missing() -> None:
    link = FakeLink()
    records = [Record(1000 * i, RecordKind.POSE, float(i), 0.0, 0.0) for i in range(4)]

    async def work(station: Station) -> None:
        link.say(Beat(0, 5000, MissionState.FOLLOW, next_record=4))
        link.say(History(0, (records[0], records[1])), History(3, (records[3],)))
        await heard(link)
        assert station.picture.trail.points == (Point(0.0, 0.0), Point(1.0, 0.0))
        link.say(History(2, (records[2],)))
        await heard(link)
        assert len(station.picture.trail) == 4

    with_station(link, work)
