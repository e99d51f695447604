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

ARGUMENTS = ("--world", "empty", "--endurance", "100000", "--profile", "perfect")
"""Without drift, which is a matter of its own: a drone flown by hand is held by its flow alone."""
BRAKES_WITHIN_S = 0.5
WATCHED_S = 1.0
STANDS_M = 0.05
MOVED_M = 0.3


@pytest.fixture(scope="module")
def ground() -> Iterator[GroundProcess]:
    with (
        SimulatorProcess(*ARGUMENTS) as simulator,
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
        tab.until(lambda state: state["mission"]["state"] == "HOVER")
        yield tab


@pytest.fixture
def hand(tab: Tab) -> Tab:
    """The page of the user who flies."""
    hand = Tab(tab.page.context, tab.address).open()
    hand.page.locator("#hand").click()
    return hand


def moves(tab: Tab, hand: Tab) -> str:
    """Hold a key until the drone has moved this far, back over its start. @return the key"""
    x_m, y_m, _, yaw_rad = tab.state["drone"]["pose"]
    begin, ahead_m = (x_m, y_m), x_m * math.cos(yaw_rad) + y_m * math.sin(yaw_rad)
    key = "ArrowUp" if ahead_m < MOVED_M / 2 else "ArrowDown"
    hand.page.bring_to_front()
    hand.page.keyboard.down(key)
    tab.until(lambda state: math.dist(state["drone"]["pose"][:2], begin) > MOVED_M)
    return key


def stands(tab: Tab) -> None:
    """Check that it is let go, and stands soon after by the drone's own time."""

    def from_s() -> float:
        held = [state["mission"]["by_hand"] for state in tab.states]
        let_go = tab.states[len(held) - held[::-1].index(True) :]
        return BRAKES_WITHIN_S + (let_go[0]["drone"]["time_s"] if let_go else math.inf)

    tab.wait(lambda: tab.state["drone"]["time_s"] > from_s() + WATCHED_S)
    since_s = from_s()
    after = [s["drone"]["pose"] for s in tab.states if s["drone"]["time_s"] >= since_s]
    assert max(math.dist(pose[:2], after[0][:2]) for pose in after) < STANDS_M
    assert tab.state["mission"]["state"] == "HOVER"


def test_it_moves_while_a_key_is_held_and_stands_when_it_is_let_go(tab: Tab, hand: Tab) -> None:
    expect(hand.page.locator("#hand-hint")).to_contain_text("let go and it stands")
    key = moves(tab, hand)
    hand.shot("by-hand")
    hand.page.keyboard.up(key)
    stands(tab)


def test_it_climbs_while_its_key_is_held(tab: Tab, hand: Tab) -> None:
    hand.page.bring_to_front()
    hand.page.keyboard.down("KeyW")
    tab.until(lambda state: state["drone"]["pose"][2] > 0.6)
    hand.page.keyboard.up("KeyW")
    stands(tab)


def test_it_stands_when_the_page_is_closed(tab: Tab, hand: Tab) -> None:
    moves(tab, hand)
    hand.page.close()
    stands(tab)


def test_it_stands_when_the_page_hangs(tab: Tab, hand: Tab) -> None:
    key = moves(tab, hand)
    debugger = hand.page.context.new_cdp_session(hand.page)
    debugger.send("Debugger.enable")
    debugger.send("Debugger.pause")
    stands(tab)
    debugger.send("Debugger.resume")
    hand.page.keyboard.up(key)


def test_it_stands_when_another_tab_is_looked_at(tab: Tab, hand: Tab) -> None:
    key = moves(tab, hand)
    hand.page.evaluate(
        """() => {
          Object.defineProperty(document, "hidden", { value: true });
          document.dispatchEvent(new Event("visibilitychange"));
        }"""
    )
    stands(tab)
    hand.page.keyboard.up(key)
