# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys, gamepad and parameters in the browser, and what the drone is sent for them."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from ground.core import MissionReason, MissionState
from ground.model import ParameterValue, Point, Pose, Telemetry
from ground.requests import REST, SetParameter, Steer, Stick
from tests.web.browsing import Tab, tab_at
from tests.web.threaded import Ground

PAD = """() => {
  window.axes = [0, 0, 0, 0];
  navigator.getGamepads = () => [{ connected: true, axes: window.axes }];
}"""


@pytest.fixture
def ground() -> Iterator[Ground]:
    ground, pose = Ground(), Pose(0.0, 0.0, 0.4, 0.0)
    hovering = Telemetry(1000, pose, Point(0, 0), MissionState.HOVER, MissionReason.OK, 100)
    with ground.running():
        values = ParameterValue("way.height", 0.4), ParameterValue("way.planner", 0.0)
        ground.call(lambda: ground.link.say(hovering, *values))
        yield ground


@pytest.fixture
def tab(browser: Browser, ground: Ground) -> Iterator[Tab]:
    with tab_at(browser, ground.address) as tab:
        yield tab.open()


def sticks(ground: Ground) -> list[Stick]:
    return [message.stick for message in ground.link.sent if isinstance(message, Steer)]


def test_keys_are_a_stick_only_while_they_are_held_and_wanted(tab: Tab, ground: Ground) -> None:
    keyboard = tab.page.keyboard
    keyboard.press("ArrowUp")
    tab.press("By hand")
    keyboard.down("ArrowUp")
    keyboard.down("KeyD")
    tab.wait(lambda: sticks(ground)[-1:] == [Stick(0.3, 0.0, pytest.approx(-1.0472, abs=1e-3))])
    keyboard.up("KeyD")
    tab.wait(lambda: sticks(ground)[-1] == Stick(ahead_mps=0.3))
    tab.page.evaluate("dispatchEvent(new Event('blur'))")
    tab.wait(lambda: sticks(ground)[-1] == REST)
    keyboard.up("ArrowUp")
    expect(tab.page.locator("[data-key].held")).to_have_count(0)


def test_keys_on_the_screen_are_held_with_a_finger(tab: Tab, ground: Ground) -> None:
    tab.press("By hand")
    tab.page.locator("[data-key=KeyW]").hover()
    tab.page.mouse.down()
    tab.wait(lambda: sticks(ground)[-1:] == [Stick(climb_mps=0.25)])
    tab.page.mouse.up()
    tab.wait(lambda: sticks(ground)[-1] == REST)


def test_a_gamepad_flies_as_drones_are_flown(tab: Tab, ground: Ground) -> None:
    tab.page.evaluate(PAD)
    tab.press("By hand")
    expect(tab.page.locator("#hand-pad")).to_contain_text("Gamepad connected")
    tab.page.evaluate("window.axes = [0.1, -1, 0.5, 0]")
    wanted = Stick(0.0, pytest.approx(-0.15), 0.0, 0.25)
    tab.wait(lambda: sticks(ground)[-1:] == [wanted])
    tab.page.evaluate("window.axes = [0, 0, 0, 0]")
    tab.wait(lambda: sticks(ground)[-1] == REST)


def test_a_parameter_is_written_read_back_and_refused_with_its_range(
    tab: Tab, ground: Ground
) -> None:
    tab.page.get_by_text("Parameters", exact=True).click()
    height = tab.page.get_by_label("height", exact=True)
    expect(height).to_have_value("0.4")
    height.fill("0.75")
    height.press("Enter")
    tab.wait(lambda: SetParameter("way.height", 0.75) in ground.link.sent)
    row = tab.page.locator(".parameter", has=height)
    expect(row.locator("output")).to_have_text("set")
    height.fill("7")
    height.press("Enter")
    expect(row.locator("output")).to_have_text("way.height: 0.2 to 2 m")
    expect(height).to_have_value("0.75")
    tab.page.get_by_label("planner", exact=True).select_option("search on the grid")
    tab.wait(lambda: SetParameter("way.planner", 1.0) in ground.link.sent)
    row.get_by_role("button").click()
    tab.wait(lambda: SetParameter("way.height", 0.4) in ground.link.sent)
