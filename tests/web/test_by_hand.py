# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole flight by hand: keys in the browser move a simulated drone, letting go lets it stand."""

import math

from playwright.sync_api import Browser, expect

from ground.sim.process import SimulatorProcess
from tests.web.browsing import Frame, Tab, tab_at
from tests.web.grounds import GroundProcess

STANDS_S = 0.5  # by the drone's clock
SWAY_M = 0.08  # of a drone that holds its place, and of SLAM that corrects where it is


def moved_m(frame: Frame, since: Frame) -> float:
    (x_m, y_m, *_), (x0_m, y0_m, *_) = frame["drone"]["pose"], since["drone"]["pose"]
    return math.hypot(x_m - x0_m, y_m - y0_m)


def fly_and_let_go(tab: Tab, key: str) -> None:
    """Hold a key for half a metre, let go: half a second later it stands where it will stay."""
    begun = tab.state
    tab.page.keyboard.down(key)
    tab.until(lambda state: moved_m(state, begun) > 0.4)
    tab.page.keyboard.up(key)
    let_go_s = tab.state["drone"]["time_s"]
    tab.until(lambda state: state["drone"]["time_s"] >= let_go_s + STANDS_S)
    standing = tab.state
    tab.until(lambda state: state["drone"]["time_s"] >= let_go_s + STANDS_S + 2.0)
    assert moved_m(tab.state, standing) < SWAY_M
    assert tab.state["mission"]["state"] == "HOVER"


def test_keys_move_it_and_letting_go_lets_it_stand(browser: Browser) -> None:
    with (
        SimulatorProcess("--world", "empty") as simulator,
        GroundProcess(simulator.uri) as ground,
        tab_at(browser, ground.address) as tab,
    ):
        tab.open()
        tab.press("Take off")
        tab.until(lambda s: s["mission"]["state"] == "HOVER" and s["drone"]["pose"][2] > 0.3)
        tab.press("By hand")
        expect(tab.page.locator("#hand-hint")).to_contain_text("let go and it stands")
        tab.shot("by-hand")
        fly_and_let_go(tab, "ArrowUp")
        fly_and_let_go(tab, "ArrowDown")
        tab.page.keyboard.down("KeyW")
        tab.until(lambda state: state["drone"]["pose"][2] > 0.6)
        tab.page.keyboard.up("KeyW")
        tab.press("Land")
        tab.until(lambda state: state["can"]["take_off"])
        assert simulator.stop()["collisions"] == 0
