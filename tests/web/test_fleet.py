# SPDX-License-Identifier: GPL-3.0-or-later
"""Floods of requests are limited and a stop gets through them; several drones on one page."""

import asyncio
import json
import re
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.testclient import TestClient, WebSocketTestSession
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed, InvalidStatus

from ground.core import MissionState
from ground.errors import LinkUnavailable
from ground.model import LinkChange, LinkState
from ground.requests import EmergencyStop
from ground.station.station import Station, station_on
from ground.web.cockpit import Cockpit
from ground.web.fleet import COLOURS, Fleet, Member, Place
from ground.web.flow import Allowance
from ground.web.page import COMMANDS_AT_ONCE, WISHES_AT_ONCE, WISHES_PER_S
from ground.web.server import MESSAGE_BYTES, PAGES, STATIC, make_app
from tests.ground.fakelink import FakeLink
from tests.ground.stations import telemetry
from tests.web.colours import contrast
from tests.web.running import Running


async def answers(page: ClientConnection, count: int) -> list[dict[str, Any]]:
    """The next answers to requests; states and maps in between are skipped."""
    found: list[dict[str, Any]] = []
    while len(found) < count:
        message = await page.recv()
        if isinstance(message, str) and (frame := json.loads(message))["kind"] == "answer":
            found.append(frame)
    return found


def test_a_flood_is_bounded_and_a_stop_gets_through_it() -> None:
    async def run() -> None:
        async with Running().served() as running, running.page() as page:
            for _ in range(300):
                await page.send(json.dumps({"do": "hold"}))
            await page.send(json.dumps({"do": "stop"}))
            refused = [a for a in await answers(page, 300) if a["words"] == "too much at once"]
            assert len(refused) >= 200
            assert running.cockpit.stop_latched
            assert running.link.count(EmergencyStop) > 0
            assert len(running.link.acts) <= 100

    asyncio.run(run())


def test_a_message_that_is_too_long_ends_that_page_only() -> None:
    async def run() -> None:
        async with Running().served() as running, running.page() as other:
            async with running.page() as page:
                await page.send("x" * (MESSAGE_BYTES + 1))
                with pytest.raises(ConnectionClosed):
                    while True:
                        await page.recv()
            await other.send(json.dumps({"do": "stop"}))
            while not running.cockpit.stop_latched:
                await other.recv()

    asyncio.run(run())


def test_deep_nesting_is_no_wish_and_no_end() -> None:
    async def run() -> None:
        async with Running().served() as running, running.page() as page:
            await page.send("[" * (MESSAGE_BYTES - 1))
            await page.send(json.dumps({"do": "stop"}))
            while not running.cockpit.stop_latched:
                await page.recv()

    asyncio.run(run())


def test_more_pages_than_there_is_room_for_are_closed_and_those_there_are_may_stop() -> None:
    async def run() -> None:
        async with Running().served() as running:
            pages = [await running.page() for _ in range(PAGES)]
            for page in pages:
                await page.recv()
            with pytest.raises((ConnectionClosed, InvalidStatus)):
                async with running.page() as late:
                    await late.recv()
            await pages[-1].send(json.dumps({"do": "stop"}))
            while not running.cockpit.stop_latched:
                await pages[-1].recv()
            for page in pages:
                await page.close()

    asyncio.run(run())


@given(st.lists(st.floats(0.0, 2.0), max_size=200))
def test_the_rate_holds_over_any_time(pauses_s: list[float]) -> None:
    allowance, now_s, taken = Allowance(0.0, WISHES_PER_S, WISHES_AT_ONCE), 0.0, 0
    for pause_s in pauses_s:
        now_s += pause_s
        taken += allowance.allows(now_s)
    assert taken <= WISHES_AT_ONCE + WISHES_PER_S * now_s
    assert Allowance(0.0, WISHES_PER_S, WISHES_AT_ONCE).allows(0.0)


def test_a_stop_that_was_pressed_without_a_link_is_sent_when_there_is_one() -> None:
    async def run() -> int:
        cockpit, link = Cockpit(), FakeLink()
        cockpit.stop()
        await asyncio.sleep(0.05)
        async with station_on(link) as station:
            cockpit.station = station
            while not link.count(EmergencyStop):
                await asyncio.sleep(0.01)
            await cockpit.close()
            return link.count(EmergencyStop)

    assert asyncio.run(run()) > 0


