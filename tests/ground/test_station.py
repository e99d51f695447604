# SPDX-License-Identifier: GPL-3.0-or-later
"""The station on a drone in memory: commands arrive, the picture is right, silence is reported."""

import asyncio
import itertools
from dataclasses import replace

import pytest

from ground.core import MissionCmd, MissionReason, MissionState, WireType
from ground.errors import CommandRefused, LinkLost, NoAnswer, ProtocolMismatch
from ground.model import Beat, ParameterValue, Point, RoutePiece
from ground.requests import (
    Ask,
    Command,
    EmergencyStop,
    Heartbeat,
    HelloRequest,
    Outgoing,
    SetParameter,
)
from ground.station import station
from ground.station.station import Station
from tests.ground.fakelink import HELLO, FakeLink
from tests.ground.stations import GOAL, heard, telemetry, with_station


def test_command_is_acknowledged_and_acts_once() -> None:
    link = FakeLink()
    with_station(link, lambda station: station.command(MissionCmd.GOTO, GOAL))
    assert [(act.cmd, act.goal) for act in link.acts] == [(MissionCmd.GOTO, GOAL)]
    assert link.closed


def test_command_is_repeated_with_the_same_sequence_until_heard() -> None:
    countdown = itertools.count()

    def hears(message: Outgoing) -> bool:
        return not isinstance(message, Command) or next(countdown) >= 3

    link = FakeLink(hears)
    with_station(link, lambda station: station.command(MissionCmd.LAND))
    commands = [message for message in link.sent if isinstance(message, Command)]
    assert len(commands) == 4
    assert len(set(commands)) == 1
    assert len(link.acts) == 1


def test_each_command_has_a_sequence_of_its_own() -> None:
    link = FakeLink()

    async def work(station: Station) -> None:
        for _ in range(5):
            await station.command(MissionCmd.HOLD)

    with_station(link, work)
    assert len({act.sequence for act in link.acts}) == 5


def test_refusal_carries_the_reason_in_words() -> None:
    link = FakeLink(reason=MissionReason.BATTERY_LOW)
    with pytest.raises(CommandRefused, match="battery is low") as refused:
        with_station(link, lambda station: station.command(MissionCmd.TAKE_OFF))
    assert refused.value.reason is MissionReason.BATTERY_LOW


def test_a_deaf_drone_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ground.station.station.REPEAT_S", 0.001)
    link = FakeLink(lambda message: not isinstance(message, Command))
    with pytest.raises(NoAnswer, match="land"):
        with_station(link, lambda station: station.command(MissionCmd.LAND))


def test_waiting_ends_when_the_link_is_lost() -> None:
    link = FakeLink(lambda message: not isinstance(message, Command))

    async def work(station: Station) -> None:
        asyncio.get_running_loop().call_soon(link.lose)
        await station.command(MissionCmd.LAND)

    with pytest.raises(LinkLost):
        with_station(link, work)


def test_another_grid_is_refused() -> None:
    with pytest.raises(ProtocolMismatch, match="64 cells"):
        with_station(FakeLink(hello=replace(HELLO, side_cells=64)), heard_nothing)


async def heard_nothing(station: Station) -> None:
    raise AssertionError("the station must not start")


def test_heartbeats_follow_the_clock_of_the_drone() -> None:
    link = FakeLink()

    async def work(station: Station) -> None:
        before = link.count(Heartbeat)
        for drone_ms in range(0, 20_001, 50):
            link.say(telemetry(drone_ms, MissionState.IDLE))
        while station.picture.drone_ms < 20_000:
            await asyncio.sleep(0)
        assert 39 <= link.count(Heartbeat) - before <= 42

    with_station(link, work)


def test_heartbeats_go_on_when_nothing_is_heard(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ground.station.station.BEAT_WALL_S", 0.01)
    link = FakeLink()

    async def work(station: Station) -> None:
        while link.count(Heartbeat) < 3:
            await asyncio.sleep(0.005)

    with_station(link, work)
    beats = [message.sequence for message in link.sent if isinstance(message, Heartbeat)]
    assert len(beats) >= 3
    assert beats == list(range(beats[0], beats[0] + len(beats)))


@pytest.mark.parametrize("kind", [HelloRequest, Heartbeat])
def test_a_restarted_drone_is_greeted_and_hears_a_heartbeat_at_once(
    kind: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(station, "BEAT_WALL_S", 1e6)
    link = FakeLink()

    async def work(station: Station) -> None:
        link.say(telemetry(50_000, MissionState.HOVER))
        await heard(link)
        before = link.count(kind)
        link.say(telemetry(100, MissionState.IDLE))
        await heard(link)
        assert link.count(kind) == before + 1

    with_station(link, work)


def test_emergency_stop_is_repeated_until_locked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ground.station.station.REPEAT_S", 0.001)
    countdown = itertools.count()
    link = FakeLink(lambda m: not isinstance(m, EmergencyStop) or next(countdown) >= 3)
    with_station(link, lambda station: station.emergency_stop())
    assert link.count(EmergencyStop) >= 4


def test_parameter_returns_what_the_drone_made_of_it() -> None:
    link = FakeLink()

    def hears(message: Outgoing) -> bool:
        if isinstance(message, SetParameter):
            link.say(ParameterValue("way.height", 0.4))
        return not isinstance(message, SetParameter)

    link._hears = hears

    async def work(station: Station) -> None:
        assert await station.set_parameter("way.height", 99.0) == 0.4
        assert station.picture.parameters == {"way.height": 0.4}

    with_station(link, work)


def test_route_is_shown_when_all_pieces_have_come() -> None:
    link = FakeLink()
    points = [Point(float(i), 0.0) for i in range(8)]

    async def work(station: Station) -> None:
        link.say(RoutePiece(1, 6, 8, tuple(points[6:])))
        await heard(link)
        assert station.picture.route == ()
        link.say(RoutePiece(1, 0, 8, tuple(points[:6])))
        await heard(link)
        assert station.picture.route == tuple(points)
        link.say(RoutePiece(2, 0, 0, ()))
        await heard(link)
        assert station.picture.route == ()

    with_station(link, work)


def test_a_lost_piece_of_the_route_is_asked_for_again() -> None:
    link, lost = FakeLink(), Ask(WireType.PATH)

    async def work(station: Station) -> None:
        link.say(Beat(0, 50, MissionState.FOLLOW, path_revision=1, path_total=8))
        link.say(RoutePiece(1, 0, 8, (GOAL,) * 6))
        for drone_ms in range(50, 301, 50):
            link.say(telemetry(drone_ms, MissionState.FOLLOW))
        await heard(link)
        assert link.sent.count(lost) == 1
        for drone_ms in range(350, 601, 50):
            link.say(telemetry(drone_ms, MissionState.FOLLOW))
        await heard(link)
        assert link.sent.count(lost) == 2
        link.say(RoutePiece(1, 6, 8, (GOAL,) * 2))
        for drone_ms in range(650, 5001, 50):
            link.say(telemetry(drone_ms, MissionState.FOLLOW))
        await heard(link)
        assert link.sent.count(lost) == 2
        assert station.picture.route == (GOAL,) * 8

    with_station(link, work)
