# SPDX-License-Identifier: GPL-3.0-or-later
"""Flying by hand through the server: what the drone is sent, and the dead-man timer of pages."""

import asyncio
import time
from collections.abc import Awaitable, Callable

import pytest

from ground.core import MissionCmd, MissionReason
from ground.errors import CommandRefused, GroundError, StopLatched
from ground.model import Ack
from ground.requests import REST, Outgoing, Steer, Stick
from ground.station.station import station_on
from ground.web.cockpit import Cockpit
from ground.web.hand import DEAD_MAN_S, FASTEST, RESTS
from ground.web.wishes import stick_of
from tests.ground.fakelink import FakeLink

AHEAD = Stick(ahead_mps=0.4)


class Timed(FakeLink):
    """Remembers when which stick came, and can refuse sticks."""

    def __init__(self, refuses: MissionReason = MissionReason.OK) -> None:
        super().__init__()
        self.sticks: list[tuple[float, Stick]] = []
        self.refuses = refuses

    def send(self, message: Outgoing) -> None:
        super().send(message)
        if isinstance(message, Steer):
            self.sticks.append((time.monotonic(), message.stick))
            if self.refuses is not MissionReason.OK:
                self.say(Ack(message.sequence, MissionCmd.NONE, self.refuses))


def with_cockpit(link: FakeLink, work: Callable[[Cockpit], Awaitable[None]]) -> None:
    async def run() -> None:
        async with station_on(link) as station:
            cockpit = Cockpit(station)
            await work(cockpit)
            await cockpit.close()

    asyncio.run(run())


async def until(condition: Callable[[], object]) -> None:
    async with asyncio.timeout(20):
        while not condition():
            await asyncio.sleep(0.01)


def test_a_page_that_falls_silent_has_let_go() -> None:
    link = Timed()

    async def work(cockpit: Cockpit) -> None:
        for _ in range(5):
            cockpit.steer("page", AHEAD)
            assert cockpit.sticks.deflected
            last_s = time.monotonic()
            await asyncio.sleep(0.05)
        await until(lambda: link.sticks[-1][1] == REST)
        assert not cockpit.sticks.deflected
        held_s = [at_s - last_s for at_s, stick in link.sticks if stick == AHEAD]
        assert len(held_s) > 1
        assert max(held_s) < DEAD_MAN_S + 0.1
        await cockpit.sticks.closed()
        assert [stick for _, stick in link.sticks[-RESTS - 1 :]] == [AHEAD] + [REST] * RESTS

    with_cockpit(link, work)


def test_one_page_at_a_time_holds_the_stick() -> None:
    link = Timed()

    async def work(cockpit: Cockpit) -> None:
        cockpit.steer("one", AHEAD)
        with pytest.raises(GroundError, match="another page"):
            cockpit.steer("two", REST)
        cockpit.steer("one", REST)
        await until(lambda: link.sticks[-1:] and link.sticks[-1][1] == REST)
        await asyncio.sleep(1.5 * DEAD_MAN_S)
        cockpit.steer("two", AHEAD)
        await until(lambda: link.sticks[-1][1] == AHEAD)

    with_cockpit(link, work)


def test_what_the_drone_refuses_is_told_and_no_more_is_sent() -> None:
    link = Timed(MissionReason.BUSY)

    async def work(cockpit: Cockpit) -> None:
        cockpit.steer("page", AHEAD)
        words = ""

        def refused() -> bool:
            nonlocal words
            try:
                cockpit.steer("page", AHEAD)
            except CommandRefused as error:
                words = str(error)
            return bool(words)

        await until(refused)
        assert "busy" in words
        assert not cockpit.sticks.deflected
        sent = len(link.sticks)
        await asyncio.sleep(0.2)
        assert len(link.sticks) == sent

    with_cockpit(link, work)


def test_no_stick_gets_past_a_stop() -> None:
    link = Timed()

    async def work(cockpit: Cockpit) -> None:
        cockpit.steer("page", AHEAD)
        await until(lambda: link.sticks)
        cockpit.stop()
        sent = len(link.sticks)
        with pytest.raises(StopLatched):
            cockpit.steer("page", AHEAD)
        await asyncio.sleep(0.2)
        assert len(link.sticks) == sent

    with_cockpit(link, work)


def test_nothing_goes_on_when_the_server_ends() -> None:
    """Neither the stick nor the dead-man timer of a page that has gone, or goes with the server."""

    async def work(cockpit: Cockpit) -> None:
        before = asyncio.all_tasks()
        cockpit.page_opened()
        cockpit.steer("page", AHEAD)
        cockpit.page_closed()
        assert asyncio.all_tasks() > before
        await cockpit.close()
        assert asyncio.all_tasks() == before
        cockpit.page_opened()
        cockpit.page_closed()
        assert asyncio.all_tasks() == before

    with_cockpit(Timed(), work)


def test_a_page_cannot_ask_for_more_than_there_is() -> None:
    link = Timed()

    async def work(cockpit: Cockpit) -> None:
        cockpit.steer("page", Stick(9.0, -9.0, 99.0, -9.0))
        await until(lambda: link.sticks)

    with_cockpit(link, work)
    fastest = FASTEST
    assert link.sticks[0][1] == Stick(
        fastest.ahead_mps, -fastest.left_mps, fastest.yaw_rate_rps, -fastest.climb_mps
    )


def test_a_wish_is_read_in_metres_and_degrees() -> None:
    stick = stick_of({"do": "manual", "vx": 0.5, "vy": -0.25, "yaw": 180, "up": 0.1})
    assert stick == Stick(0.5, -0.25, pytest.approx(3.14159, abs=1e-4), 0.1)
    for value in ("1", None, float("nan"), True):
        with pytest.raises(GroundError):
            stick_of({"do": "manual", "vx": value})
