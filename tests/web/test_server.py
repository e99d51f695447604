# SPDX-License-Identifier: GPL-3.0-or-later
"""The server: only this machine's own page may talk to it, and it holds the latch itself."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest
from starlette.testclient import TestClient, WebSocketDenialResponse, WebSocketTestSession

from ground.core import (
    MissionCmd,
    MissionReason,
    MissionState,
)
from ground.model import Point, Pose, Telemetry
from ground.requests import Command, EmergencyStop
from ground.station.station import Station
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet
from ground.web.server import make_app
from tests.ground.fakelink import FakeLink

BASE = "http://127.0.0.1:8765"
SOCKET = "ws://127.0.0.1:8765/socket"
ORIGIN = {"origin": BASE}


def flying(drone_ms: int = 1000) -> Telemetry:
    pose = Pose(1.0, 2.0, 0.4, 0.5)
    return Telemetry(drone_ms, pose, Point(3.0, 1.0), MissionState.FOLLOW, MissionReason.OK, 100)


@pytest.fixture
def client() -> TestClient:
    """A server without a drone."""
    return TestClient(make_app(Fleet()), base_url=BASE)


def denied(client: TestClient, headers: dict[str, str]) -> int:
    """The status with which a WebSocket is refused."""
    with (
        pytest.raises(WebSocketDenialResponse) as refusal,
        client.websocket_connect(SOCKET, headers=headers),
    ):
        pass
    return int(refusal.value.status_code)


@pytest.mark.parametrize("path", ["/", "/app.js", "/view.js", "/style.css"])
def test_static_files_come_with_a_policy(client: TestClient, path: str) -> None:
    answer = client.get(path)
    assert answer.status_code == 200
    assert "default-src 'none'" in answer.headers["content-security-policy"]
    assert "http://" not in answer.text.replace("http://www.w3.org/2000/svg", "")
    assert "https://" not in answer.text


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:8765", "192.168.1.7"])
def test_another_host_name_is_refused(client: TestClient, host: str) -> None:
    assert client.get("/", headers={"host": host}).status_code == 400
    assert denied(client, {"host": host, "origin": f"http://{host}"}) == 400


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "http://127.0.0.1:9999", "null", "http://localhost:8765", ""]
)
def test_a_foreign_origin_is_refused(client: TestClient, origin: str) -> None:
    assert denied(client, {"origin": origin}) == 403
    assert client.get("/", headers={"origin": origin}).status_code == 403


def test_a_socket_without_origin_is_refused(client: TestClient) -> None:
    assert denied(client, {}) == 403


def test_files_outside_are_not_served(client: TestClient) -> None:
    for path in ("/../server.py", "/%2e%2e/server.py", "/..%2fserver.py"):
        assert client.get(path).status_code == 404


class Drone:
    """A fake drone with a station, on the loop of a test client."""

    def __init__(self) -> None:
        self.link = FakeLink()
        self.cockpit = Cockpit(dead_man_s=0.05)

    @contextlib.asynccontextmanager
    async def lifespan(self, app: object) -> AsyncIterator[None]:
        """Run the station for as long as the server runs."""
        station = Station(self.link)
        running = asyncio.create_task(station.run())
        await self.link.open()
        self.cockpit.station = station
        yield
        await self.cockpit.close()
        await self.link.close()
        await running


@pytest.fixture
def drone() -> Drone:
    return Drone()


@pytest.fixture
def page(drone: Drone) -> Iterator[WebSocketTestSession]:
    """A connected page."""
    app = make_app(Fleet.of(drone.cockpit))
    app.router.lifespan_context = drone.lifespan
    with (
        TestClient(app, base_url=BASE) as client,
        client.websocket_connect(SOCKET, headers=ORIGIN) as socket,
    ):
        yield socket


def receive(page: WebSocketTestSession, kind: str) -> dict[str, Any]:
    """The next message of a kind."""
    while True:
        message = page.receive()
        if "text" in message:
            frame: dict[str, Any] = json.loads(message["text"])
            if frame["kind"] == kind:
                return frame


def state_where(page: WebSocketTestSession, *keys: str, value: object) -> dict[str, Any]:
    """The first state frame in which the nested key has the value."""
    while True:
        frame = receive(page, "state")
        inner: Any = frame
        for key in keys:
            inner = inner[key]
        if inner == value:
            return frame


def test_goal_arrives_at_the_drone(page: WebSocketTestSession, drone: Drone) -> None:
    page.send_json({"do": "goto", "x": 1.25, "y": -2})
    answer = receive(page, "answer")
    assert answer == {"kind": "answer", "do": "goto", "ok": True, "words": "", "step": ""}
    assert [(act.cmd, act.goal) for act in drone.link.acts] == [
        (MissionCmd.GOTO, Point(1.25, -2.0))
    ]


@pytest.mark.parametrize(
    "wish",
    [
        {"do": "goto"},
        {"do": "goto", "x": "1", "y": 2},
        {"do": "goto", "x": float("nan"), "y": 2},
        {"do": "self-destruct"},
        {"do": "forget"},
    ],
)
def test_nonsense_is_answered_and_goes_nowhere(
    page: WebSocketTestSession, drone: Drone, wish: dict[str, Any]
) -> None:
    page.send_json(wish)
    answer = receive(page, "answer")
    assert not answer["ok"]
    assert answer["words"]
    assert drone.link.acts == []


def test_garbage_does_not_end_the_connection(page: WebSocketTestSession, drone: Drone) -> None:
    for text in ("", "{", "[]", "7", '"stop"', '{"do": 3}', '{"do": null}'):
        page.send_text(text)
    page.send_json({"do": "hold"})
    assert receive(page, "answer")["ok"]


def test_stop_latches_for_all_until_released(page: WebSocketTestSession, drone: Drone) -> None:
    page.send_json({"do": "stop"})
    frame = state_where(page, "stop", "latched", value=True)
    assert not any(frame["can"].values())
    assert drone.link.count(EmergencyStop) >= 1
    page.send_json({"do": "take_off"})
    answer = receive(page, "answer")
    assert (answer["ok"], answer["words"]) == (False, "STOP is pressed: release it first")
    page.send_json({"do": "release"})
    state_where(page, "stop", "latched", value=False)
    page.send_json({"do": "take_off"})
    assert receive(page, "answer")["ok"]
    assert [act.cmd for act in drone.link.acts] == [MissionCmd.TAKE_OFF]


def test_a_stop_comes_as_a_plain_request_too_but_from_no_foreign_page(drone: Drone) -> None:
    app = make_app(Fleet.of(drone.cockpit))
    app.router.lifespan_context = drone.lifespan
    with TestClient(app, base_url=BASE) as client:
        assert client.post("/stop", headers={"origin": "http://evil.example"}).status_code == 403
        assert not drone.cockpit.stop_latched
        assert client.get("/stop", headers=ORIGIN).status_code == 404
        assert not drone.cockpit.stop_latched
        assert client.post("/stop", headers=ORIGIN).status_code == 204
        assert drone.cockpit.stop_latched


def test_drone_holds_when_the_page_that_steered_is_gone(drone: Drone) -> None:
    app = make_app(Fleet.of(drone.cockpit))
    app.router.lifespan_context = drone.lifespan
    with TestClient(app, base_url=BASE) as client:
        with client.websocket_connect(SOCKET, headers=ORIGIN) as page:
            page.send_json({"do": "explore"})
            receive(page, "answer")
            drone.link.say(flying())
            state_where(page, "mission", "state", value="FOLLOW")
        assert client.portal is not None
        client.portal.call(wait_for_hold, drone.link)


async def wait_for_hold(link: FakeLink) -> None:
    while [act.cmd for act in link.acts] != [MissionCmd.EXPLORE, MissionCmd.HOLD]:
        await asyncio.sleep(0.01)


def test_dead_man_leaves_a_flight_alone_that_no_page_began(drone: Drone) -> None:
    async def run() -> list[Command]:
        async with drone.lifespan(None):
            drone.link.say(flying())
            await asyncio.sleep(0.01)
            drone.cockpit.page_opened()
            drone.cockpit.page_closed()
            await asyncio.sleep(0.15)
            return drone.link.acts

    assert asyncio.run(run()) == []
