# SPDX-License-Identifier: GPL-3.0-or-later
"""A reader's queue of what a station hears."""

from __future__ import annotations

import asyncio

from ground.errors import LinkLost
from ground.model import Incoming, LinkChange

LISTENER_MESSAGES = 8192  # more than a full inbox brings at once


class Listener:
    """What comes in from now on, for one reader: of these kinds, and what becomes of the link; all
    if none is named. The oldest is lost if the reader is slow."""

    def __init__(self, *kinds: type[Incoming]) -> None:
        self._kinds = (*kinds, LinkChange) if kinds else ()
        self._queue: asyncio.Queue[Incoming | None] = asyncio.Queue(LISTENER_MESSAGES)

    def put(self, message: Incoming | None) -> None:
        """Add a message if it is of the kinds; None ends."""
        if self._kinds and message is not None and not isinstance(message, self._kinds):
            return
        if self._queue.full():
            self._queue.get_nowait()
        self._queue.put_nowait(message)

    async def next(self, timeout_s: float | None = None) -> Incoming | None:
        """The next message, or None after timeout_s. Raises LinkLost when no more will come."""
        try:
            message = self._queue.get_nowait()
        except asyncio.QueueEmpty:
            try:
                message = await asyncio.wait_for(self._queue.get(), timeout_s)
            except TimeoutError:
                return None
        if message is None:
            self.put(None)
            raise LinkLost("the link to the drone is gone")
        return message
