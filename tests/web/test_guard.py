# SPDX-License-Identifier: GPL-3.0-or-later
"""Who may come in, how much they may send, and that a stop is taken whatever else they sent."""

import asyncio
import json
import socket
import urllib.request
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.testclient import TestClient, WebSocketDenialResponse, WebSocketTestSession
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from ground.core import MissionState
from ground.model import EmergencyStop, LinkChange, LinkState
from ground.station import Station, station_on
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet, Member, Place
from ground.web.guard import is_local
from ground.web.server import (
    COMMANDS_AT_ONCE,
    MESSAGE_BYTES,
    PAGES,
    WISHES_AT_ONCE,
    WISHES_PER_S,
    Rate,
    make_app,
    page_server,
)
from tests.ground.fakelink import FakeLink
from tests.ground.stations import telemetry

TOKEN = "a-token-of-this-test"
HERE = "192.168.7.7:8765"
BASE = f"http://{HERE}"
SOCKET = f"ws://{HERE}/socket"


@pytest.fixture
def guarded() -> TestClient:
    """A server that is bound to more than this machine."""
    return TestClient(make_app(Fleet(), TOKEN), base_url=BASE, follow_redirects=False)


def socket_status(client: TestClient, **headers: str) -> int:
    with (
        pytest.raises(WebSocketDenialResponse) as refusal,
        client.websocket_connect(SOCKET, headers=headers),
    ):
        pass
    return int(refusal.value.status_code)


@pytest.mark.parametrize(
    "path", ["/", "/app.js", "/?token=", "/?token=wrong", f"/?token={TOKEN}x", "/socket"]
)
def test_without_the_token_nothing_is_served(guarded: TestClient, path: str) -> None:
    answer = guarded.get(path)
    assert answer.status_code == 401
    assert TOKEN not in answer.text
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize("cookie", ["", "wayflie=", "wayflie=wrong", f"other={TOKEN}", "\x01;=;"])
def test_without_the_cookie_no_socket_is_opened(guarded: TestClient, cookie: str) -> None:
    headers = {"origin": BASE, "cookie": cookie}
    assert socket_status(guarded, **headers) == 401


def test_the_token_in_the_address_lets_in_once_and_for_all(guarded: TestClient) -> None:
    entered = guarded.get(f"/?token={TOKEN}")
    assert (entered.status_code, entered.headers["location"]) == (303, "/")
    cookie = entered.headers["set-cookie"].lower()
    assert "httponly" in cookie and "samesite=strict" in cookie
    assert guarded.get("/").status_code == 200
    fleet = Fleet.of(Cockpit())
    client = TestClient(make_app(fleet, TOKEN), base_url=BASE, cookies={"wayflie": TOKEN})
    with client.websocket_connect(SOCKET, headers={"origin": BASE}) as page:
        assert json.loads(page.receive()["text"])["kind"] == "state"


@pytest.mark.parametrize("host", ["evil.example", "192.168.7.7.evil.example", "", "[", "a b"])
def test_names_that_others_could_point_here_are_refused(guarded: TestClient, host: str) -> None:
    assert guarded.get(f"/?token={TOKEN}", headers={"host": host}).status_code == 400


def test_a_foreign_site_is_refused_even_with_the_cookie(guarded: TestClient) -> None:
    headers = {"origin": "http://evil.example", "cookie": f"wayflie={TOKEN}"}
    assert socket_status(guarded, **headers) == 403


@pytest.mark.parametrize(
    ("address", "local"),
    [
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("localhost", True),
        ("0.0.0.0", False),
        ("::", False),
        ("192.168.7.7", False),
        ("localhost.evil.example", False),
        ("", False),
    ],
)
def test_what_only_this_machine_reaches(address: str, local: bool) -> None:
    assert is_local(address) is local


@given(st.text(max_size=60), st.text(max_size=60), st.text(max_size=60))
def test_headers_of_any_kind_let_nobody_in(host: str, origin: str, cookie: str) -> None:
    """And no exception comes out, which would be a 500."""
    raw = [
        (b"host", host.encode()),
        (b"origin", origin.encode()),
        (b"cookie", cookie.encode()),
    ]
    scope = {"type": "http", "method": "GET", "path": "/", "raw_path": b"/", "query_string": b"",
             "headers": raw, "root_path": ""}  # fmt: skip
    statuses: list[int] = []

    async def send(message: dict[str, Any]) -> None:
        if message["type"] == "http.response.start":
            statuses.append(message["status"])

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": b""}

    asyncio.run(make_app(Fleet(), TOKEN)(scope, receive, send))
    assert statuses and statuses[0] in (400, 401, 403)


