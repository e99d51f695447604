# SPDX-License-Identifier: GPL-3.0-or-later
"""The page's real server in its own thread, so that a test can wait for its browser."""

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ground.station.station import station_on
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet
from ground.web.server import page_server
from tests.ground.fakelink import FakeLink


class Ground:
    """The ground station in its own thread, with a drone in memory."""

    def __init__(self) -> None:
        self.link = FakeLink()
        self.other_link = FakeLink()
        self.cockpit, self.other = Cockpit(), Cockpit()
        self.fleet = Fleet.of(self.cockpit)
        self.address = ""
        self._ready = threading.Event()

    def call(self, work: Callable[[], object]) -> None:
        """Run a call in the station's loop."""
        self._loop.call_soon_threadsafe(work)

    @contextmanager
    def running(self) -> Iterator["Ground"]:
        thread = threading.Thread(target=asyncio.run, args=(self._serve(),))
        thread.start()
        assert self._ready.wait(20)
        try:
            yield self
        finally:
            self.call(self._done.set)
            thread.join()

    async def _serve(self) -> None:
        self._loop, self._done = asyncio.get_running_loop(), asyncio.Event()
        async with (
            station_on(self.link) as station,
            station_on(self.other_link) as other,
            page_server(self.fleet, 0) as self.address,
        ):
            self.cockpit.station = station
            self.other.station = other
            self._ready.set()
            await self._done.wait()
