# SPDX-License-Identifier: GPL-3.0-or-later
"""A link that is kept up: after a loss it looks for the drone until it answers again."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import astuple

from ground.errors import GroundError, LinkError
from ground.link.logstream import restarted
from ground.link.protocol import Link
from ground.model import Beat, Health, Incoming, LinkChange, LinkState, LinkStats, Telemetry
from ground.requests import Outgoing

log = logging.getLogger(__name__)

RETRY_S = 0.3
HELD_MESSAGES = 256
AGAIN = "the drone was restarted"


class KeptLink:
    """Replaces the link whenever it is lost or the drone was restarted.

    The reader sees RECONNECTING, then CONNECTED; also RESTARTED if the drone was restarted. The
    messages end, with LOST, only on an error that trying again cannot mend.
    """

    def __init__(self, make: Callable[[], Link]) -> None:
        self._make = make
        self._link: Link | None = None
        self._past = LinkStats()
        self._closed = False
        self._searching: asyncio.Task[None] | None = None
        self._clock: tuple[int, float] | None = None  # latest drone time [ms] and when it came [s]

    @property
    def stats(self) -> LinkStats:
        """Counters summed over all links so far."""
        if self._link is None:
            return self._past
        sums = zip(astuple(self._past), astuple(self._link.stats), strict=True)
        return LinkStats(*(a + b for a, b in sums))

    async def open(self) -> None:
        """Connect for the first time; raises LinkUnavailable if nobody answers."""
        link = self._make()
        await link.open()
        self._link = link

    async def close(self) -> None:
        """Close the link and stop looking for the drone."""
        self._closed = True
        if self._searching:
            self._searching.cancel()
        await self._drop()

    def send(self, message: Outgoing) -> None:
        """Send a message; without a link it is lost."""
        if self._link:
            self._link.send(message)

    async def messages(self) -> AsyncIterator[Incoming]:
        """All incoming messages, across reconnections, until the link is closed."""
        while self._link:
            reason = ""
            async for message in self._judged(self._link.messages()):
                if isinstance(message, LinkChange) and message.state is LinkState.LOST:
                    reason = message.detail
                    break
                yield message
            if self._closed:
                return
            yield LinkChange(LinkState.RECONNECTING, f"looking for the drone: {reason}")
            await self._drop()
            if self._closed:
                return
            self._searching = asyncio.create_task(self._search())
            try:
                await self._searching
            except asyncio.CancelledError:
                if self._closed:
                    return
                raise
            except GroundError as error:
                yield LinkChange(LinkState.LOST, str(error))
                return

    async def _judged(self, messages: AsyncIterator[Incoming]) -> AsyncIterator[Incoming]:
        """Put RESTARTED before everything that belongs to the drone's new run.

        Messages of a new link are held back until the first that carries the drone's time.
        """
        held: list[Incoming] | None = [] if self._clock else None
        async for message in messages:
            drone_ms = _time_ms(message)
            if drone_ms is not None and self._begins_anew(drone_ms):
                yield LinkChange(LinkState.RESTARTED, AGAIN)
                if held is None:  # its tables may have changed: reconnect
                    yield LinkChange(LinkState.LOST, AGAIN)
                    return
            if held is None:
                yield message
                continue
            held.append(message)
            if drone_ms is not None or len(held) > HELD_MESSAGES:
                for waiting in held:
                    yield waiting
                held = None
        for waiting in held or ():
            yield waiting

    def _begins_anew(self, drone_ms: int) -> bool:
        """Whether the drone's clock shows that it was restarted since the last message."""
        now_s, before = time.monotonic(), self._clock
        self._clock = (drone_ms, now_s)
        return before is not None and restarted(before[0], drone_ms, now_s - before[1])

    async def _drop(self) -> None:
        if (link := self._link) is not None:
            self._past, self._link = self.stats, None
            await link.close()

    async def _search(self) -> None:
        """Try to connect until it succeeds; raises errors that trying again cannot mend."""
        while True:
            try:
                await self.open()
                return
            except LinkError as error:
                log.info("%s", error)
            await asyncio.sleep(RETRY_S)


def _time_ms(message: Incoming) -> int | None:
    match message:
        case Telemetry(drone_ms=drone_ms) | Health(drone_ms=drone_ms) | Beat(drone_ms=drone_ms):
            return drone_ms
    return None
