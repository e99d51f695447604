# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of the station say to it, and how they run it."""

import asyncio
import itertools
from collections.abc import Awaitable, Callable

from ground.core import EventCode, MissionReason, MissionState
from ground.missing import MapPacket
from ground.model import Event, MapPiece, Point, Pose, Telemetry
from ground.station import Station, station_on
from ground.wire import encode_map_piece
from tests.ground.fakelink import FakeLink

GOAL = Point(1.0, 2.0)
NUMBERS = itertools.count()


def telemetry(drone_ms: int, state: MissionState, x_m: float = 0.0, y_m: float = 0.0) -> Telemetry:
    pose = Pose(x_m, y_m, 0.4, 0.0)
    return Telemetry(drone_ms, pose, GOAL, state, MissionReason.OK, 100)


def event(code: EventCode, argument: int = 0, drone_ms: int = 100, place: Point = GOAL) -> Event:
    return Event(next(NUMBERS), drone_ms, code, argument, place)


def packet_of(piece: MapPiece, drone_ms: int = 0) -> MapPacket:
    """One tile as it comes in a log packet."""
    return MapPacket(drone_ms, encode_map_piece(piece))


def with_station(link: FakeLink, work: Callable[[Station], Awaitable[None]]) -> None:
    async def run() -> None:
        async with station_on(link) as station:
            await work(station)

    asyncio.run(run())


async def heard(link: FakeLink) -> None:
    """Let the station take everything that was said."""
    while not link.idle:
        await asyncio.sleep(0)
    await asyncio.sleep(0)
