# SPDX-License-Identifier: GPL-3.0-or-later
"""The page's real server, with a drone in memory behind it."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from urllib.parse import urlsplit

from websockets.asyncio.client import connect

from ground.station.station import station_on
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet
from ground.web.server import (
    page_server,
)
from tests.ground.fakelink import FakeLink


class Running:
    """A real server with a drone in memory."""

    def __init__(self) -> None:
        self.link = FakeLink()
        self.cockpit = Cockpit()
        self.address = ""

    @property
    def port(self) -> int:
        return urlsplit(self.address).port or 0

    @asynccontextmanager
    async def served(self, bind: str = "127.0.0.1") -> AsyncIterator["Running"]:
        async with (
            station_on(self.link) as station,
            page_server(Fleet.of(self.cockpit), 0, bind) as self.address,
        ):
            self.cockpit.station = station
            yield self

    def page(self) -> connect:
        origin = self.address.rstrip("/")
        return connect(f"ws://127.0.0.1:{self.port}/socket", origin=origin, max_size=None)
