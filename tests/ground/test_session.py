# SPDX-License-Identifier: GPL-3.0-or-later
"""What is printed on the terminal while a drone flies."""

import asyncio
import io

import pytest
from rich.console import Console

from ground.cli.session import narrated, now
from ground.core import EventCode, MissionReason, MissionState
from ground.model import Event, Point
from ground.station.station import Station, station_on
from ground.words import EXPLORED, EXPLORED_PARTLY
from tests.ground.fakelink import LOCKED, FakeLink
from tests.ground.stations import telemetry


async def said(*events: Event) -> str:
    """All lines printed until the last of these events was heard."""
    link, console = FakeLink(), Console(file=io.StringIO(), record=True, width=200)
    async with station_on(link) as station, narrated(station, console):
        await asyncio.sleep(0)  # its task has begun to listen
        link.say(*events)
        while len(station.picture.events) < len(events) or not link.idle:
            await asyncio.sleep(0)
        await asyncio.sleep(0)
    return console.export_text()


@pytest.mark.parametrize(
    ("code", "argument", "words"),
    [
        (EventCode.EXPLORED, 0, EXPLORED),
        (EventCode.EXPLORED, 1, EXPLORED_PARTLY),
        (EventCode.STATE, MissionState.LAND, "landing"),
        (EventCode.FAULT, MissionReason.STUCK, "too many attempts brought no progress"),
        (EventCode.WAYPOINT, 2, "at waypoint 3"),
    ],
)
def test_an_event_is_said_in_a_line_with_its_time(
    code: EventCode, argument: int, words: str
) -> None:
    told = asyncio.run(said(Event(1, 12_500, code, argument, Point(0.0, 0.0))))
    assert f"    12.5 s  {words}\n" in told


def test_how_things_are_is_one_line() -> None:
    station = Station(FakeLink())
    assert now(station).startswith("on the ground  0.0 m² known  0 s")
    station.picture.take(telemetry(2000, MissionState.FOLLOW), 0.0)
    station.picture.take(LOCKED, 0.0)
    station.picture.map.states[:20, :20] = 1
    assert now(station).startswith("flying  1.0 m² known  4.00 V  ")
