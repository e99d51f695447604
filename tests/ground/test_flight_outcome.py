# SPDX-License-Identifier: GPL-3.0-or-later
"""How the ground learns that a flight has ended, and with which outcome."""

import asyncio

import pytest
from rich.console import Console

from ground.cli.session import landing_on_interrupt
from ground.core import EventCode, MissionCmd, MissionReason, MissionState, SelfTest
from ground.errors import LinkLost
from ground.model import Event, Health, LinkChange, LinkState, Telemetry
from ground.requests import Command
from ground.station import flight, settling
from ground.station.flight import fly
from ground.station.settling import fly_when_settled
from ground.station.station import Station
from tests.ground.fakelink import FakeLink
from tests.ground.stations import GOAL, event, heard, telemetry, with_station

FLIGHTS = [
    (MissionCmd.GOTO, [event(EventCode.ARRIVED)], True, MissionReason.OK),
    (MissionCmd.GOTO, [event(EventCode.FAULT, MissionReason.TUMBLED)], False, "TUMBLED"),
    (MissionCmd.GOTO, [event(EventCode.REFUSED, MissionReason.STUCK)], False, "STUCK"),
    (MissionCmd.TAKE_OFF, [event(EventCode.STATE, MissionState.HOVER)], True, "OK"),
    (MissionCmd.LAND, [event(EventCode.STATE, MissionState.IDLE)], True, "OK"),
    (
        MissionCmd.LAND,
        [
            event(EventCode.FAULT, MissionReason.BATTERY_LOW),
            event(EventCode.STATE, MissionState.IDLE),
        ],
        True,
        "OK",
    ),
    (
        MissionCmd.EXPLORE,
        [event(EventCode.EXPLORED), event(EventCode.STATE, MissionState.IDLE)],
        True,
        "OK",
    ),
    (MissionCmd.HOME, [event(EventCode.STATE, MissionState.FAULT)], False, "OK"),
]


@pytest.mark.parametrize(("cmd", "events", "reached", "reason"), FLIGHTS)
def test_events_decide_how_a_flight_ended(
    cmd: MissionCmd, events: list[Event], reached: bool, reason: str | MissionReason
) -> None:
    link = FakeLink()
    link.on_command = lambda command: link.say(*events)

    async def work(station: Station) -> None:
        outcome = await fly(station, cmd, GOAL)
        assert outcome.reached is reached
        assert reason in (outcome.reason, outcome.reason.name)

    with_station(link, work)


def test_what_was_heard_while_the_acknowledgement_was_lost_does_not_count() -> None:
    link = FakeLink()
    waiting = [telemetry(t, MissionState.IDLE) for t in range(0, 9000, 50)]
    there = [telemetry(t, MissionState.HOVER, 1.0, 2.0) for t in range(9000, 15000, 50)]

    link.on_command = lambda command: link.say(*waiting)
    link.after = [*there]

    async def work(station: Station) -> None:
        assert (await fly(station, MissionCmd.GOTO, GOAL)).reached

    with_station(link, work)


@pytest.mark.parametrize(
    ("argument", "words"),
    [
        (0, "done"),
        (1, "explored, except for places that could not be observed"),
        (None, "it landed before everything was explored"),
    ],
)
def test_how_far_it_is_explored_may_be_heard_after_the_landing(
    argument: int | None, words: str
) -> None:
    link = FakeLink()
    begun = event(EventCode.STATE, MissionState.FOLLOW)
    end = event(EventCode.STATE, MissionState.IDLE)
    late = [] if argument is None else [event(EventCode.EXPLORED, argument)]
    landed = [telemetry(t, MissionState.IDLE) for t in range(1000, 7000, 50)]
    link.after = [begun, end, *late, *landed]

    async def work(station: Station) -> None:
        outcome = await fly(station, MissionCmd.EXPLORE)
        assert (outcome.reached, outcome.sentence) == (words == "done", words)

    with_station(link, work)


@pytest.mark.parametrize("found", [True, False])
def test_who_is_lost_on_the_way_may_find_its_place_and_go_on(found: bool) -> None:
    link = FakeLink()

    def flown() -> list[Event | Telemetry]:
        lost = event(EventCode.FAULT, MissionReason.LOST)
        looks = event(EventCode.STATE, MissionState.RELOCALISE)
        if found:
            return [lost, looks, event(EventCode.FOUND), event(EventCode.ARRIVED)]
        down = [telemetry(t, MissionState.IDLE) for t in range(1000, 7000, 50)]
        return [lost, looks, event(EventCode.STATE, MissionState.LAND), *down]

    link.after = flown()

    async def work(station: Station) -> None:
        assert (await fly(station, MissionCmd.GOTO, GOAL)).reached is found

    with_station(link, work)


