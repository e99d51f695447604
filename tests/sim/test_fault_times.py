# SPDX-License-Identifier: GPL-3.0-or-later
"""When faults begin and end, by options and by hand, and what is refused."""

import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ground.cli.app import app
from ground.sim.console import Lines, obey
from ground.sim.faults import parse_fault
from ground.sim.faulttable import FAULTS
from ground.sim.process import SimulatorProcess
from tests.sim.faultbench import Bench


def test_faults_come_and_go_at_their_times() -> None:
    bench = Bench(parse_fault("flow-lost@2:1.5"), parse_fault("e-stop@6"))
    assert bench.simulator.status()["faults"] == []
    bench.fly(4.0)
    happened = bench.simulator.status()["faults"]
    assert happened == [
        {"name": "flow-lost", "begin_s": pytest.approx(2.0), "end_s": pytest.approx(3.5)}
    ]
    bench.fly(2.0)
    assert bench.simulator.faults.log[-1].name == "e-stop"


@pytest.mark.parametrize(
    "text", ["nonsense@1", "flow-lost", "flow-lost@", "flow-lost@x", "flow-lost@-1",
             "flow-lost@nan", "flow-lost@1:", "flow-lost@1:0", "flow-lost@1:inf", "@1"],
)  # fmt: skip
def test_a_fault_that_makes_no_sense_is_refused(text: str) -> None:
    with pytest.raises(ValueError):
        parse_fault(text)
    result = CliRunner().invoke(app, ["sim", "--fault", text])
    assert result.exit_code == 2


def test_an_unknown_fault_is_refused_with_all_names() -> None:
    with pytest.raises(ValueError, match=r"ranges-frozen.*walled-in"):
        parse_fault("gremlins@1")


def test_lines_at_the_console() -> None:
    bench = Bench().fly(0.5)
    faults = bench.simulator.faults
    assert "begun" in obey("fault flow-lost:0.5", faults)
    assert faults.log[-1].name == "flow-lost"
    bench.fly(0.6)
    assert obey("end flow-lost", faults) == "flow-lost: not there"
    assert set(FAULTS) <= set(obey("faults", faults).split())
    for line in ("fault", "fault gremlins", "fault box:x", "fault box:-1", "boo", "end"):
        assert "begun" not in obey(line, faults)
    assert obey("", faults) == ""
    assert len(faults.log) == 1


def test_lines_come_whole_and_nobody_waits_for_them() -> None:
    read, write = os.pipe()
    lines = Lines(read)
    assert list(lines.take()) == []
    os.write(write, b"fau")
    assert list(lines.take()) == []
    os.write(write, b"lts\nend x\n\xff")
    assert list(lines.take()) == ["faults", "end x"]
    os.close(write)
    assert list(lines.take()) == []
    assert list(lines.take()) == []
    os.close(read)


def test_a_running_simulator_takes_lines(tmp_path: Path) -> None:
    with SimulatorProcess("--world", "empty", "--fault", "battery-low@0.5") as simulator:
        simulator.say("fault tumbled")
        simulator.say("faults")
        status = simulator.stop()
    assert [happened["name"] for happened in status["faults"]] == ["battery-low", "tumbled"]
