# SPDX-License-Identifier: GPL-3.0-or-later
"""The look of the map: distinguishable colours, reduced motion, odometry, people."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from ground.core import CellState, MissionReason, MissionState
from ground.model import MapPiece, Odometry, Point, Pose, Ranges, Telemetry
from tests.ground.stations import packet_of
from tests.web.browsing import DESK
from tests.web.colours import contrast
from tests.web.mapped import WAIT_MS, Map, hovering, map_of_a_hovering_drone

LINES = (
    "trail", "route", "goal", "drone", "beam", "ghost", "area", "tree", "frontier", "person",
    "preview", "refused", "point", "accent",
)  # fmt: skip
LEAST = 3.0  # WCAG 2.2, 1.4.11
LEAST_TEXT = 4.5  # and 1.4.3


@pytest.fixture
def desk(browser: Browser) -> Iterator[Map]:
    with map_of_a_hovering_drone(browser, DESK) as desk:
        yield desk


def test_what_is_drawn_is_told_from_the_ground_in_light_and_in_dark(desk: Map) -> None:
    seen = []
    for scheme in ("light", "dark"):
        desk.page.emulate_media(color_scheme=scheme)
        desk.wait(lambda: desk.ask("map.view.colours.free") not in seen)
        colours = desk.ask("map.view.colours")
        seen.append(colours["free"])
        for line in LINES:
            for ground in ("free", "unknown"):
                found = contrast(colours[line], colours[ground])
                assert found >= LEAST, f"{line} on {ground}, {scheme}: {found:.1f}"
        for text, ground in (("ink", "panel"), ("accent-ink", "accent"), ("ink", "unknown")):
            assert contrast(colours[text], colours[ground]) >= LEAST_TEXT, (text, ground, scheme)


def test_who_wants_calm_sees_no_gliding(desk: Map) -> None:
    desk.page.emulate_media(reduced_motion="reduce")
    desk.page.get_by_role("button", name="Follow the drone").click()
    desk.rest()
    frames = desk.ask("map.view.frames")
    desk.ground.call(lambda: desk.ground.link.say(hovering(1.0, 0.0)))
    desk.wait(lambda: desk.ask("map.state.drone.pose")[0] == 1.0)
    desk.rest()
    assert desk.ask("map.view.shown")[:2] == [1.0, 0.0]
    assert desk.ask("map.camera.centre") == [1.0, 0.0]
    assert desk.ask("map.view.frames") - frames <= 3


def test_the_odometry_alone_is_shown_beside_the_pose(desk: Map) -> None:
    legend = desk.page.locator("#legend")
    expect(legend).to_be_hidden()
    for ms, x_m in enumerate((0.5, 0.7, 0.9), 1000):
        odometry = Odometry(ms, Pose(x_m, 0.05, 0.4, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0)
        desk.ground.call(lambda odometry=odometry: desk.ground.link.say(odometry))
        desk.wait(lambda x_m=x_m: (desk.ask("map.state.odometry") or [0])[0] == x_m)
    expect(legend).to_contain_text("odometry alone, 0.50 m off", timeout=WAIT_MS)
    assert desk.ask("map.ghostTrail") == [[0.5, 0.05], [0.7, 0.05], [0.9, 0.05]]
    desk.page.reload()
    desk.wait(lambda: desk.ask("map.ghostTrail") == [[0.5, 0.05], [0.7, 0.05], [0.9, 0.05]])
    desk.page.get_by_role("button", name="Layers").click()
    desk.page.get_by_label("Odometry alone").uncheck()
    expect(legend).to_be_hidden()


def test_somebody_is_shown_and_fades(desk: Map) -> None:
    link = desk.ground.link
    pieces = [
        packet_of(MapPiece(16 * row + column, 0, bytes([CellState.FREE] * 64), ()))
        for row in range(4, 12)
        for column in range(4, 12)
    ]
    pose = Pose(0.0, 0.0, 0.4, 0.0)
    here = Telemetry(1000, pose, Point(0.0, 0.0), MissionState.HOVER, MissionReason.OK, 100)
    desk.ground.call(lambda: link.say(*pieces, here))
    desk.wait(lambda: desk.ask("map.state.drone.pose")[0] == 0.0)
    desk.ground.call(lambda: link.say(Ranges(2000, 0.6, None, None, None, None)))
    desk.wait(lambda: desk.ask("map.people.length"))
    assert desk.ask("map.people[0].place") == pytest.approx([0.6, 0.0], abs=0.05)
    desk.rest()
    age_ms = desk.ask("performance.now() - map.people[0].at")
    assert age_ms >= 2000, "it fades for two seconds, then nothing moves any more"
