# SPDX-License-Identifier: GPL-3.0-or-later
"""By keyboard alone: every control is reachable, focus is visible, a flight is flown."""

from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from ground.sim.process import SimulatorProcess
from tests.web.browsing import DESK, PHONE, away_m, tab_at
from tests.web.grounds import GroundProcess
from tests.web.mapped import hovering
from tests.web.threaded import Ground

RING_PX = 2
THERE_M = 0.3
TABS_MAX = 200

WITHOUT_FOCUS_YET = """() => {
  const wanted = "a[href], button, input, select, textarea, summary, [tabindex]";
  const there = (e) => e.checkVisibility() && !e.disabled && e.tabIndex >= 0;
  return [...document.querySelectorAll(wanted)]
    .filter((e) => there(e) && !e.dataset.reached)
    .map((e) => e.ariaLabel || e.textContent.trim() || e.id);
}"""
FOCUSED = """() => {
  const e = document.activeElement;
  const again = Boolean(e.dataset.reached);
  e.dataset.reached = "yes";
  const { outlineStyle, outlineWidth } = getComputedStyle(e);
  const { top, bottom } = e.getBoundingClientRect();
  return {
    name: e.ariaLabel || e.textContent.trim() || e.id,
    body: e === document.body,
    again,
    ring_px: outlineStyle === "none" ? 0 : parseFloat(outlineWidth),
    on_screen: bottom > 0 && top < innerHeight,
  };
}"""


def tab_through(page: Page) -> list[dict[str, Any]]:
    """The elements that get the focus in turn, until the page is left."""
    seen: list[dict[str, Any]] = []
    for _ in range(TABS_MAX):
        page.keyboard.press("Tab")
        focused = page.evaluate(FOCUSED)
        if focused["body"] or focused["again"]:
            return seen
        seen.append(focused)
    raise AssertionError("Tab never leaves the page")


def tab_to(page: Page, name: str) -> None:
    """Press Tab until an element has the focus."""
    for _ in range(TABS_MAX):
        page.keyboard.press("Tab")
        if page.evaluate(FOCUSED)["name"].startswith(name):
            return
    raise AssertionError(f"Tab does not reach {name}")


SIZES = pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])


@SIZES
def test_all_is_reached_and_seen(browser: Browser, size: tuple[int, int]) -> None:
    ground = Ground()
    with ground.running(), tab_at(browser, ground.address, size) as tab:
        ground.call(lambda: ground.link.say(hovering(0.5, -0.25)))
        page = tab.open().page
        seen = tab_through(page)
        assert len(seen) > 5
        assert [one["name"] for one in seen if one["ring_px"] < RING_PX] == []
        assert [one["name"] for one in seen if not one["on_screen"]] == []
        assert page.evaluate(WITHOUT_FOCUS_YET) == []


@SIZES
def test_a_goal_is_chosen_and_flown_to(browser: Browser, size: tuple[int, int]) -> None:
    with (
        SimulatorProcess("--world", "empty", "--speed", "4") as simulator,
        GroundProcess(simulator.uri) as ground,
        tab_at(browser, ground.address, size) as tab,
    ):
        page, keyboard = tab.open().page, tab.page.keyboard
        tab_to(page, "Take off")
        tab.shot(f"focus-{size[0]}")
        keyboard.press("Enter")
        tab.until(lambda state: state["mission"]["state"] == "HOVER")
        tab_to(page, "Map")
        keyboard.press("Shift+ArrowRight")
        begin = page.evaluate("wayflie.map.keys.cross")
        for _ in range(4):
            keyboard.press("Shift+ArrowRight")
        cross = page.evaluate("wayflie.map.keys.cross")
        assert cross == pytest.approx([begin[0] + 0.4, begin[1]], abs=0.01)
        keyboard.press("Enter")
        tab.until(lambda s: s["mission"]["state"] == "HOVER" and away_m(s, cross) < THERE_M)
        tab_to(page, "Land")
        keyboard.press("Enter")
        tab.until(lambda state: state["can"]["take_off"])
