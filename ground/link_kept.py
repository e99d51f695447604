# SPDX-License-Identifier: GPL-3.0-or-later
"""A link that is kept up: when it is lost, the drone is looked for until it is there again."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import astuple

from ground.errors import GroundError, LinkError
from ground.link import Link
from ground.logstream import restarted
from ground.model import (
    Beat,
    Health,
    Incoming,
    LinkChange,
    LinkState,
    LinkStats,
    Outgoing,
    Telemetry,
)

log = logging.getLogger(__name__)

RETRY_S = 0.3
HELD_MESSAGES = 256
AGAIN = "the drone was restarted"


class KeptLink:
    """Makes a link anew whenever the one before is lost, or the drone was restarted.

    The reader sees RECONNECTING, then CONNECTED; RESTARTED where the drone began anew. It ends, as
    LOST, only when something answers that cannot be talked to.
    """

    def __init__(self, make: Callable[[], Link]) -> None:
        self._make = make
        self._link: Link | None = None
        self._past = LinkStats()
        self._closed = False
        self._searching: asyncio.Task[None] | None = None
        self._clock: tuple[int, float] | None = None  # the drone's [ms], and when by ours

    @property
    def stats(self) -> LinkStats:
        """Of all links so far."""
        if self._link is None:
            return self._past
        sums = zip(astuple(self._past), astuple(self._link.stats), strict=True)
        return LinkStats(*(a + b for a, b in sums))

    async def open(self) -> None:
        """Connect for the first time; raises where nobody answers."""
        link = self._make()
        await link.open()
        self._link = link

    async def close(self) -> None:
        """Let go, and look for nobody any more."""
        self._closed = True
        if self._searching:
            self._searching.cancel()
        await self._drop()

    def send(self, message: Outgoing) -> None:
        """Hand over; while there is no link it is lost."""
        if self._link:
            self._link.send(message)

    async def messages(self) -> AsyncIterator[Incoming]:
        """What comes in, until the link is closed."""
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
        """With RESTARTED before all that belongs to a new flight of the drone.

        What a new link brings waits for the first message that tells the drone's time.
        """
        held: list[Incoming] | None = [] if self._clock else None
        async for message in messages:
            drone_ms = _time_ms(message)
            if drone_ms is not None and self._begins_anew(drone_ms):
                yield LinkChange(LinkState.RESTARTED, AGAIN)
                if held is None:  # its tables may be others now: connect anew
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
        """The drone's clock says that it is not the flight that it was."""
        now_s, before = time.monotonic(), self._clock
        self._clock = (drone_ms, now_s)
        return before is not None and restarted(before[0], drone_ms, now_s - before[1])

    async def _drop(self) -> None:
        if (link := self._link) is not None:
            self._past, self._link = self.stats, None
            await link.close()

    async def _search(self) -> None:
        """Until there is a link again. Raises what waiting cannot mend."""
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
