# SPDX-License-Identifier: GPL-3.0-or-later
"""Hands on the map: mouse, wheel, fingers and keys, and what the page asks the server for then."""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

import pytest
from playwright.sync_api import Browser, CDPSession, Page, WebSocket, expect

from ground.core import CellState, MissionReason, MissionState
from ground.model import MapPiece, Point, Pose, Telemetry
from tests.ground.stations import packet_of
from tests.web.browsing import DESK, PHONE, browsing
from tests.web.threaded import Ground

Place = tuple[float, float]
Json: TypeAlias = Any  # whatever the page says
WAIT_MS = 20_000
FREE, WALL = bytes([CellState.FREE] * 64), bytes([CellState.OCCUPIED] * 64)


def hovering(x_m: float, y_m: float) -> Telemetry:
    pose = Pose(x_m, y_m, 0.4, 0.0)
    return Telemetry(1000, pose, Point(0.0, 0.0), MissionState.HOVER, MissionReason.OK, 100)


class Map:
    """The page's map, what the page has sent, and a drone in memory behind it."""

    def __init__(self, page: Page, ground: Ground) -> None:
        self.page, self.ground = page, ground
        self.sent: list[dict[str, Any]] = []
        page.on("websocket", self._listen)
        page.goto(ground.address)
        expect(page.locator("#state")).to_have_text("holding its place", timeout=WAIT_MS)
        self.rest()

    def _listen(self, socket: WebSocket) -> None:
        socket.on("framesent", lambda payload: self.sent.append(json.loads(payload)))

    def ask(self, expression: str) -> Json:
        return self.page.evaluate(f"() => {{ const map = wayflie.map; return {expression}; }}")

    def wait(self, condition: Callable[[], object]) -> None:
        for _ in range(WAIT_MS // 20):
            if condition():
                return
            self.page.wait_for_timeout(20)
        raise AssertionError("it did not happen")

    def rest(self) -> None:
        """Until nothing glides any more."""
        before = [-1]

        def still() -> bool:
            now = self.ask("[map.view.frames, map.due]")
            done, before[:] = now == before, now
            self.page.wait_for_timeout(100)
            return done

        self.wait(still)

    def at(self, x_m: float, y_m: float) -> Place:
        """On the page, in pixels; the map begins at its upper left corner."""
        found = self.ask(f"map.camera.toScreen({x_m}, {y_m})")
        return found[0], found[1]

    def wishes(self, what: str) -> list[dict[str, Any]]:
        return [wish for wish in self.sent if wish["do"] == what]

    def sent_goal(self) -> Place:
        """The first that it was sent to; waits for it."""
        self.wait(lambda: self.wishes("goto"))
        goal = self.wishes("goto")[0]
        return goal["x"], goal["y"]

    def drag(self, start: Place, end: Place) -> None:
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        mouse.move(*end, steps=5)
        mouse.up()


@pytest.fixture
def ground() -> Iterator[Ground]:
    ground = Ground()
    with ground.running():
        ground.call(lambda: ground.link.say(hovering(0.5, -0.25)))
        yield ground


@pytest.fixture
def desk(browser: Browser, ground: Ground) -> Iterator[Map]:
    with browsing(browser, DESK) as context:
        context.on("weberror", lambda error: pytest.fail(str(error.error)))
        yield Map(context.new_page(), ground)


@pytest.fixture
def phone(browser: Browser, ground: Ground) -> Iterator[Map]:
    with browsing(browser, PHONE) as context:
        yield Map(context.new_page(), ground)


class Fingers:
    """Two hands' worth of touches, moved in small steps."""

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


def a_wall_ahead(ground: Ground) -> None:
    """Free around the drone; from x = 1.2 on there is a wall."""
    tiles = [(row, column) for row in range(4, 12) for column in range(4, 12)]
    pieces = [MapPiece(16 * r + c, 0, WALL if c == 11 else FREE, ()) for r, c in tiles]
    ground.call(lambda: ground.link.say(*map(packet_of, pieces)))


# --- looking -------------------------------------------------------------------------------------


def test_the_wheel_zooms_about_the_pointer_and_the_scale_bar_follows(desk: Map) -> None:
    place = desk.at(1.0, 0.5)
    desk.page.mouse.move(*place)
    for turn in (-400, -200, 900):
        desk.page.mouse.wheel(0, turn)
        desk.rest()
        assert desk.at(1.0, 0.5) == pytest.approx(place, abs=0.5)
        (x0, _), (x1, _) = desk.at(0.0, 0.0), desk.at(1.0, 0.0)
        words = desk.page.locator("#scale-text").inner_text()
        bar = desk.page.locator("#scale-bar").bounding_box()
        assert bar is not None
        assert bar["width"] == pytest.approx(float(words.removesuffix(" m")) * (x1 - x0), abs=1)


def test_keys_and_buttons_zoom(desk: Map) -> None:
    scale = desk.ask("map.camera.scale")
    desk.page.keyboard.press("+")
    assert desk.ask("map.camera.scale") > 1.1 * scale
    desk.page.keyboard.press("-")
    assert desk.ask("map.camera.scale") == pytest.approx(scale)
    desk.page.get_by_role("button", name="Zoom in").click()
    assert desk.ask("map.camera.scale") > 1.1 * scale
    desk.page.get_by_role("button", name="Show the whole map").click()
    desk.rest()
    assert desk.ask("map.camera.scale") == pytest.approx(scale, rel=0.01)


def test_a_turned_map_leads_to_the_right_place(desk: Map) -> None:
    compass = desk.page.get_by_role("button", name="Turn the map back")
    expect(compass).to_be_hidden()
    for _ in range(3):
        desk.page.get_by_role("button", name="Turn the map left").click()
    (x0, y0), (x1, y1) = desk.at(0.0, 0.0), desk.at(1.0, 0.0)
    assert math.atan2(y0 - y1, x1 - x0) == pytest.approx(math.pi / 4), "forward is up and right"
    desk.rest()
    desk.page.mouse.click(*desk.at(1.0, 0.5))
    assert desk.sent_goal() == pytest.approx((1.0, 0.5), abs=0.01)
    compass.click()
    expect(compass).to_be_hidden()
    assert desk.ask("map.camera.angle") == 0


def test_dragging_pans_and_sends_nobody(desk: Map) -> None:
    (x, y) = desk.at(0.0, 0.0)
    desk.drag((300, 300), (360, 260))
    assert desk.at(0.0, 0.0) == pytest.approx((x + 60, y - 40), abs=1)
    assert desk.wishes("goto") == []


def test_following_keeps_the_drone_in_the_middle(desk: Map) -> None:
    desk.page.get_by_role("button", name="Follow the drone").click()
    for place in ((0.5, -0.25), (1.5, 1.0)):
        desk.ground.call(lambda place=place: desk.ground.link.say(hovering(*place)))
        desk.wait(lambda place=place: desk.ask("map.state.drone.pose")[:2] == list(place))
        desk.rest()
        assert desk.ask("map.camera.centre") == pytest.approx(place, abs=0.02)


def test_nothing_is_drawn_while_nothing_changes(desk: Map) -> None:
    frames = desk.ask("map.view.frames")
    states = "map.state"
    desk.page.evaluate("() => { wayflie.map.state.mark = 1; }")
    desk.wait(lambda: not desk.ask(f"{states}.mark"))
    assert desk.ask("map.view.frames") == frames


def test_two_fingers_zoom_and_turn(phone: Map) -> None:
    fingers = Fingers(phone.page)
    scale = phone.ask("map.camera.scale")
    middle, left, right = (170, 170), (120, 170), (220, 170)
    world = phone.ask("map.camera.toWorld(170, 170)")
    fingers.put(left, right)
    fingers.move((left, (70, 170)), (right, (270, 170)))
    fingers.lift()
    assert phone.ask("map.camera.scale") == pytest.approx(2 * scale, rel=0.05)
    assert phone.ask("map.camera.angle") == 0
    assert phone.at(*world) == pytest.approx(middle, abs=4)
    fingers.put(left, right)
    fingers.move((left, (135, 205)), (right, (205, 135)))
    fingers.lift()
    assert phone.ask("map.camera.angle") == pytest.approx(math.pi / 4, abs=0.15)
    expect(phone.page.get_by_role("button", name="Turn the map back")).to_be_visible()
    assert phone.wishes("goto") == []


# --- going ---------------------------------------------------------------------------------------


def test_hovering_shows_the_way_or_the_reason(desk: Map) -> None:
    a_wall_ahead(desk.ground)
    desk.wait(lambda: desk.ask("map.view.cells.knownBox"))
    desk.rest()
    bubble = desk.page.locator("#preview")
    for goal, words in (((-0.5, 0.5), "1.3 m to fly"), ((1.3, 0.0), "too near to an obstacle")):
        desk.page.mouse.move(*desk.at(*goal))
        expect(bubble).to_contain_text(words, timeout=WAIT_MS)
    desk.page.mouse.move(*desk.at(-0.5, 0.5))
    expect(bubble).to_have_attribute("data-ok", "true", timeout=WAIT_MS)
    path = desk.ask("map.preview.answer.path")
    assert path[0] == pytest.approx([0.5, -0.25], abs=0.02)
    assert path[-1] == pytest.approx([-0.5, 0.5], abs=0.02)
    desk.page.mouse.move(1100, 400)
    expect(bubble).to_be_hidden()
    assert desk.wishes("goto") == []


def test_a_long_press_shows_and_a_tap_goes(phone: Map) -> None:
    fingers = Fingers(phone.page)
    place = phone.at(1.0, 1.0)
    fingers.put(place)
    expect(phone.page.locator("#preview")).to_contain_text("to fly", timeout=WAIT_MS)
    fingers.lift()
    assert phone.wishes("goto") == []
    phone.page.touchscreen.tap(*phone.at(-0.5, 0.5))
    assert phone.sent_goal() == pytest.approx((-0.5, 0.5), abs=0.02)
    expect(phone.page.locator("#preview")).to_be_hidden()


def test_the_keyboard_alone_goes(desk: Map) -> None:
    keyboard = desk.page.keyboard
    desk.page.locator("#map").focus()
    keyboard.press("ArrowRight")
    assert desk.ask("map.keys.cross") is None, "plain arrows fly by hand"
    keyboard.press("Enter")
    for key, times in (("Shift+ArrowRight", 3), ("Shift+ArrowUp", 2)):
        for _ in range(times):
            keyboard.press(key)
    x, y = desk.ask("map.keys.cross")
    cx, cy = desk.ask("map.camera.centre")
    assert (x, y) == pytest.approx((cx + 0.3, cy + 0.2), abs=0.06)
    expect(desk.page.locator("#preview")).to_contain_text("to fly", timeout=WAIT_MS)
    assert desk.wishes("goto") == []
    keyboard.press("Enter")
    assert desk.sent_goal() == pytest.approx((x, y))


# --- drawing -------------------------------------------------------------------------------------


def test_way_points_are_drawn_mended_and_flown(desk: Map) -> None:
    page = desk.page
    page.get_by_role("button", name="Way points").click()
    places = [(1.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
    for place in places:
        page.mouse.click(*desk.at(*place))
    words = page.locator("#draft-text")
    expect(words).to_have_text("4 way points")
    page.keyboard.press("Backspace")
    expect(words).to_have_text("3 way points")
    desk.drag(desk.at(1.0, 1.0), desk.at(0.5, 0.8))
    expect(words).to_have_text("3 way points")
    page.keyboard.press("Enter")
    desk.wait(lambda: desk.wishes("fly"))
    points = desk.wishes("fly")[0]["points"]
    assert points == [
        pytest.approx(place, abs=0.02) for place in ((1.0, 0.0), (0.5, 0.8), (-1.0, 1.0))
    ]
    assert desk.wishes("goto") == []


def test_way_points_are_left_without_a_trace(desk: Map) -> None:
    page = desk.page
    page.get_by_role("button", name="Way points").click()
    page.mouse.click(*desk.at(1.0, 0.0))
    page.keyboard.press("Escape")
    expect(page.locator("#draft")).to_be_hidden()
    page.get_by_role("button", name="Way points").click()
    page.mouse.click(*desk.at(-1.0, 0.5))
    page.get_by_role("button", name="Patrol").click()
    desk.wait(lambda: desk.wishes("patrol"))
    assert desk.wishes("patrol")[0]["points"] == [pytest.approx((-1.0, 0.5), abs=0.02)]


@pytest.mark.parametrize("turned", [False, True])
def test_an_area_is_drawn_and_sent(desk: Map, turned: bool) -> None:
    page = desk.page
    if turned:
        page.get_by_role("button", name="Turn the map left").click()
        desk.rest()
    page.get_by_role("button", name="Area").click()
    use = page.get_by_role("button", name="Use")
    expect(use).to_be_disabled()
    desk.drag(desk.at(1.5, -1.0), desk.at(-1.0, 1.2))
    expect(page.locator("#draft-text")).to_have_text("2.5 \u00d7 2.2 m")
    use.click()
    desk.wait(lambda: desk.wishes("area"))
    area = desk.wishes("area")[0]
    drawn = [area[name] for name in ("x0", "y0", "x1", "y1")]
    assert drawn == pytest.approx([-1.0, -1.0, 1.5, 1.2], abs=0.03)
    assert desk.wishes("goto") == []


def test_the_keyboard_alone_draws(desk: Map) -> None:
    keyboard = desk.page.keyboard
    desk.page.get_by_role("button", name="Area").focus()
    keyboard.press("Enter")
    keyboard.press("p")
    for key, times in (("Shift+ArrowRight", 10), ("Shift+ArrowUp", 8)):
        for _ in range(times):
            keyboard.press(key)
    expect(desk.page.locator("#draft-text")).to_have_text("1.0 \u00d7 0.8 m")
    keyboard.press("Enter")
    desk.wait(lambda: desk.wishes("area"))


# --- layers --------------------------------------------------------------------------------------


def test_layers_are_chosen_by_keyboard_and_remembered(desk: Map) -> None:
    page = desk.page
    first = ["people"]
    desk.wait(lambda: [wish["want"] for wish in desk.wishes("layers")] == [first])
    page.get_by_role("button", name="Layers").focus()
    page.keyboard.press("Enter")
    frontiers = page.get_by_label("Frontiers")
    while not frontiers.evaluate("box => box === document.activeElement"):
        page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(frontiers).to_be_checked()
    page.keyboard.press("Escape")
    expect(frontiers).to_be_hidden()
    expect(page.get_by_role("button", name="Layers")).to_be_focused()
    desk.wait(lambda: desk.wishes("layers")[-1]["want"] == ["people", "frontiers"])
    desk.sent.clear()
    page.reload()
    desk.wait(lambda: desk.wishes("layers"))
    assert desk.wishes("layers")[0]["want"] == ["people", "frontiers"]
