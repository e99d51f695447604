# SPDX-License-Identifier: GPL-3.0-or-later
"""A reader's queue of what a station hears."""

from __future__ import annotations

import asyncio

from ground.errors import LinkLost
from ground.model import Incoming

LISTENER_MESSAGES = 1024


class Listener:
    """Everything that comes in from now on, for one reader; the oldest is lost if it is slow."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[Incoming | None] = asyncio.Queue(LISTENER_MESSAGES)

    def put(self, message: Incoming | None) -> None:
        """Add a message; None ends."""
        if self._queue.full():
            self._queue.get_nowait()
        self._queue.put_nowait(message)

    async def next(self, timeout_s: float | None = None) -> Incoming | None:
        """The next message, or None after timeout_s. Raises LinkLost when no more will come."""
        try:
            message = await asyncio.wait_for(self._queue.get(), timeout_s)
        except TimeoutError:
            return None
        if message is None:
            self.put(None)
            raise LinkLost("the link to the drone is gone")
        return message
