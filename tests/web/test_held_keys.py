# SPDX-License-Identifier: GPL-3.0-or-later
"""Flying by hand from the page: the drone moves while a key is held, and stops when input stops.

In real time, because the server's patience is; when it lets go is tested in test_hand.py.
"""

import math
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from ground.sim.process import SimulatorProcess
from tests.web.browsing import Tab, tab_at
from tests.web.grounds import GroundProcess

BRAKES_WITHIN_S = 0.5
WATCHED_S = 1.0
STANDS_M = 0.05
MOVED_M = 0.3


@pytest.fixture(scope="module")
def ground() -> Iterator[GroundProcess]:
    with (
        SimulatorProcess("--world", "empty") as simulator,
        GroundProcess(simulator.uri) as ground,
    ):
        yield ground
        assert simulator.stop()["collisions"] == 0


@pytest.fixture
def tab(browser: Browser, ground: GroundProcess) -> Iterator[Tab]:
    """The page of an observer of a hovering drone."""
    with tab_at(browser, ground.address) as tab:
        tab.open()
        if tab.state["can"]["take_off"]:
            tab.press("Take off")
        tab.until(lambda state: state["can"]["manual"])
        yield tab


@pytest.fixture
def hand(tab: Tab) -> Tab:
    """The page of the user who flies."""
    hand = Tab(tab.page.context, tab.address).open()
    hand.page.locator("#hand").click()
    return hand


def moves(tab: Tab, hand: Tab, key: str) -> None:
    """Hold the key until the drone has moved this far."""
    begin = tab.state["drone"]["pose"][:2]
    hand.page.bring_to_front()
    hand.page.keyboard.down(key)
    tab.until(lambda state: math.dist(state["drone"]["pose"][:2], begin) > MOVED_M)


def stands(tab: Tab) -> None:
    """Check that it is let go, and stands soon after by the drone's own time."""
    tab.until(lambda state: not state["mission"]["by_hand"])
    let_go_s = max(s["drone"]["time_s"] for s in tab.states if s["mission"]["by_hand"])
    from_s = let_go_s + BRAKES_WITHIN_S
    tab.until(lambda state: state["drone"]["time_s"] > from_s + WATCHED_S)
    after = [s["drone"]["pose"] for s in tab.states if s["drone"]["time_s"] >= from_s]
    assert max(math.dist(pose[:2], after[0][:2]) for pose in after) < STANDS_M
    assert tab.state["mission"]["state"] == "HOVER"


def test_it_moves_while_a_key_is_held_and_stands_when_it_is_let_go(tab: Tab, hand: Tab) -> None:
    expect(hand.page.locator("#hand-hint")).to_contain_text("let go and it stands")
    moves(tab, hand, "ArrowUp")
    hand.shot("by-hand")
    hand.page.keyboard.up("ArrowUp")
    stands(tab)


def test_it_climbs_while_its_key_is_held(tab: Tab, hand: Tab) -> None:
    hand.page.bring_to_front()
    hand.page.keyboard.down("KeyW")
    tab.until(lambda state: state["drone"]["pose"][2] > 0.6)
    hand.page.keyboard.up("KeyW")
    stands(tab)


def test_it_stands_when_the_page_is_closed(tab: Tab, hand: Tab) -> None:
    moves(tab, hand, "ArrowDown")
    hand.page.close()
    stands(tab)


def test_it_stands_when_the_page_hangs(tab: Tab, hand: Tab) -> None:
    moves(tab, hand, "ArrowUp")
    debugger = hand.page.context.new_cdp_session(hand.page)
    debugger.send("Debugger.enable")
    debugger.send("Debugger.pause")
    stands(tab)
    debugger.send("Debugger.resume")
    hand.page.keyboard.up("ArrowUp")


def test_it_stands_when_another_tab_is_looked_at(tab: Tab, hand: Tab) -> None:
    moves(tab, hand, "ArrowDown")
    hand.page.evaluate(
        """() => {
          Object.defineProperty(document, "hidden", { value: true });
          document.dispatchEvent(new Event("visibilitychange"));
        }"""
    )
    stands(tab)
    hand.page.keyboard.up("ArrowDown")