def request_status(port: int, target: bytes) -> bytes:
    """Ask with a target that no client library would send."""
    with socket.create_connection(("127.0.0.1", port), timeout=20) as client:
        host = f"127.0.0.1:{port}".encode()
        client.sendall(b"GET " + target + b" HTTP/1.1\r\nhost: " + host + b"\r\n\r\n")
        return client.recv(4096)


class Running:
    """A real server with a drone in memory."""

    def __init__(self) -> None:
        self.link = FakeLink()
        self.cockpit = Cockpit()
        self.address = ""

    @property
    def port(self) -> int:
        return urlsplit(self.address).port or 0

    @asynccontextmanager
    async def served(self, bind: str = "127.0.0.1") -> AsyncIterator["Running"]:
        async with (
            station_on(self.link) as station,
            page_server(Fleet.of(self.cockpit), 0, bind) as self.address,
        ):
            self.cockpit.station = station
            yield self

    def page(self) -> connect:
        origin = self.address.rstrip("/")
        return connect(f"ws://127.0.0.1:{self.port}/socket", origin=origin, max_size=None)


@pytest.mark.parametrize(
    "target",
    [
        b"/../server.py",
        b"/..%2fserver.py",
        b"/%2e%2e/%2e%2e/server.py",
        b"/....//server.py",
        b"//etc/passwd",
        b"/static/../../cockpit.py",
        b"/%00",
        b"/..\\server.py",
        b"/" + b"a" * 5000,
    ],
)
def test_no_path_leads_out_of_the_folder(target: bytes) -> None:
    async def run() -> bytes:
        async with Running().served() as running:
            return await asyncio.to_thread(request_status, running.port, target)

    answer = asyncio.run(run())
    assert answer.split()[1] in (b"404", b"400", b"405"), answer[:200]
    assert b"SPDX" not in answer


def test_others_are_let_in_by_the_printed_address_only() -> None:
    async def run() -> None:
        async with Running().served("0.0.0.0") as running:
            token = parse_qs(urlsplit(running.address).query)["token"][0]
            assert len(token) > 20
            with pytest.raises(InvalidStatus, match="401"):
                async with connect(
                    f"ws://127.0.0.1:{running.port}/socket",
                    origin=f"http://127.0.0.1:{running.port}",
                ):
                    pass
            address = f"http://127.0.0.1:{running.port}/?token={token}"
            opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())

            def read() -> bytes:
                with opener.open(address) as answer:
                    return bytes(answer.read())

            assert b"Wayflie" in await asyncio.to_thread(read)

    asyncio.run(run())


def test_by_default_only_this_machine_reaches_it() -> None:
    async def run() -> tuple[str, str]:
        async with Running().served() as running:
            found = socket.getaddrinfo(socket.gethostname(), running.port, socket.AF_INET)
            others = {str(entry[4][0]) for entry in found} - {"127.0.0.1"}
            for other in others:
                if not is_local(other):
                    with pytest.raises(OSError):
                        await asyncio.open_connection(other, running.port)
            return running.address, "http://127.0.0.1:"

    address, begin = asyncio.run(run())
    assert address.startswith(begin) and "token" not in address


async def answers(page: ClientConnection, count: int) -> list[dict[str, Any]]:
    """The next answers to wishes; states and maps in between are skipped."""
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
    rate, now_s, taken = Rate(0.0), 0.0, 0
    for pause_s in pauses_s:
        now_s += pause_s
        taken += rate.allows(now_s)
    assert taken <= WISHES_AT_ONCE + WISHES_PER_S * now_s
    assert Rate(0.0).allows(0.0)


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
    """A page of two drones, of which neither is there."""
    fleet = Fleet([Member(Cockpit(), "one"), Member(Cockpit(), "two")])
    fleet.members[1].cockpit.trouble = "nobody answers at two"
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
    assert frame["link"]["detail"] == "nobody answers at two"
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