def test_the_stop_of_a_page_is_for_all_drones() -> None:
    async def run() -> None:
        fleet = Fleet.of(Cockpit(), Cockpit(), Cockpit())
        fleet.stop()
        assert all(cockpit.stop_latched for cockpit in fleet.cockpits)
        fleet.release()
        assert not any(cockpit.stop_latched for cockpit in fleet.cockpits)
        await asyncio.gather(fleet.close())

    asyncio.run(run())


@pytest.mark.parametrize("colour", COLOURS)
def test_a_drone_is_seen_in_the_light_and_in_the_dark(colour: str) -> None:
    style = (STATIC / "style.css").read_text()
    grounds = re.findall(r"--free: (#\w+);", style)
    assert len(grounds) == 2
    assert min(contrast(colour, ground) for ground in grounds) >= 3.0
    assert len(set(COLOURS)) == len(COLOURS)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1))
def test_drones_are_shown_where_they_are_for_each_other(x: float, y: float, yaw: float) -> None:
    stations = [Station(FakeLink()), Station(FakeLink())]
    for station in stations:
        station.picture.take(telemetry(1, MissionState.HOVER, 0.5, 0.25), 0.0)
    members = [Member(Cockpit(station)) for station in stations]
    members[1].place = Place(x, y, yaw)
    fleet = Fleet(members)
    own = fleet.seen_from(1, 1)
    assert own is not None
    assert (own.x_m, own.y_m, own.yaw_rad) == pytest.approx((0.5, 0.25, 0.0), abs=1e-9)
    there = fleet.seen_from(0, 1)
    assert there is not None
    assert abs(complex(there.x_m - x, there.y_m - y)) == pytest.approx(abs(0.5 + 0.25j))
    assert there.yaw_rad == pytest.approx(yaw)
    members[1].place = None
    assert fleet.seen_from(0, 1) is None


@pytest.fixture
def two_pages() -> Iterator[tuple[WebSocketTestSession, Fleet]]:
    """A page of two drones, both absent."""
    fleet = Fleet([Member(Cockpit(), "one"), Member(Cockpit(), "two")])
    fleet.members[1].cockpit.trouble = LinkUnavailable("nobody answers at two", "ask three")
    base = "http://127.0.0.1:8765"
    with TestClient(make_app(fleet), base_url=base).websocket_connect(
        "ws://127.0.0.1:8765/socket", headers={"origin": base}
    ) as page:
        yield page, fleet


@pytest.mark.parametrize("number", [-1, 2, 1.0, "1", None, True, 10**30])
def test_a_drone_that_is_not_there_is_not_chosen(
    two_pages: tuple[WebSocketTestSession, Fleet], number: object
) -> None:
    page, _ = two_pages
    page.send_json({"do": "choose", "drone": number})
    answer = None
    while answer is None or answer["kind"] != "answer":
        answer = page.receive_json()
    assert not answer["ok"]


def test_the_page_says_what_is_happening_to_each(
    two_pages: tuple[WebSocketTestSession, Fleet],
) -> None:
    page, _ = two_pages
    page.send_json({"do": "choose", "drone": 1})
    frame = page.receive_json()
    while not frame["fleet"][1]["chosen"]:
        frame = page.receive_json()
    link = {"state": "closed", "detail": "nobody answers at two", "step": "ask three"}
    assert frame["link"] == link
    assert [row["name"] for row in frame["fleet"]] == ["one", "two"]


def test_a_link_that_is_being_looked_for_permits_no_command() -> None:
    link = FakeLink()

    async def run() -> None:
        async with Running().served() as running, running.page() as page:
            for state in (LinkState.RECONNECTING, LinkState.SILENT, LinkState.RESTARTED):
                running.link.say(LinkChange(state, "looking"))
                while (
                    not isinstance(text := await page.recv(), str)
                    or (frame := json.loads(text))["kind"] != "state"
                    or frame["link"]["state"] != state.value
                ):
                    pass
                assert frame["link"]["detail"] == "looking"
                assert not any(frame["can"].values())

    asyncio.run(run())
    assert link.acts == []


def test_only_so_many_commands_wait_for_an_answer() -> None:
    async def run() -> None:
        running = Running()
        async with running.served(), running.page() as page:
            running.link._hears = lambda message: False
            for _ in range(COMMANDS_AT_ONCE + 3):
                await page.send(json.dumps({"do": "hold"}))
            refused = await answers(page, 3)
            assert {answer["words"] for answer in refused} == {"too much at once"}

    asyncio.run(run())
