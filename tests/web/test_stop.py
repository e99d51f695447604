# SPDX-License-Identifier: GPL-3.0-or-later
"""STOP in the browser where it is needed most: without an answer, and whatever has the focus."""

from playwright.sync_api import Browser, expect

from tests.web.browsing import tab_at
from tests.web.grounds import GroundProcess

NOBODY = "udp://127.0.0.1:9"


def test_a_stop_pressed_without_a_ground_station_goes_out_when_it_is_back(
    browser: Browser,
) -> None:
    with GroundProcess(NOBODY) as ground, tab_at(browser, ground.address) as tab:
        page = tab.page
        page.goto(ground.address)
        tab.until(lambda state: not state["stop"]["latched"])
        expect(page.locator("#unreachable")).to_be_hidden()
        ground.kill()
        expect(page.locator("#unreachable")).to_be_visible()
        expect(page.locator("#unreachable")).to_contain_text("cannot reach the ground station")
        page.keyboard.press("Space")
        told = page.locator("#latched-text")
        expect(told).to_contain_text("STOP has NOT gone out")
        ground.start()
        tab.until(lambda state: state["stop"]["latched"])
        expect(told).to_contain_text("STOP is being sent")
        page.get_by_role("button", name="Release").click()
        tab.until(lambda state: not state["stop"]["latched"])
        expect(page.locator("#stop")).to_be_visible()
        tab.problems.clear()  # that nobody answered was complained of


def test_space_stops_whatever_has_the_focus_but_a_text_field(browser: Browser) -> None:
    with GroundProcess(NOBODY) as ground, tab_at(browser, ground.address) as tab:
        page = tab.page
        page.goto(ground.address)
        tab.until(lambda state: not state["stop"]["latched"])
        page.evaluate("document.body.append(document.createElement('textarea'))")
        page.locator("textarea").press("Space")
        assert page.locator("textarea").input_value() == " "
        expect(page.locator("#stop")).to_be_visible()
        for what in ("#map", "summary >> nth=0", "#events"):
            page.locator(what).evaluate(
                "e => { e.closest('[hidden]')?.removeAttribute('hidden'); e.focus(); }"
            )
            page.keyboard.press("Space")
            tab.until(lambda state: state["stop"]["latched"])
            page.get_by_role("button", name="Release").click()
            tab.until(lambda state: not state["stop"]["latched"])
