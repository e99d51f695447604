# SPDX-License-Identifier: GPL-3.0-or-later
"""Who may connect and how much they may send; a stop is accepted whatever else was sent."""

import asyncio
import json
import socket
import urllib.request
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.testclient import TestClient, WebSocketDenialResponse
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from ground.web.access import is_local
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet
from ground.web.server import (
    make_app,
)
from tests.web.running import Running

TOKEN = "a-token-of-this-test"
HERE = "192.168.7.7:8765"
BASE = f"http://{HERE}"
SOCKET = f"ws://{HERE}/socket"


@pytest.fixture
def guarded() -> TestClient:
    """A server that is bound to more than this machine's own address."""
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
    """And no exception escapes, which would be a 500."""
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
    """Send a request whose target no client library would send."""
    with socket.create_connection(("127.0.0.1", port), timeout=20) as client:
        host = f"127.0.0.1:{port}".encode()
        client.sendall(b"GET " + target + b" HTTP/1.1\r\nhost: " + host + b"\r\n\r\n")
        return client.recv(4096)


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
