# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole flights: the real cflib against the simulated Crazyflie that runs the app's own code."""

import asyncio
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from ground.cli.app import app
from ground.core import MissionCmd, MissionReason, MissionState
from ground.link.radio import RadioLink
from ground.model import LinkState, Point, Telemetry
from ground.nextsteps import after
from ground.record.reader import read_recording
from ground.sim.process import SimulatorProcess
from ground.station.flight import fly
from ground.station.station import Station, station_on
from tests.ground.stations import take_off


@pytest.fixture
def simulator(request: pytest.FixtureRequest) -> Iterator[SimulatorProcess]:
    """A fast simulator of the empty world, unless the test says otherwise."""
    arguments: list[str] = getattr(request, "param", [])
    with SimulatorProcess("--world", "empty", "--speed", "max", *arguments) as simulator:
        yield simulator


def run(*arguments: str) -> tuple[int, str]:
    """Run a command of `wayflie`; exit code and standard error."""
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, result.stderr


def test_demo_reaches_its_goal(tmp_path: Path) -> None:
    report = tmp_path / "out.json"
    result = CliRunner().invoke(app, ["demo", "--headless", "--json", str(report)])
    figures: dict[str, Any] = json.loads(report.read_text())
    failed = [c for c in figures["checks"] if not c["ok"] and c["name"] != "realtime_factor"]
    assert failed == [], result.output
    assert figures["reached"] is True
    assert figures["landed"] is True
    assert figures["collisions"] == 0
    assert figures["path_m"] > 4
    assert figures["known_cells"] > 3000
    assert figures["map_error_m"] <= 0.25
    assert figures["log_packets"] > 1000


def test_goto_flies_and_reports(simulator: SimulatorProcess, tmp_path: Path) -> None:
    report = tmp_path / "goto.json"
    files = ["--json", str(report), "--record", str(tmp_path / "goto.mcap")]
    code, errors = run("goto", "1.0", "0.5", "--uri", simulator.uri, *files)
    assert (code, errors) == (0, "")
    assert json.loads(report.read_text())["reached"] is True
    heard = [message for _, message in read_recording(tmp_path / "goto.mcap")]
    assert [m.state for m in heard if isinstance(m, Telemetry)][-1] is MissionState.IDLE
    truth = simulator.stop()
    assert truth["collisions"] == 0
    assert truth["path_m"] > 1.0
    assert truth["true_pose"][2] < 0.05, "landed"


def test_a_goal_outside_is_refused_in_words(simulator: SimulatorProcess) -> None:
    code, errors = run("goto", "25", "-25", "--uri", simulator.uri)
    assert code == 1
    sentence, step = errors.splitlines()
    assert sentence == "wayflie: could not go to a point: the goal is outside the map's grid"
    assert step == f"  next: {after(MissionReason.OUTSIDE_GRID)}"
    code, errors = run("land", "--uri", simulator.uri)
    assert (code, errors) == (1, "wayflie: could not land: it is not flying\n")
    assert simulator.stop()["path_m"] < 0.1, "it never took off"


def test_emergency_stop_locks(simulator: SimulatorProcess) -> None:
    code, errors = run("stop", "--uri", simulator.uri)
    assert (code, errors) == (0, "")
    code, errors = run("goto", "1", "0", "--uri", simulator.uri)
    assert code == 1
    assert "supervisor" in errors


def test_saved_map_is_the_flown_one(simulator: SimulatorProcess, tmp_path: Path) -> None:
    assert run("goto", "0.5", "0", "--uri", simulator.uri)[0] == 0
    code, errors = run("map", "save", str(tmp_path / "map.png"), "--uri", simulator.uri)
    assert (code, errors) == (0, "")
    assert (tmp_path / "map.png").stat().st_size > 200


@pytest.mark.parametrize("simulator", [["--loss", "0.1", "--seed", "3"]], indirect=True)
def test_a_tenth_of_all_packets_lost_is_survived(simulator: SimulatorProcess) -> None:
    async def work() -> None:
        async with station_on(RadioLink(simulator.uri)) as station:
            await take_off(station)
            outcome = await fly(station, MissionCmd.GOTO, Point(1.0, 0.5))
            assert outcome.reached, outcome
            assert (await fly(station, MissionCmd.LAND)).reached
            while station.picture.map.completeness < 1:
                await asyncio.sleep(0.05)
            stats = station.stats
            assert 0.05 < stats.lost_packets / (stats.lost_packets + stats.log_packets) < 0.15

    asyncio.run(work())
    status = simulator.stop()
    assert status["collisions"] == 0
    assert status["datagrams_lost_down"] > 100


@pytest.mark.parametrize("simulator", [["--loss", "0.3"]], indirect=True)
def test_parameters_get_through_where_answers_are_lost(simulator: SimulatorProcess) -> None:
    wanted = {"height": 0.35, "speed": 0.25, "goalX": 0.5, "goalY": 1.5, "lostTime": 7.0}

    async def work() -> list[float]:
        async with station_on(RadioLink(simulator.uri)) as station:
            return [await station.set_parameter(f"way.{n}", value) for n, value in wanted.items()]

    assert asyncio.run(work()) == pytest.approx(list(wanted.values()))
    assert simulator.stop()["datagrams_lost_down"] > 0


@pytest.mark.parametrize("simulator", [["--speed", "5"]], indirect=True)
def test_silence_is_told_and_its_end(simulator: SimulatorProcess) -> None:
    process = simulator._process
    assert process is not None

    async def until(station: Station, state: LinkState) -> None:
        while station.picture.link.state is not state:
            await asyncio.sleep(0.02)

    async def work() -> None:
        async with station_on(RadioLink(simulator.uri)) as station:
            process.send_signal(signal.SIGSTOP)
            await until(station, LinkState.SILENT)
            process.send_signal(signal.SIGCONT)
            await until(station, LinkState.CONNECTED)
            before_ms = station.picture.drone_ms
            while station.picture.drone_ms == before_ms:
                await asyncio.sleep(0.02)
            process.kill()
            await until(station, LinkState.LOST)

    asyncio.run(work())


@pytest.mark.parametrize("simulator", [["--speed", "10"]], indirect=True)
@pytest.mark.parametrize("in_background", [False, True])
def test_interrupt_lands_first(simulator: SimulatorProcess, in_background: bool) -> None:
    command = [sys.executable, "-m", "ground", "goto", "1", "0", "--hold", "--uri", simulator.uri]
    before = signal.getsignal(signal.SIGINT)
    if in_background:  # of a script
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    flight = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    signal.signal(signal.SIGINT, before)
    with flight:
        assert flight.stdout is not None
        for line in flight.stdout:
            if "hovering there" in line:
                flight.send_signal(signal.SIGTERM if in_background else signal.SIGINT)
    assert flight.returncode == 130
    assert simulator.stop()["true_pose"][2] < 0.05


def test_states_pass_in_order(simulator: SimulatorProcess) -> None:
    seen: list[MissionState] = []

    async def work() -> None:
        async with station_on(RadioLink(simulator.uri)) as station:
            await take_off(station)
            assert station.picture.state.airborne
            await fly(station, MissionCmd.LAND)
            seen.extend(MissionState(e.argument) for e in station.picture.events)

    asyncio.run(work())
    assert seen == [
        MissionState.TAKEOFF,
        MissionState.SCAN,
        MissionState.HOVER,
        MissionState.LAND,
        MissionState.IDLE,
    ]
