# SPDX-License-Identifier: GPL-3.0-or-later
"""A page that is slow shows the present, less often; one that cannot be told is let go."""

import asyncio
import json

import pytest
from playwright.sync_api import Browser
from websockets.exceptions import ConnectionClosed

from ground.web import page as web_page
from ground.web.pace import AHEAD, Pace
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


async def sent(pace: Pace, most: int) -> int:
    """How many may go out before it has to wait."""
    count = 0
    while count < most:
        turn = asyncio.create_task(pace.send_next())
        await asyncio.sleep(0)
        if not turn.done():
            turn.cancel()
            return count
        count += 1
    return count


def test_only_so_many_are_under_way() -> None:
    async def run() -> None:
        pace = Pace()
        assert await sent(pace, 50) == 50, "to who never says so, as many as there are"
        for _ in range(50):
            pace.taken()
        assert await sent(pace, 50) == AHEAD
        pace.taken()
        assert await sent(pace, 50) == 1

    asyncio.run(run())


def test_a_page_that_cannot_be_told_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """It opens another connection, and does not show the last state for ever."""

    async def run() -> None:
        async with Running().served() as running, running.page() as page:
            assert json.loads(await page.recv())["kind"] == "state"
            monkeypatch.setattr(web_page, "state_frame", lambda *_: 1 / 0)
            with pytest.raises(ConnectionClosed):
                while True:
                    await page.recv()

    asyncio.run(run())


def test_a_slow_page_is_not_behind(browser: Browser, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is made for it, it has taken, but for a few."""
    made: list[int] = []
    frame = web_page.state_frame
    monkeypatch.setattr(web_page, "state_frame", lambda *how: made.append(1) or frame(*how))
    with Ground().running() as ground, tab_at(browser, ground.address) as tab:
        tab.page.goto(ground.address)
        tab.wait(lambda: tab.states)
        tab.page.evaluate(SLOW)
        made.clear()
        tab.wait(lambda: tab.page.evaluate("taken") >= STATES)
        taken: int = tab.page.evaluate("taken")
        assert len(made) - taken <= 2 * AHEAD
