# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a page is behind: a slow one is sent fewer states, never old ones.

What is sent piles up in the buffers of both sides for a minute before a send has to wait, and a
page would show that minute as the present. So a page says of each state that it has taken it, and
is sent no more than AHEAD before that. One that never says so, a script, is not waited for.
"""

import asyncio

AHEAD = 3


class Pace:
    """Counts the states of one page."""

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
