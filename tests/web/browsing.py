# SPDX-License-Identifier: GPL-3.0-or-later
"""A real browser on the page: what it is sent, where places are on the screen, screenshots."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Page, WebSocket, expect, sync_playwright

ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
SCREENS = Path(__file__).resolve().parents[2] / "build" / "screens"
DESK = (1280, 800)
PHONE = (390, 844)
WAIT_MS = 120_000
POLL_MS = 20
CONNECTION_GONE = "ERR_CONNECTION_REFUSED"

Frame = dict[str, Any]

expect.set_options(timeout=WAIT_MS)


@contextmanager
def chromium() -> Iterator[Browser]:
    """Debian's browser, without a window."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=ARGUMENTS)
        yield browser
        browser.close()


def away_m(state: Frame, place: Sequence[float]) -> float:
    """How far the drone is from there, on the map."""
    return math.dist(state["drone"]["pose"][:2], place)


class Tab:
    """A page in the browser, the last state and map that it was sent, and its errors."""

    def __init__(self, context: BrowserContext, address: str) -> None:
        self.page: Page = context.new_page()
        self.address = address
        self.socket: WebSocket | None = None
        self.states: list[Frame] = []
        self.forget()
        self.problems: list[str] = []
        self.page.on("websocket", self._listen)
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", lambda line: line.type == "error" and self._complain(line.text))
        self.page.on(
            "request",
            lambda request: (
                request.url.startswith((address, "data:")) or self._complain(request.url)
            ),
        )

    def open(self) -> Tab:
        """Load the page and wait until the drone is connected."""
        self.page.goto(self.address)
        return self.ready()

    def reload(self) -> Tab:
        """Reload as the user does, and wait until the drone is connected."""
        self.socket = None
        self.forget()
        self.page.reload()
        return self.ready()

    def ready(self) -> Tab:
        """Wait until the drone accepts commands."""
        return self.until(lambda state: state["can"]["goto"])

    def until(self, condition: Callable[[Frame], object]) -> Tab:
        """Wait until the latest state, or one that comes after it, has met a condition."""
        first = max(0, len(self.states) - 1)
        return self.wait(lambda: any(condition(state) for state in self.states[first:]))

    def wait(self, condition: Callable[[], object]) -> Tab:
        """Wait for it."""
        for _ in range(WAIT_MS // POLL_MS):
            if condition():
                return self
            self.page.wait_for_timeout(POLL_MS)
        raise AssertionError(f"it did not happen; the last state: {self.state}")

    def rest(self) -> Tab:
        """Wait until nothing on the map has to be drawn any more."""
        return self.wait(lambda: not self.page.evaluate("wayflie.map.due"))

    def place(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Where a map point is on the page, in CSS pixels."""
        box = self.page.locator("#map").bounding_box()
        assert box is not None
        x_px, y_px = self.page.evaluate("([x, y]) => wayflie.map.camera.toScreen(x, y)", [x_m, y_m])
        return box["x"] + x_px, box["y"] + y_px

    def point_at(self, x_m: float, y_m: float) -> None:
        """Move the mouse there; the map is not fitted anew until it moves again."""
        place = (0.0, 0.0)
        while math.dist(place, now := self.place(x_m, y_m)) > 1.0:
            place = now
            self.page.mouse.move(*place)
            self.page.evaluate("wayflie.map.camera.touched(true)")  # as by a finger

    def click(self, x_m: float, y_m: float) -> None:
        """Click there with the mouse."""
        self.point_at(x_m, y_m)
        self.page.mouse.down()
        self.page.mouse.up()

    def press(self, name: str) -> None:
        """Press the button with this name."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def shot(self, name: str) -> None:
        """Save a screenshot."""
        SCREENS.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=SCREENS / f"{name}.png")

    def _complain(self, text: str) -> None:
        """Note an error, except that the server is gone, which is not the page's fault."""
        if CONNECTION_GONE not in text:
            self.problems.append(text)

    def forget(self) -> None:
        """Forget all messages so far."""
        self.state: Frame = {}
        self.states.clear()
        self.trail: list[list[float]] = []
        self.events: list[Frame] = []
        self.map = b""

    def _listen(self, socket: WebSocket) -> None:
        self.socket = socket
        self.forget()
        socket.on("framereceived", lambda payload: self._take(socket, payload))

    def _take(self, socket: WebSocket, payload: str | bytes) -> None:
        """Note a message; those to a page that was left are ignored."""
        if socket is not self.socket:
            return
        if isinstance(payload, bytes):
            self.map = payload
            return
        frame: Frame = json.loads(payload)
        if frame["kind"] == "events":
            self.events = frame["rows"]
        if frame["kind"] == "state":
            self.state = frame
            self.states.append(frame)
            news = frame["trail"]
            self.trail = [*self.trail[: news["from"]], *news["points"]]


@contextmanager
def browsing(
    browser: Browser, size: tuple[int, int] = DESK, dark: bool = False
) -> Iterator[BrowserContext]:
    """Cookies and settings of one user: desktop or phone, light or dark."""
    width, height = size
    context = browser.new_context(
        viewport={"width": width, "height": height},
        color_scheme="dark" if dark else "light",
        has_touch=size == PHONE,
        is_mobile=size == PHONE,
        device_scale_factor=2 if size == PHONE else 1,
    )
    try:
        yield context
    finally:
        context.close()


@contextmanager
def tab_at(
    browser: Browser, address: str, size: tuple[int, int] = DESK, dark: bool = False
) -> Iterator[Tab]:
    """A page in its own browser context; at the end it must have had no errors."""
    with browsing(browser, size, dark) as context:
        tab = Tab(context, address)
        yield tab
        assert tab.problems == []
