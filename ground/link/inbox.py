# SPDX-License-Identifier: GPL-3.0-or-later
"""A queue in which other threads pass items to the asyncio loop; no data takes another way."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class Inbox(Generic[T]):
    """Bounded queue, filled by any thread and emptied by one task.

    When it is full, the oldest item is dropped and counted. Many items cause one wake-up.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, capacity: int) -> None:
        self._loop = loop
        self._capacity = capacity
        self._items: deque[T] = deque()
        self._lock = threading.Lock()
        self._filled = asyncio.Event()
        self._closed = False
        self.dropped = 0
        self.peak = 0

    def put(self, item: T) -> None:
        """Add an item, from any thread; never blocks and never raises."""
        with self._lock:
            wake = not self._items
            if len(self._items) >= self._capacity:
                self._items.popleft()
                self.dropped += 1
            self._items.append(item)
            self.peak = max(self.peak, len(self._items))
        if wake:
            self._wake()

    def close(self) -> None:
        """Close, from any thread: the reader takes what is left, then ends."""
        self._closed = True
        self._wake()

    async def take(self) -> list[T]:
        """Wait for items and return all of them in order; an empty list only after close()."""
        await self._filled.wait()
        with self._lock:
            items = list(self._items)
            self._items.clear()
            if not self._closed:
                self._filled.clear()
        return items

    def _wake(self) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended, and its reader with it
            self._loop.call_soon_threadsafe(self._filled.set)
