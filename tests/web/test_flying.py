# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of a simulated drone, with real cflib and UDP between them, as a user sees it."""

import math
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from ground.sim.process import SimulatorProcess
from tests.web.browsing import Frame, Tab, away_m, browsing, tab_at
from tests.web.grounds import GroundProcess

HOME = (0.0, 0.0)
BEDROOM = (2.0, 1.0)
ROUND = [[0.6, 0.0], [0.0, 0.0]]
THERE_M = 0.35
HEADER_BYTES = 20
TIRELESS = ("--endurance", "100000")


@pytest.fixture(scope="module")
def simulator() -> Iterator[SimulatorProcess]:
    with SimulatorProcess("--world", "flat", "--speed", "2", *TIRELESS) as simulator:
        yield simulator


@pytest.fixture(scope="module")
def ground(simulator: SimulatorProcess) -> Iterator[GroundProcess]:
    with GroundProcess(simulator.uri) as ground:
        yield ground


@pytest.fixture
def tab(browser: Browser, ground: GroundProcess) -> Iterator[Tab]:
    with tab_at(browser, ground.address) as tab:
        yield tab.open()


def at_rest(tab: Tab) -> Tab:
    """End what an earlier test has left."""
    if tab.state["mission"]["state"] not in ("IDLE", "HOVER"):
        tab.press("Hold")
    return tab.until(lambda state: state["mission"]["state"] in ("IDLE", "HOVER"))


def on_its_way(tab: Tab) -> tuple[float, float]:
    """Send it somewhere else by a click; wait until it has a route and has left. @return where"""
    begin = at_rest(tab).state["drone"]["pose"][:2]
    place = BEDROOM if away_m(tab.state, HOME) < 1.0 else HOME
    tab.click(*place)
    tab.until(lambda s: is_goal(s, place) and s["route"] and away_m(s, begin) > 0.3)
    return place


def is_goal(state: Frame, place: tuple[float, float]) -> bool:
    return bool(state["drone"]["goal"] == pytest.approx(place, abs=0.05))


def arrived(tab: Tab, place: tuple[float, float]) -> None:
    tab.until(lambda s: s["mission"]["state"] == "HOVER" and away_m(s, place) < THERE_M)


def known(map_frame: bytes) -> int:
    """Number of known cells."""
    return sum(map(bool, map_frame[HEADER_BYTES:]))


def test_a_click_into_another_room_is_flown_to(tab: Tab) -> None:
    place = on_its_way(tab)
    tab.shot("flying")
    arrived(tab, place)
    expect(tab.page.locator("#state")).to_have_text("holding its place")
    tab.shot("arrived")


def test_a_reload_on_the_way_loses_nothing(tab: Tab) -> None:
    other = Tab(tab.page.context, tab.address).open()  # while one is open, the drone flies on
    at_rest(tab).page.evaluate("points => wayflie.map.wish({ do: 'patrol', points })", ROUND)
    tab.until(lambda state: state["mission"]["state"] == "FOLLOW" and len(tab.trail) > 10)
    map_before, trail_before = tab.map, len(tab.trail)
    tab.reload()
    tab.until(lambda state: state["mission"]["state"] == "FOLLOW")
    tab.wait(lambda: (tab.trail, tab.events) == (other.trail, other.events))
    assert len(tab.trail) >= trail_before
    tab.wait(lambda: known(tab.map) > 0.9 * known(map_before))
    at_rest(tab)


def test_a_second_tab_sees_the_same(tab: Tab) -> None:
    place = on_its_way(tab)
    second = Tab(tab.page.context, tab.address).open()
    arrived(tab, place)
    second.wait(lambda: (second.map, second.trail) == (tab.map, tab.trail))
    second.wait(lambda: second.events == tab.events)
    second.press("Land")
    tab.until(lambda state: state["can"]["take_off"])
    assert second.problems == []


def test_a_server_that_was_killed_is_found_again(tab: Tab, ground: GroundProcess) -> None:
    tab.wait(lambda: tab.map)
    map_before = tab.map
    ground.kill()
    expect(tab.page.locator("#link")).to_have_text("the ground station has gone")
    tab.shot("no-server")
    tab.forget()
    ground.start()
    tab.until(lambda state: state["can"]["goto"] and state["map"]["complete"] == 1.0)
    tab.wait(lambda: known(tab.map) > 0.9 * known(map_before))
    expect(tab.page.locator("#link")).to_have_text("connected")


def test_a_page_of_another_origin_is_refused(
    browser: Browser, ground: GroundProcess, foreign: str
) -> None:
    """Its server is on this machine too: only the ground station can refuse it."""
    with browsing(browser) as context:
        page, said = context.new_page(), list[str]()
        page.on("console", lambda line: said.append(line.text))
        page.goto(foreign)
        opened = page.evaluate(
            """address => new Promise((done) => {
              const socket = new WebSocket(address);
              socket.onopen = () => done(true);
              socket.onclose = () => done(false);
            })""",
            ground.address.replace("http", "ws") + "socket",
        )
        assert not opened
        assert any("403" in line for line in said)
        with pytest.raises(Exception, match="Failed to fetch"):
            page.evaluate("address => fetch(address)", ground.address)


def test_an_area_that_is_drawn_is_explored_and_not_left(browser: Browser) -> None:
    with (
        SimulatorProcess("--world", "flat", "--speed", "6", *TIRELESS) as simulator,
        GroundProcess(simulator.uri) as ground,
        tab_at(browser, ground.address) as tab,
    ):
        mouse = tab.open().page.mouse
        tab.press("Area")
        tab.point_at(-0.5, -1.0)
        mouse.down()
        mouse.move(*tab.place(1.2, 0.6), steps=4)
        tab.shot("area")
        mouse.up()
        tab.press("Use")
        tab.until(lambda s: s["area"] == pytest.approx([-0.5, -1.0, 1.2, 0.6], abs=0.03))
        tab.states.clear()
        explored(tab)
        tab.shot("explored")
        poses = [state["drone"]["pose"] for state in tab.states]
        assert all(-0.7 < x_m < 1.4 and -1.2 < y_m < 0.8 for x_m, y_m, *_ in poses)
        assert max(math.dist(pose[:2], HOME) for pose in poses) > 0.5, "it has moved about"
        tab.wait(lambda: any("explored" in event["words"] for event in tab.events))


def explored(tab: Tab) -> None:
    """Press Explore, and wait until the drone is on the ground again."""
    tab.press("Explore")
    tab.until(lambda state: state["can"]["land"])
    tab.until(lambda state: state["can"]["take_off"])


def test_stop_cuts_the_motors_of_a_drone_in_the_air_and_latches(browser: Browser) -> None:
    with (
        SimulatorProcess("--world", "empty", "--speed", "4") as simulator,
        GroundProcess(simulator.uri) as ground,
        tab_at(browser, ground.address) as tab,
    ):
        other = Tab(tab.open().page.context, ground.address).open()
        tab.press("Take off")
        tab.until(lambda s: s["mission"]["state"] == "HOVER" and s["drone"]["pose"][2] > 0.2)
        tab.page.keyboard.press("Space")
        for seen in (tab, other):
            seen.until(lambda state: state["stop"] == {"latched": True, "confirmed": True})
            expect(seen.page.get_by_role("button", name="Take off")).to_be_disabled()
        tab.shot("stopped")
        other.press("Release")
        tab.until(lambda state: not state["stop"]["latched"])
        expect(tab.page.locator("#latched")).to_contain_text("stays locked until it is restarted")
        assert simulator.stop()["true_pose"][2] < 0.1, "it fell"
