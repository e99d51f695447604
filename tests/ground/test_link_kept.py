# SPDX-License-Identifier: GPL-3.0-or-later
"""A link that is kept up: what its reader sees when links break and drones restart."""

import asyncio
from collections.abc import AsyncIterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import MissionState
from ground.errors import LinkUnavailable, ProtocolMismatch
from ground.link.kept import KeptLink
from ground.link.logstream import CLOCK_MS, LONGEST_GAP_MS, RESTART_MS, restarted
from ground.model import Console, Incoming, LinkChange, LinkState, LinkStats, MapPiece
from ground.requests import HelloRequest, Outgoing
from tests.ground.stations import packet_of, telemetry

CONNECTED = LinkChange(LinkState.CONNECTED, "")
LOST = LinkChange(LinkState.LOST, "gone")
PIECE = packet_of(MapPiece(0, 0, bytes(64), ()))


class ScriptedLink:
    """Delivers a script of messages and then ends, or waits where the script has None."""

    def __init__(self, *script: Incoming | None, error: Exception | None = None) -> None:
        self._script, self._error = script, error
        self.sent: list[Outgoing] = []
        self.closed = 0

    @property
    def stats(self) -> LinkStats:
        return LinkStats(log_packets=10, lost_packets=1)

    async def open(self) -> None:
        if self._error:
            raise self._error

    async def close(self) -> None:
        self.closed += 1

    def send(self, message: Outgoing) -> None:
        self.sent.append(message)

    async def messages(self) -> AsyncIterator[Incoming]:
        for message in self._script:
            if message is None:
                await asyncio.Event().wait()
            else:
                yield message


def at(drone_ms: int) -> Incoming:
    return telemetry(drone_ms, MissionState.HOVER)


def heard(*links: ScriptedLink) -> list[Incoming]:
    """What a reader hears from these links in turn, until the last has ended."""
    supply = iter(links)
    kept = KeptLink(lambda: next(supply, ScriptedLink(error=ProtocolMismatch("no more"))))

    async def run() -> list[Incoming]:
        await kept.open()
        return [message async for message in kept.messages()]

    found = asyncio.run(run())
    assert all(link.closed == 1 for link in links if link._error is None)
    return found


def states(messages: list[Incoming]) -> list[LinkState]:
    return [message.state for message in messages if isinstance(message, LinkChange)]


C, L, R, N = (
    LinkState.CONNECTED,
    LinkState.LOST,
    LinkState.RECONNECTING,
    LinkState.RESTARTED,
)


def test_a_lost_link_is_made_anew_until_nothing_can_be_done() -> None:
    gone = ScriptedLink(error=LinkUnavailable("nobody"))
    found = heard(ScriptedLink(CONNECTED, at(100), LOST), gone, ScriptedLink(CONNECTED, at(5000)))
    assert states(found) == [C, R, C, R, L]
    assert [m.drone_ms for m in found if m == at(100) or m == at(5000)] == [100, 5000]
    assert found[-1] == LinkChange(L, "no more")


def test_a_drone_that_began_anew_is_told_before_anything_of_its_new_flight() -> None:
    again = ScriptedLink(CONNECTED, PIECE, Console("hi"), at(1500), LOST)
    found = heard(ScriptedLink(CONNECTED, at(90_000), LOST), again)
    assert states(found) == [C, R, N, C, R, L]
    assert found.index(PIECE) > states(found).index(N)


def test_what_waits_for_the_time_is_not_held_back_for_ever() -> None:
    silent = ScriptedLink(CONNECTED, *[PIECE] * 1000)
    found = heard(ScriptedLink(CONNECTED, at(90_000), LOST), silent)
    assert found.count(PIECE) == 1000
    assert N not in states(found)


def test_a_restart_behind_a_standing_link_connects_anew() -> None:
    found = heard(ScriptedLink(CONNECTED, at(90_000), at(1200), at(1250)), ScriptedLink(at(1300)))
    assert states(found) == [C, N, R, R, L]
    assert at(1250) not in found and at(1300) in found


def test_figures_are_of_all_links() -> None:
    links = iter([ScriptedLink(CONNECTED, LOST), ScriptedLink(CONNECTED, None)])

    async def run() -> LinkStats:
        kept = KeptLink(lambda: next(links))
        await kept.open()
        reader = aiter(kept.messages())
        while (await anext(reader)) != LinkChange(R, "looking for the drone: gone"):
            pass
        kept.send(HelloRequest())
        assert await anext(reader) == CONNECTED
        kept.send(HelloRequest())
        await kept.close()
        return kept.stats

    assert asyncio.run(run()) == LinkStats(log_packets=20, lost_packets=2)


def closed_while_it_searches(*script: ScriptedLink) -> tuple[list[Incoming], int]:
    """What is heard if the link is closed shortly after a loss, and the links left unused."""
    links = iter(script)

    async def run() -> list[Incoming]:
        kept = KeptLink(lambda: next(links, ScriptedLink(error=LinkUnavailable("nobody"))))
        await kept.open()
        found = []
        async with asyncio.timeout(5.0):
            async for message in kept.messages():
                found.append(message)
                if states(found)[-1:] == [R]:
                    asyncio.get_running_loop().call_later(0.01, asyncio.ensure_future, kept.close())
        return found

    return asyncio.run(run()), len(list(links))


def test_closing_ends_the_search() -> None:
    found, _ = closed_while_it_searches(ScriptedLink(CONNECTED, LOST))
    assert states(found) == [C, R]


def test_closing_while_a_lost_link_is_let_go_begins_no_search() -> None:
    class SlowLink(ScriptedLink):
        async def close(self) -> None:
            await asyncio.sleep(0.02)
            await super().close()

    again = ScriptedLink(CONNECTED, None)
    found, not_asked_for = closed_while_it_searches(SlowLink(CONNECTED, LOST), again)
    assert (states(found), not_asked_for) == ([C, R], 1)


@given(st.integers(0, 2**32), st.integers(0, LONGEST_GAP_MS), st.floats(0, 100))
def test_time_that_goes_on_is_no_restart(before_ms: int, step_ms: int, elapsed_s: float) -> None:
    assert not restarted(before_ms, before_ms + step_ms, elapsed_s)
    assert not restarted(before_ms % CLOCK_MS, before_ms + step_ms, elapsed_s)
    assert not restarted(before_ms + min(step_ms, RESTART_MS), before_ms, elapsed_s)


@given(st.integers(RESTART_MS + 1, CLOCK_MS - LONGEST_GAP_MS - 2000), st.floats(0, 1e-3))
def test_time_that_goes_back_is_one_however_long_it_flew(back_ms: int, elapsed_s: float) -> None:
    assert restarted(back_ms + 500, 500, elapsed_s)


@pytest.mark.parametrize("elapsed_s", [0.0, 1.0])
def test_a_simulator_may_be_fast(elapsed_s: float) -> None:
    assert not restarted(1000, 1000 + round(900_000 * elapsed_s), elapsed_s)
