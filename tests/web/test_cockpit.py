# SPDX-License-Identifier: GPL-3.0-or-later
"""What the server holds for its pages: the dead-man of who steered, and what may be pressed."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from dataclasses import replace
from pathlib import Path

import pytest

from ground.core import MissionCmd, MissionState, SelfTest
from ground.errors import GroundError
from ground.model import Health, LinkChange, LinkState
from ground.record.replay import ReplayLink
from ground.requests import Stick
from ground.station.station import Station, station_on
from ground.web.cockpit import Cockpit
from ground.web.frames import NOTHING, state_frame
from tests.ground.fakelink import LOCKED, FakeLink
from tests.ground.stations import GOAL, heard, telemetry

DEAD_MAN_S = 0.02
LATER_S = 0.1
WELL = replace(LOCKED, supervisor=1 << 3)


def acts_of(
    state: MissionState, work: Callable[[Cockpit], Awaitable[None]], link: FakeLink | None = None
) -> list[MissionCmd]:
    """What a drone in that state is told while a page does this and afterwards."""
    link = link or FakeLink()

    async def run() -> None:
        async with station_on(link) as station:
            link.say(telemetry(1000, state))
            await heard(link)
            cockpit = Cockpit(station, DEAD_MAN_S)
            cockpit.page_opened()
            await work(cockpit)
            await asyncio.sleep(LATER_S)
            await cockpit.close()

    asyncio.run(run())
    return [act.cmd for act in link.acts]


async def go_and_leave(cockpit: Cockpit) -> None:
    await cockpit.command("goto", GOAL)
    cockpit.page_closed()


def test_a_drone_in_the_air_holds_when_the_last_page_that_steered_is_gone() -> None:
    assert acts_of(MissionState.FOLLOW, go_and_leave) == [MissionCmd.GOTO, MissionCmd.HOLD]


def test_it_holds_when_the_page_that_flew_it_by_hand_is_gone() -> None:
    async def fly_and_leave(cockpit: Cockpit) -> None:
        cockpit.steer("page", Stick(ahead_mps=0.2))
        cockpit.page_closed()

    assert acts_of(MissionState.HOVER, fly_and_leave) == [MissionCmd.HOLD]


def test_one_that_stands_is_told_nothing() -> None:
    assert acts_of(MissionState.IDLE, go_and_leave) == [MissionCmd.GOTO]


def test_one_that_was_told_to_land_goes_on_landing() -> None:
    async def land_and_leave(cockpit: Cockpit) -> None:
        await cockpit.command("goto", GOAL)
        await cockpit.command("land")
        cockpit.page_closed()

    told = acts_of(MissionState.FOLLOW, land_and_leave)
    assert told == [MissionCmd.GOTO, MissionCmd.LAND]


def test_a_page_that_comes_back_in_time_keeps_its_flight() -> None:
    async def leave_and_come(cockpit: Cockpit) -> None:
        await go_and_leave(cockpit)
        cockpit.page_opened()

    assert acts_of(MissionState.FOLLOW, leave_and_come) == [MissionCmd.GOTO]


def test_a_page_that_stays_keeps_the_flight_of_the_other() -> None:
    async def one_of_two_leaves(cockpit: Cockpit) -> None:
        cockpit.page_opened()
        await go_and_leave(cockpit)

    assert acts_of(MissionState.FOLLOW, one_of_two_leaves) == [MissionCmd.GOTO]


def test_after_a_stop_nothing_else_is_sent() -> None:
    async def stop_and_leave(cockpit: Cockpit) -> None:
        await cockpit.command("goto", GOAL)
        cockpit.stop()
        cockpit.page_closed()

    assert acts_of(MissionState.FOLLOW, stop_and_leave) == [MissionCmd.GOTO]


def test_without_a_link_a_stop_does_not_keep_the_server_from_ending() -> None:
    async def run() -> None:
        cockpit = Cockpit()
        cockpit.stop()
        await cockpit.close()
        assert cockpit.stop_latched

    asyncio.run(run())


def test_a_recording_takes_no_parameter() -> None:
    cockpit = seen(MissionState.HOVER)
    cockpit.timeline = ReplayLink(Path("none.mcap"))
    with pytest.raises(GroundError, match="recording"):
        asyncio.run(cockpit.set_parameter("way.height", 0.5))


def permitted(cockpit: Cockpit) -> set[str]:
    can = json.loads(state_frame(cockpit, NOTHING)[0])["can"]
    return {name for name, may in can.items() if may}


def seen(state: MissionState, health: Health = WELL) -> Cockpit:
    """A cockpit of a drone that is connected and in that state."""
    station = Station(FakeLink())
    for message in (LinkChange(LinkState.CONNECTED, ""), telemetry(1000, state), health):
        station.picture.take(message, 0.0)
    return Cockpit(station)


def test_what_may_be_pressed_goes_by_whether_it_flies() -> None:
    always = {"goto", "explore", "spin", "fly", "patrol", "area", "set"}
    flying = {"home", "hold", "scan", "manual", "land"}
    assert permitted(seen(MissionState.IDLE)) == always | {"take_off", "self_test"}
    assert permitted(seen(MissionState.HOVER)) == always | flying


def test_after_a_stop_nothing_may_be_pressed() -> None:
    cockpit = seen(MissionState.HOVER)
    cockpit.stop_latched = True
    assert permitted(cockpit) == set()


def test_of_a_drone_that_is_not_heard_nothing_may_be_pressed() -> None:
    cockpit = seen(MissionState.HOVER)
    assert cockpit.station is not None
    cockpit.station.picture.take(LinkChange(LinkState.SILENT, ""), 0.0)
    assert permitted(cockpit) == set()


@pytest.mark.parametrize(
    ("state", "health"),
    [
        (MissionState.HOVER, WELL),
        (MissionState.IDLE, replace(WELL, known_cells=1)),
        (MissionState.IDLE, replace(WELL, self_test=SelfTest.RUNNING)),
    ],
    ids=["in the air", "with a map", "running"],
)
def test_the_self_test_is_for_the_ground_without_a_map(state: MissionState, health: Health) -> None:
    assert "self_test" not in permitted(seen(state, health))