def test_telemetry_decides_where_the_event_was_lost() -> None:
    link = FakeLink()
    flown = [telemetry(t, MissionState.FOLLOW) for t in range(0, 1000, 50)]
    there = [telemetry(t, MissionState.HOVER, 1.05, 1.95) for t in range(1000, 7000, 50)]
    link.after = [*flown, *there]

    async def work(station: Station) -> None:
        assert (await fly(station, MissionCmd.GOTO, GOAL)).reached

    with_station(link, work)


def test_one_look_at_the_end_of_a_take_off_is_enough() -> None:
    link = FakeLink()
    rising = [telemetry(t, MissionState.TAKEOFF) for t in range(50, 1000, 50)]
    link.after = [*rising, telemetry(1000, MissionState.HOVER)]

    async def work(station: Station) -> None:
        assert (await fly(station, MissionCmd.TAKE_OFF)).reached

    with_station(link, work)


def test_a_rest_that_passes_is_no_arrival() -> None:
    link = FakeLink()
    there = [telemetry(t, MissionState.HOVER, 1.0, 2.0) for t in range(50, 4000, 50)]
    stuck = event(EventCode.FAULT, MissionReason.STUCK, drone_ms=4000)
    link.after = [*there, stuck]

    async def work(station: Station) -> None:
        assert (await fly(station, MissionCmd.GOTO, GOAL)).reason is MissionReason.STUCK

    with_station(link, work)


def test_a_drone_that_begins_anew_does_not_go_on_with_its_flight() -> None:
    link = FakeLink()
    anew = LinkChange(LinkState.RESTARTED, "the drone was restarted")
    link.after = [telemetry(50, MissionState.FOLLOW), anew]
    with pytest.raises(LinkLost, match="restarted"):
        with_station(link, lambda station: fly(station, MissionCmd.GOTO, GOAL))


def test_hovering_elsewhere_is_not_arriving() -> None:
    link = FakeLink()
    elsewhere = [telemetry(t, MissionState.HOVER, 0.0, 2.0) for t in range(0, 7000, 50)]
    link.after = [*elsewhere]

    async def work(station: Station) -> None:
        assert not (await fly(station, MissionCmd.GOTO, GOAL)).reached

    with_station(link, work)


def test_an_event_of_the_flight_before_does_not_count() -> None:
    link = FakeLink()

    def answer(command: Command) -> None:
        link.say(event(EventCode.ARRIVED, drone_ms=900))
        link.say(event(EventCode.REFUSED, MissionReason.GOAL_OCCUPIED, drone_ms=1100))

    link.on_command = answer

    async def work(station: Station) -> None:
        link.say(telemetry(1000, MissionState.HOVER))
        await heard(link)
        outcome = await fly(station, MissionCmd.GOTO, GOAL)
        assert outcome.reason is MissionReason.GOAL_OCCUPIED
        assert outcome.place == GOAL

    with_station(link, work)


@pytest.mark.parametrize(("locked", "tries"), [(None, 2), (False, 2), (True, 1)])
def test_a_supervisor_that_is_not_ready_again_is_waited_for(
    locked: bool | None, tries: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So is one of which nothing has been heard yet (None)."""
    monkeypatch.setattr(settling, "BEGINNING_S", 0.01)
    link = FakeLink()
    commands: list[Command] = []

    def answer(command: Command) -> None:
        commands.append(command)
        if len(commands) == 1:
            link.say(event(EventCode.REFUSED, MissionReason.CANNOT_FLY))
        else:
            link.say(event(EventCode.ARRIVED))

    link.on_command = answer

    async def work(station: Station) -> None:
        if locked is not None:
            link.say(Health(1, 4.0, 0.0, 0, 0, 0, 0, 0, 1 << 6 if locked else 0, SelfTest.NOT_RUN))
            await heard(link)
        outcome = await fly_when_settled(station, MissionCmd.GOTO, GOAL)
        assert outcome.reached == (not locked)

    with_station(link, work)
    assert len(commands) == tries


def test_the_end_does_not_wait_for_ever_for_a_landing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flight, "LANDING_S", 0.01)
    link = FakeLink()

    async def fly_until_ctrl_c(station: Station) -> None:
        async with landing_on_interrupt(station, Console(quiet=True)):
            await asyncio.Event().wait()

    async def work(station: Station) -> None:
        link.say(telemetry(1000, MissionState.HOVER))
        await heard(link)
        flying = asyncio.create_task(fly_until_ctrl_c(station))
        await asyncio.sleep(0)
        flying.cancel()
        with pytest.raises(asyncio.CancelledError):
            await flying

    with_station(link, work)
    assert [act.cmd for act in link.acts] == [MissionCmd.LAND]
