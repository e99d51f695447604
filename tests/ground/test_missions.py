# SPDX-License-Identifier: GPL-3.0-or-later
"""Missions through the real cflib: an interrupted patrol, a flight along points, a spin."""

import asyncio
import math
from collections.abc import Iterator

import pytest
from typer.testing import CliRunner

from ground.cli.app import app
from ground.core import WAYPOINTS_MAX, EventCode, MissionCmd, MissionReason
from ground.errors import BadWaypoints
from ground.link.radio import RadioLink
from ground.model import Event, Point
from ground.sim.process import SimulatorProcess
from ground.sim.world import load_world
from ground.station.flight import fly
from ground.station.station import station_on
from tests.ground.stations import take_off

SQUARE = (Point(1.0, 0.0), Point(1.0, 1.0), Point(0.0, 1.0))
PATIENCE_S = 60.0


@pytest.fixture
def simulator() -> Iterator[SimulatorProcess]:
    with SimulatorProcess("--world", "empty", "--speed", "max") as simulator:
        yield simulator


@pytest.mark.parametrize("interrupt", [MissionCmd.HOLD, MissionCmd.LAND])
def test_a_patrol_goes_round_until_it_is_interrupted(
    simulator: SimulatorProcess, interrupt: MissionCmd
) -> None:
    async def patrol() -> list[int]:
        passed: list[int] = []
        async with station_on(RadioLink(simulator.uri)) as station:
            await take_off(station)
            await station.give_waypoints(SQUARE)
            with station.listen() as listener:
                await station.command(MissionCmd.PATROL)
                async with asyncio.timeout(PATIENCE_S):
                    while len(passed) < 5:
                        match await listener.next():
                            case Event(code=EventCode.WAYPOINT) as event:
                                passed.append(event.argument)
            assert (await fly(station, interrupt)).reached
            if interrupt is MissionCmd.HOLD:
                assert (await fly(station, MissionCmd.LAND)).reached
        return passed

    assert asyncio.run(patrol()) == [0, 1, 2, 0, 1]


def test_points_are_flown_along_and_it_lands_at_the_last(simulator: SimulatorProcess) -> None:
    result = CliRunner().invoke(app, ["fly", "1,0", "0.5,-1", "--uri", simulator.uri])
    assert result.exit_code == 0, result.output
    assert "at waypoint 1" in result.output
    assert "at waypoint 2" in result.output
    assert "landing" in result.output


@pytest.mark.parametrize("turns", ["1", "-2"])
def test_a_spin_turns_and_lands(simulator: SimulatorProcess, turns: str) -> None:
    result = CliRunner().invoke(app, ["spin", "--turns", turns, "--uri", simulator.uri])
    assert result.exit_code == 0, result.output
    assert "turning in place" in result.output


@pytest.mark.parametrize("words", [["1"], ["1,2,3"], ["a,b"]])
def test_what_is_no_point_is_told(words: list[str]) -> None:
    result = CliRunner().invoke(app, ["patrol", *words])
    assert result.exit_code == 2
    assert "metres" in result.stderr


def test_a_list_that_cannot_be_held_is_refused_before_it_is_sent(
    simulator: SimulatorProcess,
) -> None:
    async def give() -> None:
        async with station_on(RadioLink(simulator.uri)) as station:
            for points in ([], [Point(0.0, 0.0)] * (WAYPOINTS_MAX + 1), [Point(31.0, 0.0)]):
                with pytest.raises(BadWaypoints):
                    await station.give_waypoints(points)
            assert (await fly(station, MissionCmd.PATROL)).reason in (
                MissionReason.NO_WAYPOINTS,
                MissionReason.ESTIMATOR,
            )

    asyncio.run(give())


def test_when_the_battery_is_low_on_the_way_to_a_goal_it_lands_at_home() -> None:
    arguments = ("--world", "empty", "--speed", "max", "--endurance", "40")
    with SimulatorProcess(*arguments) as simulator:

        async def raise_limit() -> None:
            async with station_on(RadioLink(simulator.uri)) as station:
                await station.set_parameter("way.lowBat", 3.7)

        asyncio.run(raise_limit())
        result = CliRunner().invoke(app, ["goto", "2.2", "2.2", "--uri", simulator.uri])
        x_m, y_m, *_ = simulator.stop()["true_pose"]
    assert result.exit_code == 1
    assert "flying home" in result.output
    assert math.dist((x_m, y_m), load_world("empty").spec.start_m) < 0.3
