# SPDX-License-Identifier: GPL-3.0-or-later
"""Gestures on the map: mouse, wheel, fingers and keys move the view and send the drone."""

import math
from collections.abc import Iterator
from dataclasses import replace

import pytest
from playwright.sync_api import Browser, expect

from ground.core import CellState, MissionState
from ground.model import MapPiece, Point
from tests.ground.stations import packet_of
from tests.web.browsing import DESK, PHONE
from tests.web.mapped import WAIT_MS, Fingers, Map, hovering, map_of_a_hovering_drone
from tests.web.threaded import Ground

FREE, WALL = bytes([CellState.FREE] * 64), bytes([CellState.OCCUPIED] * 64)


@pytest.fixture
def desk(browser: Browser) -> Iterator[Map]:
    with map_of_a_hovering_drone(browser, DESK) as desk:
        yield desk


@pytest.fixture
def phone(browser: Browser) -> Iterator[Map]:
    with map_of_a_hovering_drone(browser, PHONE) as phone:
        yield phone


def a_wall_ahead(ground: Ground) -> None:
    """A map that is free around the drone, with a wall from x = 1.2 on."""
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


def test_the_map_is_not_fitted_anew_under_a_pressed_pointer(desk: Map) -> None:
    place = desk.at(1.0, 0.5)
    desk.page.mouse.move(*place)
    desk.page.mouse.down()
    known, frames = desk.ask("map.view.cells.knownBox"), desk.ask("map.view.frames")
    a_wall_ahead(desk.ground)
    desk.wait(lambda: desk.ask("map.view.cells.knownBox") != known)
    desk.wait(lambda: desk.ask("map.view.frames") > frames + 10)
    assert desk.at(1.0, 0.5) == pytest.approx(place, abs=0.1)
    desk.page.mouse.up()
    assert desk.sent_goal() == pytest.approx((1.0, 0.5), abs=0.01)
    desk.rest()
    assert desk.at(1.0, 0.5) != pytest.approx(place, abs=10), "all of the map is shown now"


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


def test_a_goal_beyond_all_that_is_known_is_seen(desk: Map) -> None:
    a_wall_ahead(desk.ground)
    goal = Point(4.0, 3.0)
    away = replace(hovering(0.5, -0.25), state=MissionState.FOLLOW, goal=goal)
    desk.ground.call(lambda: desk.ground.link.say(away))
    desk.wait(lambda: desk.ask("map.view.cells.knownBox && map.state.drone.goal"))
    desk.rest()
    x_px, y_px = desk.at(goal.x_m, goal.y_m)
    tools = desk.page.locator(".map-view").bounding_box()
    assert tools is not None
    assert 0 < x_px < tools["x"]
    assert 0 < y_px < DESK[1]


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
    desk.page.mouse.move(200, 300)
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
    desk.ground.call(lambda: desk.ground.link.say(hovering(0.8, -0.25)))
    desk.wait(lambda: desk.ask("map.state.drone.pose")[0] == 0.8)
    desk.rest()
    assert desk.ask("map.keys.cross") == [x, y], "a mouse that rests on the map moves nothing"
    assert desk.wishes("goto") == []
    keyboard.press("Enter")
    assert desk.sent_goal() == pytest.approx((x, y))
