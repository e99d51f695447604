# SPDX-License-Identifier: GPL-3.0-or-later
"""Flying by hand, held by the server: a page that is not heard any more has let go.

A page sends its stick many times a second; the drone is sent the last one at a steady rate. When
the page falls silent the stick goes to zero, a number of times.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time

from ground.core import MissionReason
from ground.errors import CommandRefused, GroundError, LinkError
from ground.model import Ack
from ground.requests import REST, Stick
from ground.station.listener import Listener
from ground.station.station import Station
from ground.words import refusal

PERIOD_S = 0.05
DEAD_MAN_S = 0.3
RESTS = 10  # sent after the stick was let go, in case some are lost
REFUSED_S = 1.0  # a refusal is told for so long, then it is tried again
FASTEST = Stick(1.0, 1.0, math.radians(90.0), 0.5)


class Hand:
    """The stick of one drone; one page at a time holds it."""

    def __init__(self) -> None:
        self._stick = REST
        self._holder: object = None
        self._heard_s = -math.inf
        self._refused: tuple[float, CommandRefused] | None = None
        self._task: asyncio.Task[None] | None = None

    @property
    def deflected(self) -> bool:
        """Whether a page moves the drone now."""
        sends = self._task is not None and not self._task.done()
        return sends and self._held and self._stick != REST

    @property
    def _held(self) -> bool:
        """Whether the page that took the stick still holds it."""
        return time.monotonic() - self._heard_s < DEAD_MAN_S

    def take(self, station: Station, holder: object, stick: Stick) -> None:
        """What a page wants now. Raises GroundError: another holds it, or the drone refuses."""
        now_s = time.monotonic()
        if self._holder not in (None, holder) and self._held:
            raise GroundError("another page is flying it by hand")
        if self._refused and now_s - self._refused[0] < REFUSED_S:
            raise self._refused[1]
        self._holder, self._heard_s, self._stick = holder, now_s, _limited(stick)
        if self._task is None or self._task.done():
            self._refused = None
            self._task = asyncio.create_task(self._steer(station))

    def close(self) -> None:
        """No more is sent; the drone comes to rest by itself."""
        if self._task:
            self._task.cancel()

    async def closed(self) -> None:
        """Until nothing more can be sent."""
        if self._task:
            await asyncio.wait([self._task])

    async def _steer(self, station: Station) -> None:
        sent: set[int] = set()
        with station.listen(Ack) as acks, contextlib.suppress(LinkError):
            rests = 0
            while rests < RESTS:
                held = self._held
                rests = 0 if held else rests + 1
                sent.add(station.send_stick(self._stick if held else REST))
                if refusal := await _refusal(acks, sent):
                    self._refused = (time.monotonic(), refusal)
                    return


async def _refusal(acks: Listener, sent: set[int]) -> CommandRefused | None:
    """Of one of these, within a period."""
    until_s = time.monotonic() + PERIOD_S
    while (left_s := until_s - time.monotonic()) > 0:
        match await acks.next(left_s):
            case Ack(sequence, _, reason) if sequence in sent and reason is not MissionReason.OK:
                return refusal(reason)
    return None


def _limited(stick: Stick) -> Stick:
    def within(value: float, most: float) -> float:
        return max(-most, min(most, value))

    return Stick(
        within(stick.ahead_mps, FASTEST.ahead_mps),
        within(stick.left_mps, FASTEST.left_mps),
        within(stick.yaw_rate_rps, FASTEST.yaw_rate_rps),
        within(stick.climb_mps, FASTEST.climb_mps),
    )
