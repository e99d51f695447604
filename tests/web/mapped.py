# SPDX-License-Identifier: GPL-3.0-or-later
"""The page's map in a real browser, with a drone in memory and simulated mouse and touch."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

from playwright.sync_api import Browser, BrowserContext, CDPSession, Page, WebSocket, expect

from ground.core import MissionReason, MissionState
from ground.model import Point, Pose, Telemetry
from tests.web.browsing import Tab, browsing
from tests.web.threaded import Ground

Place = tuple[float, float]
Json: TypeAlias = Any  # whatever the page says
WAIT_MS = 20_000


def hovering(x_m: float, y_m: float) -> Telemetry:
    pose = Pose(x_m, y_m, 0.4, 0.0)
    return Telemetry(1000, pose, Point(0.0, 0.0), MissionState.HOVER, MissionReason.OK, 100)


class Map(Tab):
    """The page's map, what the page has sent, and a drone in memory behind it."""

    def __init__(self, context: BrowserContext, ground: Ground) -> None:
        super().__init__(context, ground.address)
        self.ground = ground
        self.sent: list[dict[str, Any]] = []
        self.page.on("websocket", self._note)
        self.page.goto(ground.address)
        expect(self.page.locator("#state")).to_have_text("holding its place", timeout=WAIT_MS)
        self.wait(lambda: self.ask("map.state?.trail.points.length") == 0)
        self.rest()

    def _note(self, socket: WebSocket) -> None:
        socket.on("framesent", lambda payload: self.sent.append(json.loads(payload)))

    def ask(self, expression: str) -> Json:
        return self.page.evaluate(f"() => {{ const map = wayflie.map; return {expression}; }}")

    def at(self, x_m: float, y_m: float) -> Place:
        """Place on the page in pixels; the map begins at its upper left corner."""
        found = self.ask(f"map.camera.toScreen({x_m}, {y_m})")
        return found[0], found[1]

    def wishes(self, what: str) -> list[dict[str, Any]]:
        return [wish for wish in self.sent if wish["do"] == what]

    def sent_goal(self) -> Place:
        """Wait for the first goal that the drone is sent to."""
        self.wait(lambda: self.wishes("goto"))
        goal = self.wishes("goto")[0]
        return goal["x"], goal["y"]

    def drag(self, start: Place, end: Place) -> None:
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        mouse.move(*end, steps=5)
        mouse.up()


@contextmanager
def map_of_a_hovering_drone(browser: Browser, size: tuple[int, int]) -> Iterator[Map]:
    """A map with a drone that hovers at (0.5, -0.25)."""
    ground = Ground()
    with ground.running(), browsing(browser, size) as context:
        ground.call(lambda: ground.link.say(hovering(0.5, -0.25)))
        map_of_it = Map(context, ground)
        yield map_of_it
        assert map_of_it.problems == []


class Fingers:
    """Touches of two hands, moved in small steps."""

    def __init__(self, page: Page) -> None:
        self._session: CDPSession = page.context.new_cdp_session(page)

    def put(self, *places: Place) -> None:
        self._send("touchStart", places)

    def move(self, *ways: tuple[Place, Place]) -> None:
        for share in (0.2, 0.4, 0.6, 0.8, 1.0):
            between = [
                (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])) for a, b in ways
            ]
            self._send("touchMove", between)

    def lift(self) -> None:
        self._send("touchEnd", ())

    def _send(self, kind: str, places: Sequence[Place]) -> None:
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
