# SPDX-License-Identifier: GPL-3.0-or-later
"""A queue of messages for one reader."""

from __future__ import annotations

import asyncio

from ground.errors import LinkLost
from ground.model import Incoming, LinkChange

LISTENER_MESSAGES = 8192  # more than a full inbox delivers at once


class Listener:
    """Messages of the named kinds from now on, or of all kinds, for one reader; always LinkChange.
    If the reader is slow, the oldest messages are lost."""

    def __init__(self, *kinds: type[Incoming]) -> None:
        self._kinds = (*kinds, LinkChange) if kinds else ()
        self._queue: asyncio.Queue[Incoming | None] = asyncio.Queue(LISTENER_MESSAGES)

    def put(self, message: Incoming | None) -> None:
        """Add a message if it is of a wanted kind; None ends the queue."""
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
