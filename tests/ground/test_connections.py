# SPDX-License-Identifier: GPL-3.0-or-later
"""All kinds of connections; simulators that die, fall silent and return as another."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable
from pathlib import Path

import cflib.crtp
import pytest
from typer.testing import CliRunner

from ground.cli.app import app
from ground.core import MissionCmd, MissionState
from ground.errors import LinkLost, LinkUnavailable
from ground.link.drivers import AnySerialDriver, init_drivers, scan
from ground.link.kept import KeptLink
from ground.link.radio import RadioLink
from ground.link.uri import SCANNED_PORTS
from ground.model import LinkState, Point
from ground.sim.process import SimulatorProcess
from ground.station.flight import fly
from ground.station.station import Station, station_on
from tests.ground.stations import take_off
from tests.ground.uartbridge import UartBridge

ARGUMENTS = ("--world", "empty", "--speed", "5")
GO_ON = 0  # way.lost
ONCE = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await asyncio.sleep(0.01)


async def link_is(station: Station, *states: LinkState) -> None:
    """Wait for these link states in turn."""
    for state in states:
        await until(lambda state=state: station.picture.link.state is state)


@ONCE
def test_silence_is_survived_with_mission_and_map() -> None:
    async def work(simulator: SimulatorProcess) -> None:
        process = simulator._process
        assert process is not None
        async with station_on(KeptLink(lambda: RadioLink(simulator.uri))) as station:
            await take_off(station)
            known = station.picture.map.known_cells
            assert known > 0
            process.send_signal(signal.SIGSTOP)
            await link_is(station, LinkState.SILENT)
            process.send_signal(signal.SIGCONT)
            await link_is(station, LinkState.CONNECTED)
            before_ms = station.picture.drone_ms
            await until(lambda: station.picture.drone_ms > before_ms + 1000)
            assert station.picture.state.airborne
            assert station.picture.map.known_cells >= known
            assert (await fly(station, MissionCmd.LAND)).reached

    with SimulatorProcess(*ARGUMENTS) as simulator:
        asyncio.run(work(simulator))


async def grown_old(station: Station) -> None:
    """Fly until the drone is older than a restarted one can be when it is found."""
    await take_off(station)
    await until(lambda: station.picture.drone_ms > 20_000)


@ONCE
def test_a_drone_that_comes_back_anew_is_known_as_such() -> None:
    async def work(simulator: SimulatorProcess) -> None:
        port = int(simulator.uri.rpartition(":")[2])
        async with station_on(KeptLink(lambda: RadioLink(simulator.uri))) as station:
            await grown_old(station)
            flight = asyncio.create_task(fly(station, MissionCmd.GOTO, Point(1.0, 0.5)))
            await until(lambda: station.picture.state is MissionState.FOLLOW)
            threads = threading.active_count()
            for _ in range(2):
                simulator.kill()
                await link_is(station, LinkState.RECONNECTING)
                with SimulatorProcess(*ARGUMENTS, port=port) as reborn:
                    await link_is(station, LinkState.CONNECTED)
                    await until(lambda: station.picture.telemetry is not None)
                    assert station.picture.state is MissionState.IDLE
                    assert station.picture.map.known_cells == 0
                    assert not station.picture.trail
                    await grown_old(station)
                    reborn.kill()
            with pytest.raises(LinkLost, match="restarted"):
                await flight
            await until(lambda: threading.active_count() <= threads)

    with SimulatorProcess(*ARGUMENTS) as simulator:
        asyncio.run(work(simulator))


@ONCE
def test_a_flight_goes_on_over_a_break_of_the_link() -> None:
    """The drone waits meanwhile, however long the ground takes to find it again."""

    async def wait_when_silent(uri: str) -> None:
        async with station_on(RadioLink(uri)) as station:
            await station.set_parameter("way.lost", GO_ON)

    with SimulatorProcess("--world", "empty") as simulator:
        process = simulator._process
        assert process is not None
        asyncio.run(wait_when_silent(simulator.uri))
        command = [sys.executable, "-m", "ground", "goto", "1", "0", "--uri", simulator.uri]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as flight:
            assert flight.stdout is not None
            told = ""
            for line in flight.stdout:
                told += line
                if "flying" in line and "looking for" not in told:
                    process.send_signal(signal.SIGSTOP)
                if "looking for the drone: nothing heard for 5 s" in line:
                    process.send_signal(signal.SIGCONT)
        assert flight.returncode == 0, told
        assert "looking for" in told
        assert simulator.stop()["true_pose"][2] < 0.05


@ONCE
def test_serial_through_cflibs_own_driver() -> None:
    async def work(uri: str) -> None:
        async with station_on(RadioLink(uri)) as station:
            await until(lambda: station.picture.map.completeness == 1)
            assert await station.set_parameter("way.goalX", 1.25) == 1.25
            await take_off(station)
            assert (await fly(station, MissionCmd.LAND)).reached
            assert station.stats.bad_packets == 0

    before = threading.active_count()
    with SimulatorProcess(*ARGUMENTS) as simulator, UartBridge(simulator.uri) as uart:
        asyncio.run(work(f"serial://{uart.path}"))
    while threading.active_count() > before:  # a thread left behind fails by the time limit
        time.sleep(0.01)


@ONCE
def test_a_serial_line_that_falls_silent_is_noticed_and_let_go() -> None:
    async def work(uri: str, uart: UartBridge) -> None:
        with pytest.raises(LinkLost, match="nothing heard"):
            async with station_on(RadioLink(uri)) as station:
                uart.cut()
                await link_is(station, LinkState.SILENT)
                await station.ended()

    with SimulatorProcess(*ARGUMENTS) as simulator, UartBridge(simulator.uri) as uart:
        asyncio.run(work(f"serial://{uart.path}", uart))


def test_a_serial_line_with_nobody_at_its_end_is_told() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    path = os.ttyname(slave)
    with pytest.raises(LinkUnavailable, match=f"no cpx at {path}"):
        asyncio.run(RadioLink(f"serial://{path}").open())
    os.close(master)
    os.close(slave)


def test_who_has_set_up_cflib_before_still_has_serial_lines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cflib.crtp, "CLASSES", [])
    cflib.crtp.init_drivers()
    for _ in range(2):
        init_drivers()
    assert AnySerialDriver in cflib.crtp.CLASSES
    assert len(set(cflib.crtp.CLASSES)) == len(cflib.crtp.CLASSES)


def test_a_scan_finds_who_answers_late() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as late:
        late.bind(("127.0.0.1", SCANNED_PORTS[-1]))

        def answer() -> None:
            probe, asker = late.recvfrom(64)
            time.sleep(0.3)
            late.sendto(probe, asker)

        busy = threading.Thread(target=answer)
        busy.start()
        found = scan()
        busy.join()
    assert f"udp://127.0.0.1:{SCANNED_PORTS[-1]}" in found


@ONCE
@pytest.mark.parametrize(
    ("uri", "why"),
    [
        ("radio://0/80/2M/E7E7E7E7E7", "nobody answers at {} (cannot find a crazyradio dongle)"),
        ("usb://0", "nobody answers at {} (could not open usb://0)"),
        ("serial://ttyNothing", "nobody answers at {} (could not identify device)"),
        ("serial://../../etc/passwd", "nobody answers at {} (could not identify device)"),
        ("udp://127.0.0.1", "'{}' should be udp://HOST:PORT"),
        ("udp://:19850", "'{}' should be udp://HOST:PORT"),
        ("udp://127.0.0.1:99999", "'{}' should be udp://HOST:PORT"),
        ("19850", "'{}' is none of radio://0/CHANNEL/RATE/ADDRESS, usb://0, "),
        ("", "'{}' is none of radio://"),
    ],
)
def test_what_is_not_there_is_one_line_and_what_to_do(uri: str, why: str) -> None:
    result = CliRunner().invoke(app, ["land", "--uri", uri])
    nobody = "nobody answers" in why
    assert result.exit_code == (1 if nobody else 2)
    line, *step = result.stderr.splitlines()
    assert line.startswith(f"wayflie: {why.format(uri)}")
    assert len(step) == nobody


NATIVE = '''
"""What stands for cflib's native library: the URI's port leads to a simulator by UDP."""
import socket

class Packet:
    valid = False

class Connection:
    def __init__(self, uri):
        if not uri.startswith("radio://"):
            raise RuntimeError("not of this library")
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", int(uri.rpartition("/")[2])))
        self.statistics = type("Statistics", (), {"sent_count": 0, "ack_count": 0})()

    def send(self, packet):
        header = packet.port << 4 | 0x0C | packet.channel
        self._socket.send(bytes((header,)) + packet.payload)

    def recv(self, timeout):
        packet = Packet()
        self._socket.settimeout(timeout / 1000)
        try:
            data = self._socket.recv(100)
        except TimeoutError:
            return packet
        packet.valid, packet.port, packet.channel = True, data[0] >> 4, data[0] & 3
        packet.payload = data[1:]
        return packet

    def close(self):
        self._socket.close()

    @staticmethod
    def scan(*address):
        return ["radio://native"]
'''


def test_the_native_link_is_taken_where_it_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "cflinkcpp.py").write_text(NATIVE)
    with SimulatorProcess(*ARGUMENTS) as simulator:
        port = simulator.uri.rpartition(":")[2]
        environment = os.environ | {"USE_CFLINK": "cpp", "PYTHONPATH": str(tmp_path)}
        command = [sys.executable, "-m", "ground", "map", "save", str(tmp_path / "map.npz")]
        done = subprocess.run(
            [*command, "--uri", f"radio://{port}"], env=environment, capture_output=True, text=True
        )
    assert done.returncode == 0, done.stderr
    assert "100% of the map received" in done.stdout


def test_a_native_link_that_is_not_installed_is_told() -> None:
    environment = os.environ | {"USE_CFLINK": "cpp"}
    command = [sys.executable, "-m", "ground", "land", "--uri", "radio://0/80/2M"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    assert "cflinkcpp, which is missing" in " ".join(done.stderr.split())
