# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages for tests of the station, and how they run it."""

import asyncio
import itertools
from collections.abc import Awaitable, Callable

from ground.core import EventCode, MissionCmd, MissionReason, MissionState
from ground.link.wire import encode_map_piece
from ground.model import Event, MapPacket, MapPiece, Point, Pose, Telemetry
from ground.station.settling import fly_when_settled
from ground.station.station import Station, station_on
from tests.ground.fakelink import FakeLink

GOAL = Point(1.0, 2.0)
NUMBERS = itertools.count()


def telemetry(drone_ms: int, state: MissionState, x_m: float = 0.0, y_m: float = 0.0) -> Telemetry:
    pose = Pose(x_m, y_m, 0.4, 0.0)
    return Telemetry(drone_ms, pose, GOAL, state, MissionReason.OK, 100)


def event(code: EventCode, argument: int = 0, drone_ms: int = 100, place: Point = GOAL) -> Event:
    return Event(next(NUMBERS), drone_ms, code, argument, place)


def packet_of(piece: MapPiece, drone_ms: int = 0) -> MapPacket:
    """One tile as a log packet carries it."""
    return MapPacket(drone_ms, encode_map_piece(piece))


def with_station(link: FakeLink, work: Callable[[Station], Awaitable[None]]) -> None:
    async def run() -> None:
        async with station_on(link) as station:
            await work(station)

    asyncio.run(run())


async def heard(link: FakeLink) -> None:
    """Wait until the station has taken everything that was delivered."""
    while not link.idle:
        await asyncio.sleep(0)
    await asyncio.sleep(0)


async def take_off(station: Station) -> None:
    """Take off as soon as the drone is ready, and wait until it hovers."""
    outcome = await fly_when_settled(station, MissionCmd.TAKE_OFF)
    assert outcome.reached, outcome
