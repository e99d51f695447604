# SPDX-License-Identifier: GPL-3.0-or-later
"""The page in a real browser: a click becomes a goal, Space stops, the map is drawn."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from ground.core import CellState, MissionCmd, MissionReason, MissionState, SelfTest
from ground.model import Health, MapPiece, Point, Pose, Ranges, Telemetry
from ground.requests import EmergencyStop, SetParameter
from ground.web.fleet import COLOURS, Member, Place
from ground.words import SELF_TEST_WORDS
from tests.ground.stations import packet_of
from tests.web.browsing import Tab, tab_at
from tests.web.threaded import Ground

WAIT_MS = 20_000


def hovering(goal: Point) -> Telemetry:
    pose = Pose(0.5, -0.25, 0.4, 0.0)
    return Telemetry(1000, pose, goal, MissionState.HOVER, MissionReason.OK, 100)


@pytest.fixture
def ground() -> Iterator[Ground]:
    ground = Ground()
    with ground.running():
        ground.call(lambda: ground.link.say(hovering(Point(0.0, 0.0))))
        yield ground


@pytest.fixture
def tab(browser: Browser, ground: Ground) -> Iterator[Tab]:
    """The page on a desktop, in light mode; only this machine may be asked for anything."""
    with tab_at(browser, ground.address) as tab:
        tab.page.goto(ground.address)
        expect(tab.page.locator("#state")).to_have_text("holding its place", timeout=WAIT_MS)
        yield tab.rest()


@pytest.fixture
def page(tab: Tab) -> Page:
    return tab.page


def on_the_ground(self_test: SelfTest) -> tuple[Telemetry, Health]:
    pose = Pose(0.0, 0.0, 0.0, 0.0)
    telemetry = Telemetry(1000, pose, Point(0.0, 0.0), MissionState.IDLE, MissionReason.OK, 100)
    return telemetry, Health(1000, 4.0, 0.0, 0, 0, 0, 0, 0, supervisor=0, self_test=self_test)


def test_a_click_becomes_a_goal_and_space_stops(ground: Ground, tab: Tab) -> None:
    link, page = ground.link, tab.page
    box = page.locator("#map").bounding_box()
    assert box is not None
    middle_x, middle_y = box["width"] / 2, box["height"] / 2
    page.locator("#map").click(position={"x": middle_x + 100, "y": middle_y - 50})
    tab.wait(lambda: link.acts)
    assert link.acts[0].cmd is MissionCmd.GOTO
    goal = link.acts[0].goal
    assert goal.x_m > 0.3
    assert goal.y_m > 0.15
    assert goal.x_m == pytest.approx(2 * goal.y_m, rel=0.05), "100 pixels right, 50 up"

    page.get_by_role("button", name="Explore").click()
    tab.wait(lambda: len(link.acts) == 2)
    assert link.acts[1].cmd is MissionCmd.EXPLORE

    page.keyboard.press("Space")
    tab.wait(lambda: link.count(EmergencyStop) > 0)
    expect(page.locator("#state")).to_have_text("stopped", timeout=WAIT_MS)
    expect(page.locator("#latched")).to_contain_text("motors are cut", timeout=WAIT_MS)
    for name in ("Take off", "Explore", "Home", "Hold", "Scan", "Land"):
        expect(page.get_by_role("button", name=name, exact=True)).to_be_disabled()
    page.locator("#map").click(position={"x": middle_x, "y": middle_y})
    page.get_by_role("button", name="Release").click()
    expect(page.get_by_role("button", name="Land")).to_be_enabled(timeout=WAIT_MS)
    assert len(link.acts) == 2, "nothing but the two commands before the stop"


def test_a_refusal_is_shown_in_words(page: Page, ground: Ground) -> None:
    ground.link._reason = MissionReason.BATTERY_LOW
    page.get_by_role("button", name="Explore").click()
    toast = page.get_by_role("status")
    words = "Explore refused: the battery is low. Next: charge it; way.lowBat is the limit."
    expect(toast).to_have_text(words, timeout=WAIT_MS)


def test_the_map_is_drawn_where_it_lies(tab: Tab, ground: Ground) -> None:
    states = bytearray([CellState.FREE] * 64)
    states[0:8] = [CellState.OCCUPIED] * 8
    ranges = Ranges(1000, 1.0, 2.0, None, 0.5, None)
    pieces = [packet_of(MapPiece(tile, 0, bytes(states), ())) for tile in range(256)]
    ground.call(lambda: ground.link.say(ranges, *pieces))
    expect(tab.page.locator("#map-complete")).to_have_text("100 %", timeout=WAIT_MS)
    tab.wait(lambda: tab.page.evaluate("wayflie.map.view.cells.knownBox"))
    colours = tab.rest().page.evaluate(
        """() => {
          const canvas = document.getElementById("map");
          const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
          const seen = {};
          for (let i = 0; i < data.length; i += 4) {
            const key = `${data[i]},${data[i + 1]},${data[i + 2]}`;
            seen[key] = (seen[key] ?? 0) + 1;
          }
          return seen;
        }"""
    )
    free, occupied = colours["255,255,255"], colours["139,152,147"]
    assert occupied / (free + occupied) == pytest.approx(1 / 8, abs=0.03)


@pytest.mark.parametrize("result", [SelfTest.AGREES, SelfTest.DIFFERS])
def test_the_self_test_can_be_run_and_tells_its_result(
    ground: Ground, tab: Tab, result: SelfTest
) -> None:
    page = tab.page
    page.get_by_text("Link, computing, self-test").click()
    shown, run = page.locator("#self-test"), page.get_by_role("button", name="Run the self-test")
    expect(run).to_be_hidden()
    ground.call(lambda: ground.link.say(*on_the_ground(SelfTest.NOT_RUN)))
    expect(shown).to_have_text("not run", timeout=WAIT_MS)
    run.click()
    asked = SetParameter("way.selftest", 1)
    tab.wait(lambda: asked in ground.link.sent)
    for state in (SelfTest.RUNNING, result):
        ground.call(lambda state=state: ground.link.say(*on_the_ground(state)))
        expect(shown).to_have_text(SELF_TEST_WORDS[state], timeout=WAIT_MS)
        expect(run).to_be_visible(visible=state is result)
    expect(shown).to_have_attribute("data-state", result.name)


def test_a_lost_drone_is_told_and_cannot_be_commanded(page: Page, ground: Ground) -> None:
    ground.call(lambda: ground.link.lose())
    expect(page.locator("#link")).to_have_text("link lost", timeout=WAIT_MS)
    expect(page.locator("#state")).to_have_text("last heard: holding its place")
    expect(page.locator("#detail")).not_to_be_empty()
    expect(page.get_by_role("button", name="Land")).to_be_disabled(timeout=WAIT_MS)


def colour_at(page: Page, x_m: float, y_m: float) -> tuple[int, int, int]:
    """The colour drawn there, once the view rests; it shows two metres to all sides."""
    found = page.evaluate(
        """([x, y]) => {
          const canvas = document.getElementById("map");
          const scale = Math.min(canvas.clientWidth, canvas.clientHeight) / 5.2;
          const at = [canvas.width / 2 + x * scale, canvas.height / 2 - y * scale];
          return [...canvas.getContext("2d").getImageData(...at, 1, 1).data].slice(0, 3);
        }""",
        [x_m, y_m],
    )
    return found[0], found[1], found[2]


def test_two_drones_are_shown_and_the_chosen_one_is_commanded(ground: Ground, tab: Tab) -> None:
    page = tab.page
    second = Member(ground.other, "udp://two", Place(1.0, 1.0, 0.0))
    ground.call(lambda: ground.fleet.members.append(second))
    ground.call(lambda: ground.other_link.say(hovering(Point(0.0, 0.0))))
    buttons = page.locator("#fleet button")
    expect(buttons).to_have_count(2, timeout=WAIT_MS)
    expect(buttons.nth(1)).to_contain_text("holding its place", timeout=WAIT_MS)
    colours = [tuple(bytes.fromhex(colour[1:])) for colour in COLOURS[:2]]
    tab.wait(lambda: [colour_at(page, 0.5, -0.25), colour_at(page, 1.5, 0.75)] == colours)
    page.get_by_role("button", name="Hold", exact=True).click()
    tab.wait(lambda: ground.link.acts)
    buttons.nth(1).click()
    expect(buttons.nth(1)).to_have_attribute("aria-pressed", "true", timeout=WAIT_MS)
    tab.wait(lambda: [colour_at(page, -0.5, -1.25), colour_at(page, 0.5, -0.25)] == colours)
    page.get_by_role("button", name="Land").click()
    tab.wait(lambda: ground.other_link.acts)
    assert [act.cmd for act in ground.link.acts] == [MissionCmd.HOLD]
    assert [act.cmd for act in ground.other_link.acts] == [MissionCmd.LAND]
    page.keyboard.press("Space")
    for link in (ground.link, ground.other_link):
        tab.wait(lambda link=link: link.count(EmergencyStop) > 0)


class Line:
    """A recording of a minute."""

    def __init__(self) -> None:
        self.position_s, self.duration_s, self.playing = 10.0, 60.0, True

    def play(self) -> None:
        self.playing = True

    def pause(self) -> None:
        self.playing = False

    def seek(self, time_s: float) -> None:
        self.position_s = time_s


def test_a_recording_has_a_time_line_and_nothing_to_command(tab: Tab, ground: Ground) -> None:
    page = tab.page
    assert not page.locator("#timeline").is_visible()
    ground.cockpit.timeline = line = Line()
    text, play = page.locator("#time-text"), page.locator("#play")
    expect(text).to_have_text("0:10 / 1:00", timeout=WAIT_MS)
    play.click()
    expect(play).to_have_attribute("aria-label", "Play", timeout=WAIT_MS)
    assert not line.playing
    page.locator("#time").focus()
    page.keyboard.press("End")
    expect(text).to_have_text("1:00 / 1:00", timeout=WAIT_MS)
    tab.wait(lambda: line.position_s == 60.0)
    tab.states.clear()
    tab.wait(lambda: tab.states)
    expect(text).to_have_text("1:00 / 1:00", timeout=WAIT_MS)
    for name in ("#stop", ".commands"):
        assert not page.locator(name).is_visible()
    page.keyboard.press("Space")
    page.locator("#map").click(position={"x": 100, "y": 100})
    assert ground.link.acts == []
    assert ground.link.count(EmergencyStop) == 0
