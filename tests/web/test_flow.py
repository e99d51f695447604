# SPDX-License-Identifier: GPL-3.0-or-later
"""A slow page shows the present less often; a page that takes nothing is disconnected."""

import asyncio
import json

import pytest
from playwright.sync_api import Browser
from websockets.exceptions import ConnectionClosed

from ground.web import page as web_page
from ground.web.flow import AHEAD, Unread
from tests.web.browsing import tab_at
from tests.web.running import Running
from tests.web.threaded import Ground

BUSY_MS = 200
STATES = 15
SLOW = f"""() => {{
  const take = wayflie.map.take.bind(wayflie.map);
  globalThis.taken = 0;
  wayflie.map.take = (message) => {{
    const until = performance.now() + {BUSY_MS};
    while (performance.now() < until);
    globalThis.taken += 1;
    take(message);
  }};
}}"""


async def sent(unread: Unread, most: int) -> int:
    """How many messages may go out before the sender has to wait."""
    count = 0
    while count < most:
        turn = asyncio.create_task(unread.send_next())
        await asyncio.sleep(0)
        if not turn.done():
            turn.cancel()
            return count
        count += 1
    return count


def test_only_so_many_are_under_way() -> None:
    async def run() -> None:
        unread = Unread()
        assert await sent(unread, 50) == 50, "to who never says so, as many as there are"
        for _ in range(50):
            unread.taken()
        assert await sent(unread, 50) == AHEAD
        unread.taken()
        assert await sent(unread, 50) == 1

    asyncio.run(run())


def test_a_page_that_cannot_be_told_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """It reconnects, instead of showing the last state for ever."""

    async def run() -> None:
        async with Running().served() as running, running.page() as page:
            assert json.loads(await page.recv())["kind"] == "state"
            monkeypatch.setattr(web_page, "state_frame", lambda *_: 1 / 0)
            with pytest.raises(ConnectionClosed):
                while True:
                    await page.recv()

    asyncio.run(run())


def test_a_slow_page_is_not_behind(browser: Browser, monkeypatch: pytest.MonkeyPatch) -> None:
    """It has taken all but a few of the states made for it."""
    made: list[int] = []
    frame = web_page.state_frame
    monkeypatch.setattr(web_page, "state_frame", lambda *how: made.append(1) or frame(*how))
    with Ground().running() as ground, tab_at(browser, ground.address) as tab:
        tab.page.goto(ground.address)
        tab.wait(lambda: tab.states)
        tab.page.evaluate(SLOW)
        made.clear()
        tab.wait(lambda: tab.page.evaluate("taken") >= STATES)
        count = len(made)
        taken: int = tab.page.evaluate("taken")
        assert count - taken <= 2 * AHEAD
