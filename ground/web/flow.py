# SPDX-License-Identifier: GPL-3.0-or-later
"""How much goes over the socket of one page: what it may send, and how far it is behind."""

import asyncio

AHEAD = 3


class Allowance:
    """A bucket that fills again with time: what is in it may be spent at once."""

    def __init__(self, now_s: float, per_s: float, at_once: float) -> None:
        self._left, self._then_s = at_once, now_s
        self._per_s, self._at_once = per_s, at_once

    def allows(self, now_s: float) -> bool:
        """Whether one more is not too many; it counts then."""
        filled = self._left + (now_s - self._then_s) * self._per_s
        self._left, self._then_s = min(filled, self._at_once), now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class Unread:
    """The states that a page was sent and has not taken: a slow one gets fewer, never old ones.

    What is sent piles up in the buffers of both sides for a minute before a send has to wait, and a
    page would show that minute as the present. So a page says of each state that it has taken it,
    and is sent no more than AHEAD before that. One that never says so, a script, is not waited for.
    """

    def __init__(self) -> None:
        self._behind = 0
        self._says = False
        self._moved = asyncio.Event()

    async def send_next(self) -> None:
        """Wait until the page has taken enough of what was sent; then one more is on its way."""
        while self._says and self._behind >= AHEAD:
            self._moved.clear()
            await self._moved.wait()
        self._behind += 1

    def taken(self) -> None:
        """The page has taken one."""
        self._says = True
        self._behind = max(0, self._behind - 1)
        self._moved.set()
