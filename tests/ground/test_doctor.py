# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie doctor` names what is missing, each with its next step."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ground.cli.app import app
from ground.cli.doctor import DECKS, Seen, judge
from ground.cli.machine import Finding, UsbDevice, Verdict, machine, usb_devices
from ground.core import SelfTest
from ground.model import Health
from ground.sim.process import READY, SimulatorProcess

GOOD, NOTE, BAD = Verdict.GOOD, Verdict.NOTE, Verdict.BAD
ALL_DECKS = dict.fromkeys(DECKS, 1.0)
HEALTH = Health(1000, 4.0, 0.0, 0, 0, 0, 0, 0, supervisor=1 << 3, self_test=SelfTest.NOT_RUN)
WELL = Seen(ALL_DECKS, log_packets=100, latency_ms=5.0, low_battery_v=3.2, health=HEALTH)
RADIO = UsbDevice((0x1915, 0x7777), Path("/dev/bus/usb/001/004"))
CRAZYFLIE = UsbDevice((0x0483, 0x5740), Path("/dev/bus/usb/001/005"))


def test_a_drone_that_is_well_is_said_to_be() -> None:
    assert {finding.verdict for finding in judge(WELL)} == {GOOD}


@pytest.mark.parametrize(
    ("seen", "what", "verdict", "word", "step"),
    [
        (replace(WELL, decks=ALL_DECKS | {"deck.bcFlow2": 0.0}), "deck", BAD, "Flow", "put it on"),
        (replace(WELL, decks={"deck.bcFlow2": 1.0}), "deck", BAD, "Multi-ranger", "put it on"),
        (replace(WELL, loss=0.25), "loss", NOTE, "25.0%", "channel"),
        (replace(WELL, latency_ms=300.0), "latency", NOTE, "300 ms", "other programs"),
        (replace(WELL, bad_packets=3), "protocol", BAD, "3 packets", "make flash"),
        (replace(WELL, health=None), "logs", BAD, "no values", "--verbose"),
        (replace(WELL, health=replace(HEALTH, battery_v=3.1)), "battery", BAD, "3.10", "charge"),
        (replace(WELL, health=replace(HEALTH, battery_v=3.3)), "battery", NOTE, "short", "charge"),
        (replace(WELL, health=replace(HEALTH, supervisor=0)), "supervisor", NOTE, "let", "armed"),
        (
            replace(WELL, health=replace(HEALTH, supervisor=1 << 6)),
            "supervisor",
            BAD,
            "locked",
            "off and on",
        ),
        (
            replace(WELL, health=replace(HEALTH, supervisor=1 << 5)),
            "supervisor",
            BAD,
            "side",
            "upright",
        ),
    ],
)
def test_each_trouble_is_named_with_the_next_step(
    seen: Seen, what: str, verdict: Verdict, word: str, step: str
) -> None:
    (found,) = [finding for finding in judge(seen) if finding.verdict is not GOOD]
    assert (found.what, found.verdict) == (what, verdict)
    assert word in found.sentence
    assert step in found.next_step


def last(uri: str, *devices: UsbDevice, may_use: bool = True) -> Finding:
    return list(machine(uri, lambda: iter(devices), lambda path: may_use))[-1]


@pytest.mark.parametrize(
    ("uri", "device", "ids"),
    [("radio://0/80/2M", RADIO, "1915"), ("usb://0", CRAZYFLIE, "0483")],
)
def test_what_is_plugged_in_and_who_may_open_it(uri: str, device: UsbDevice, ids: str) -> None:
    absent = last(uri)
    assert (absent.verdict, "plug" in absent.next_step) == (BAD, True)
    forbidden = last(uri, device, may_use=False)
    assert forbidden.verdict is BAD
    assert str(device.node) in forbidden.sentence
    assert f'ATTRS{{idVendor}}=="{ids}"' in forbidden.next_step
    assert "/etc/udev/rules.d" in forbidden.next_step
    assert last(uri, device).verdict is GOOD


def test_a_serial_line_must_be_there_and_be_permitted() -> None:
    assert "is not there" in last("serial://ttyNothing").sentence
    master, slave = os.openpty()
    uri = f"serial://{os.ttyname(slave)}"
    assert "dialout" in last(uri, may_use=False).next_step
    assert last(uri).verdict is GOOD
    code, output = doctor(uri)
    assert (code, "CPX" in output) == (1, True)
    os.close(master)
    os.close(slave)


def test_usb_devices_are_read_from_the_system(tmp_path: Path) -> None:
    radio = {"idVendor": "1915\n", "idProduct": "7777\n", "busnum": "1\n", "devnum": "4\n"}
    for folder, files in {"1-1": radio, "usb1": {"idVendor": "1d6b\n"}}.items():
        (tmp_path / folder).mkdir()
        for name, text in files.items():
            (tmp_path / folder / name).write_text(text)
    assert list(usb_devices(tmp_path)) == [RADIO]


def doctor(uri: str, *arguments: str) -> tuple[int, str]:
    command = ["doctor", "--uri", uri, "--seconds", "1", *arguments]
    result = CliRunner().invoke(app, command)
    return result.exit_code, result.output


@pytest.mark.parametrize(
    ("uri", "step"),
    [
        ("nonsense", "--uri or CFLIB_URI"),
        ("udp://127.0.0.1:1", "wayflie sim"),
        ("serial://ttyNothing", "plug the adapter in"),
    ],
)
def test_a_drone_that_cannot_be_reached_is_exit_1_with_a_step(uri: str, step: str) -> None:
    code, output = doctor(uri)
    assert code == 1
    assert step in output


def test_a_lossy_simulator_is_examined(tmp_path: Path) -> None:
    report = tmp_path / "doctor.json"
    with SimulatorProcess("--world", "empty", "--loss", "0.25") as simulator:
        code, output = doctor(simulator.uri, "--json", str(report), "--seconds", "4")
    assert code == 0, output
    findings = {f["what"]: f for f in json.loads(report.read_text())["findings"]}
    assert findings["loss"]["verdict"] == "note"
    assert findings["battery"]["verdict"] == findings["connection"]["verdict"] == "good"


OTHER_FIRMWARE = """
import sys
from dataclasses import replace
from ground.sim.firmware import Firmware
entries, push, take = Firmware.log_entries, Firmware.appchannel_push, Firmware.appchannel_take
if sys.argv.pop() == "no-app":
    Firmware.log_entries = lambda self: [
        replace(e, group="other") if e.group == "way" else e for e in entries(self)
    ]
else:
    Firmware.appchannel_push = lambda self, data: push(self, bytes((77,)) + data[1:])
    Firmware.appchannel_take = lambda self: (data := take(self)) and bytes((77,)) + data[1:]
from ground.cli.sim import sim
import typer
typer.run(sim)
"""


@contextmanager
def other_firmware(kind: str) -> Iterator[str]:
    """A simulator with another firmware; its URI."""
    command = [sys.executable, "-c", OTHER_FIRMWARE, "--port", "0", "--world", "empty", kind]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield process.stdout.readline().removeprefix(READY).split(",")[0]
        process.terminate()


@pytest.mark.parametrize(
    ("kind", "sentence"), [("no-app", "runs no Wayflie app"), ("other-version", "does not answer")]
)
def test_a_firmware_without_the_app_or_with_another_is_to_be_flashed(
    kind: str, sentence: str
) -> None:
    with other_firmware(kind) as uri:
        code, output = doctor(uri)
    assert code == 1
    assert sentence in output
    assert "make flash" in output
