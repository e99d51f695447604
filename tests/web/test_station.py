# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie ground` and `wayflie scan` as they are typed; one of two drones goes and returns."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner
from websockets.sync.client import ClientConnection, connect

from ground.cli.app import app
from ground.sim.process import SimulatorProcess

# cflib leaves the sockets of its scan to the garbage collector.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")

ARGUMENTS = ("--world", "empty", "--speed", "3")
SCANNED_PORT = 19855

Frame = dict[str, Any]


@contextmanager
def station(folder: Path, *arguments: str) -> Iterator[str]:
    """The running command, and the page's address."""
    command = [sys.executable, "-m", "ground", "ground", "--port", "0", *arguments]
    environment = os.environ | {"XDG_DATA_HOME": str(folder)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        assert found
        yield found[0]
        process.terminate()
        process.stdout.read()


def frame_where(page: ClientConnection, condition: Callable[[Frame], bool]) -> Frame:
    """The first state that meets a condition."""
    for message in page:
        if isinstance(message, str):
            frame: Frame = json.loads(message)
            if frame["kind"] == "state" and condition(frame):
                return frame
    raise AssertionError("the page's server has gone")


def page_at(address: str) -> ClientConnection:
    origin = address.rstrip("/")
    address = origin.replace("http", "ws") + "/socket"
    return connect(address, origin=origin, max_size=None, close_timeout=0.1)


def links(frame: Frame) -> list[str]:
    return [drone["link"] for drone in frame["fleet"]]


def test_two_drones_one_of_which_goes_and_comes_back_as_another(tmp_path: Path) -> None:
    with SimulatorProcess(*ARGUMENTS) as first, SimulatorProcess(*ARGUMENTS) as second:
        port = int(second.uri.rpartition(":")[2])
        uris = ("--uri", first.uri, "--uri", f"{second.uri}@0.5,-1,90")
        with station(tmp_path, *uris) as address, page_at(address) as page:
            frame = frame_where(page, lambda f: links(f) == ["connected"] * 2)
            frame = frame_where(page, lambda f: f["fleet"][1]["pose"] is not None)
            assert [drone["name"] for drone in frame["fleet"]] == [first.uri, second.uri]
            pose = frame["fleet"][1]["pose"]
            assert abs(pose[0] - 0.5) + abs(pose[1] + 1) + abs(pose[3] - 1.571) < 0.1
            page.send(json.dumps({"do": "choose", "drone": 1}))
            frame_where(page, lambda f: f["fleet"][1]["chosen"] and f["can"]["take_off"])
            second.kill()
            frame = frame_where(page, lambda f: links(f) == ["connected", "reconnecting"])
            assert "looking for the drone" in frame["link"]["detail"]
            assert not any(frame["can"].values())
            with SimulatorProcess(*ARGUMENTS, port=port):
                frame = frame_where(page, lambda f: links(f) == ["connected"] * 2)
                frame_where(page, lambda f: f["can"]["take_off"])


def test_what_the_scan_finds_is_what_all_means(tmp_path: Path) -> None:
    with SimulatorProcess(*ARGUMENTS, port=SCANNED_PORT, drones=2) as simulator:
        found = CliRunner().invoke(app, ["scan"])
        assert found.exit_code == 0
        assert set(simulator.uris) <= set(found.output.split())
        with station(tmp_path, "--all") as address, page_at(address) as page:
            frame = frame_where(page, lambda f: links(f).count("connected") >= 2)
            assert set(simulator.uris) <= {drone["name"] for drone in frame["fleet"]}


def test_wrong_places_and_doubles_are_refused() -> None:
    for uris in (["udp://a:1@x,y"], ["udp://a:1@1"], ["udp://a:1@nan,1"], ["udp://a:1"] * 2):
        arguments = [part for uri in uris for part in ("--uri", uri)]
        assert CliRunner().invoke(app, ["ground", *arguments]).exit_code == 2
