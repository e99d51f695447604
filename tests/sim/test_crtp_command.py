# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie sim` as a user meets it: what it refuses, what it stores, how it ends."""

import json
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ground.errors import SimulatorFailed
from ground.sim.process import SimulatorProcess
from tests.sim.crtp_client import RawClient

PARAM = 2


def refusal(*arguments: str) -> str:
    """The one line that says why it does not start."""
    command = [sys.executable, "-m", "ground.sim", "--port", "0", *arguments]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert result.returncode == 2 and result.stdout == ""
    return result.stderr


def test_a_world_with_an_error_is_refused_by_file_key_and_reason(tmp_path: Path) -> None:
    world = tmp_path / "broken.toml"
    world.write_text('title = "Broken"\n[start]\nx = 1.0\ny = "left"\n')
    line = refusal("--world", str(world))
    assert line.count("\n") == 1
    assert all(part in line for part in ("broken.toml", "start"))


def test_a_taken_port_is_refused() -> None:
    with SimulatorProcess("--world", "empty") as first:
        port = int(first.uri.rpartition(":")[2])
        with pytest.raises(SimulatorFailed, match=str(port)):
            SimulatorProcess("--world", "empty", port=port).start()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_cleanly_and_writes_what_was_true(tmp_path: Path, number: int) -> None:
    file = tmp_path / "status.json"
    command = [sys.executable, "-m", "ground.sim", "--port", "0", "--world", "empty", "--trail"]
    with subprocess.Popen([*command, "--json", str(file)], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith(b"Crazyflie at udp://127.0.0.1:")
        process.send_signal(number)
        assert process.wait(20) == 0
    status = json.loads(file.read_text())
    assert status["collisions"] == 0 and status["path_m"] == pytest.approx(0, abs=0.01)
    assert status["sim_s"] >= 1.0 and status["app_alive"]
    times = [entry[0] for entry in status["trail"]]
    assert times == sorted(times) and len(times) > 5


def test_stored_parameters_survive_a_restart(tmp_path: Path) -> None:
    file = str(tmp_path / "eeprom.json")
    value = struct.pack("<f", 0.6)
    for boot in ("first", "second"):
        with (
            SimulatorProcess("--world", "empty", "--eeprom", file) as simulator,
            RawClient(simulator.uri) as client,
        ):
            height = struct.pack("<H", client.toc(PARAM)["way.height"][0])
            stored = client.ask(PARAM, 3, b"\4" + height)[3]
            current = client.ask(PARAM, 1, height)[3:]
            if boot == "first":
                assert stored == 0 and current != value
                client.ask(PARAM, 2, height + value)
                assert client.ask(PARAM, 3, b"\3" + height)[3] == 0
            else:
                assert stored == 1 and current == value


def test_it_ends_when_whoever_started_it_was_killed() -> None:
    starter = (
        "import time; from ground.sim.process import SimulatorProcess\n"
        "with SimulatorProcess('--world', 'empty') as simulator:\n"
        "    print(simulator.uri, flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", starter], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        port = int(process.stdout.readline().decode().rpartition(":")[2])
        process.kill()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.connect(("127.0.0.1", port))
        client.settimeout(0.1)
        for _ in range(100):
            try:
                client.send(b"\xff")  # the scan probe, answered as long as it lives
                client.recv(1)
                time.sleep(0.1)
            except ConnectionRefusedError:
                return
            except TimeoutError:
                continue
    pytest.fail("the simulator outlived the process that started it")
