# SPDX-License-Identifier: GPL-3.0-or-later
"""A page's questions about the map, over the real socket."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection

from ground.core import CellState, MissionReason, MissionState
from ground.model import MapPiece, Point, Pose, Ranges, RoutePiece, Telemetry
from tests.ground.stations import packet_of
from tests.web.running import Running

FREE, WALL = bytes([CellState.FREE] * 64), bytes([CellState.OCCUPIED] * 64)
KNOWN_TILES = [16 * row + column for row in range(4, 12) for column in range(4, 12)]
BESIDE = Ranges(1000, None, None, 0.5, None, None)


def flying(goal: Point) -> Telemetry:
    pose = Pose(0.0, 0.0, 0.4, 0.0)
    return Telemetry(1000, pose, goal, MissionState.FOLLOW, MissionReason.OK, 100)


def say_a_room(running: Running) -> None:
    """Send a map, free around the drone and 3.2 m wide; a wall ahead ends 0.5 m to the left."""
    for tile in KNOWN_TILES:
        row, column = divmod(tile, 16)
        states = WALL if column == 9 and row < 9 else FREE
        running.link.say(packet_of(MapPiece(tile, 0, states, ())))


async def said(page: ClientConnection, kind: str) -> dict[str, Any]:
    async with asyncio.timeout(20):
        while True:
            message = await page.recv()
            if isinstance(message, str) and (found := json.loads(message))["kind"] == kind:
                return dict(found)


async def ask(page: ClientConnection, **wish: object) -> None:
    await page.send(json.dumps(wish))


def with_page(work: Callable[[Running, ClientConnection], Awaitable[None]]) -> None:
    async def run() -> None:
        async with Running().served() as running, running.page() as page:
            await work(running, page)

    asyncio.run(run())


def test_a_goal_is_previewed_or_refused() -> None:
    async def work(running: Running, page: ClientConnection) -> None:
        await ask(page, do="ask", x=1.0, y=0.0)
        assert (await said(page, "preview"))["words"] == "there is no data of the drone yet"
        running.link.say(flying(Point(0.0, 0.0)))
        say_a_room(running)
        assert running.cockpit.station is not None
        while running.cockpit.station.picture.map.known_cells < 64 * len(KNOWN_TILES):
            await said(page, "state")
        await ask(page, do="ask", x=-0.8, y=0.5)
        answer = await said(page, "preview")
        assert answer["ok"]
        assert answer["path"][0] == pytest.approx([0.0, 0.0], abs=0.01)
        assert answer["path"][-1] == pytest.approx([-0.8, 0.5], abs=0.01)
        assert "tree" not in answer
        await ask(page, do="ask", x=0.6, y=0.0)
        answer = await said(page, "preview")
        assert not answer["ok"]
        assert "too near to an obstacle" in answer["words"]
        assert answer["path"] == []
        assert running.link.acts == [], "asking is not flying"

    with_page(work)


def test_of_many_places_the_newest_is_answered_and_commands_go_on() -> None:
    async def work(running: Running, page: ClientConnection) -> None:
        running.link.say(flying(Point(0.0, 0.0)))
        await said(page, "state")
        for i in range(200):
            await ask(page, do="ask", x=0.005 * i, y=0.1)
        await ask(page, do="ask", x=float("nan"), y=0.0)
        await ask(page, do="hold")
        answers, last = 0, -1.0
        while last < 0.99:
            last = (await said(page, "preview"))["x"]
            answers += 1
        assert answers < 50
        while not running.link.acts:
            await asyncio.sleep(0)

    with_page(work)


def test_layers_come_when_they_are_wanted() -> None:
    async def work(running: Running, page: ClientConnection) -> None:
        goal = Point(1.2, -0.5)
        route = RoutePiece(1, 0, 2, (Point(0.0, 0.0), goal))
        running.link.say(flying(goal), route, BESIDE)
        say_a_room(running)
        await ask(page, do="layers", want=["frontiers", "nonsense", 7])
        layers = await said(page, "layers")
        while not layers["frontiers"]:
            layers = await said(page, "layers")
        assert set(layers) == {"kind", "frontiers"}
        assert sum(first for *_, first in layers["frontiers"]) == 1
        await ask(page, do="layers", want=["tree"])
        layers = await said(page, "layers")
        while not layers.get("tree"):
            layers = await said(page, "layers")
        await ask(page, do="ask", x=1.2, y=-0.6)
        assert (await said(page, "preview"))["tree"]
        await ask(page, do="layers", want=["people"])
        layers = await said(page, "layers")
        while "people" not in layers:
            layers = await said(page, "layers")
        assert layers["people"][0] == pytest.approx([0.0, 0.5], abs=0.05)

    with_page(work)
