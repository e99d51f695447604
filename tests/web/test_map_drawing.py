# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawing on the map: waypoints, an area; and choosing what it shows."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from tests.web.browsing import DESK
from tests.web.mapped import Map, map_of_a_hovering_drone


@pytest.fixture
def desk(browser: Browser) -> Iterator[Map]:
    with map_of_a_hovering_drone(browser, DESK) as desk:
        yield desk


# --- drawing -------------------------------------------------------------------------------------


def test_way_points_are_drawn_mended_and_flown(desk: Map) -> None:
    page = desk.page
    page.get_by_role("button", name="Waypoints").click()
    places = [(1.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
    for place in places:
        page.mouse.click(*desk.at(*place))
    words = page.locator("#draft-text")
    expect(words).to_have_text("4 points")
    page.keyboard.press("Backspace")
    expect(words).to_have_text("3 points")
    desk.drag(desk.at(1.0, 1.0), desk.at(0.5, 0.8))
    expect(words).to_have_text("3 points")
    page.keyboard.press("Enter")
    desk.wait(lambda: desk.wishes("fly"))
    points = desk.wishes("fly")[0]["points"]
    assert points == [
        pytest.approx(place, abs=0.02) for place in ((1.0, 0.0), (0.5, 0.8), (-1.0, 1.0))
    ]
    assert desk.wishes("goto") == []


def test_way_points_are_left_without_a_trace(desk: Map) -> None:
    page = desk.page
    page.get_by_role("button", name="Waypoints").click()
    page.mouse.click(*desk.at(1.0, 0.0))
    page.keyboard.press("Escape")
    expect(page.locator("#draft")).to_be_hidden()
    page.get_by_role("button", name="Waypoints").click()
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
