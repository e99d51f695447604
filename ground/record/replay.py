# SPDX-License-Identifier: GPL-3.0-or-later
"""A link that replays a recording; it can be paused and moved to any time."""

from __future__ import annotations

import asyncio
from bisect import bisect_right
from collections.abc import AsyncIterator, Callable
from pathlib import Path

from ground.model import Incoming, LinkChange, LinkState, LinkStats
from ground.record.reader import Heard, read_session
from ground.requests import Outgoing

LONGEST_PAUSE_S = 2.0
BREATH_MESSAGES = 500  # while seeking, other tasks get a turn after this many messages
TICK_S = 0.05


class ReplayLink:
    """A recorded session as a Link; commands are ignored."""

    def __init__(self, path: Path, speed: float = 1.0) -> None:
        self._path = path
        self._heard: list[Heard] = []
        self._times_s: list[float] = []
        self._next = 0
        self._wanted_s: float | None = None
        self._woken = asyncio.Event()
        self._closed = False
        self.speed = speed
        self.playing = True
        self.position_s = 0.0
        self.on_rewind: Callable[[], None] = lambda: None
        """Called before the recording is replayed from the start."""

    @property
    def stats(self) -> LinkStats:
        """All zero: a recording loses nothing."""
        return LinkStats()

    @property
    def duration_s(self) -> float:
        """Length of the recording by the drone's clock."""
        return self._times_s[-1] if self._times_s else 0.0

    @property
    def ended(self) -> bool:
        """Whether everything has been replayed."""
        return self._next >= len(self._heard)

    async def open(self) -> None:
        """Read the file. Raises LinkUnavailable."""
        words = await asyncio.to_thread(read_session, self._path)
        self._heard = [word for word in words if isinstance(word, Heard)]
        self._times_s = [word.time_s for word in self._heard]

    async def close(self) -> None:
        """Stop at the present position."""
        self._closed = True
        self._woken.set()

    def send(self, message: Outgoing) -> None:
        """Ignore the message."""

    def play(self) -> None:
        """Continue; at the end, start again."""
        self.playing = True
        if self.ended:
            self._wanted_s = 0.0
        self._woken.set()

    def pause(self) -> None:
        """Stop at the present position until play()."""
        self.playing = False
        self._woken.set()

    def seek(self, time_s: float) -> None:
        """Go to a time; all messages up to it are delivered at once."""
        self._wanted_s = min(max(time_s, 0.0), self.duration_s)
        self._woken.set()

    async def finished(self) -> None:
        """Wait until everything has been replayed."""
        while not self.ended:
            await asyncio.sleep(TICK_S)

    async def messages(self) -> AsyncIterator[Incoming]:
        """The recorded messages; at the end it waits for play() or seek(), until it is closed."""
        while not self._closed:
            if self._wanted_s is not None:
                async for message in self._wind(self._wanted_s):
                    yield message
            elif self.ended or not self.playing:
                await self._rest(None)
            elif await self._rest(self._pause_s()):
                yield self._take()
        yield LinkChange(LinkState.CLOSED, "the replay has ended")

    async def _wind(self, wanted_s: float) -> AsyncIterator[Incoming]:
        self._wanted_s = None
        if wanted_s < self.position_s:
            self.on_rewind()
            self._next, self.position_s = 0, 0.0
        until = bisect_right(self._times_s, wanted_s)
        while self._next < until and self._wanted_s is None and not self._closed:
            yield self._take()
            if self._next % BREATH_MESSAGES == 0:
                await asyncio.sleep(0)
        self.position_s = max(self.position_s, wanted_s if self._wanted_s is None else 0.0)

    def _take(self) -> Incoming:
        word = self._heard[self._next]
        self._next += 1
        self.position_s = max(self.position_s, word.time_s)
        return word.message

    def _pause_s(self) -> float:
        pause_s = self._times_s[self._next] - self.position_s
        return max(0.0, min(pause_s, LONGEST_PAUSE_S) / self.speed)

    async def _rest(self, pause_s: float | None) -> bool:
        """Sleep; None: until play(), pause(), seek() or close(). @return False if woken early"""
        if pause_s == 0.0:
            await asyncio.sleep(0)
            return True
        self._woken.clear()
        try:
            await asyncio.wait_for(self._woken.wait(), pause_s)
        except TimeoutError:
            return True
        return False
