# SPDX-License-Identifier: GPL-3.0-or-later
"""The real cfclient connects to the simulated Crazyflie, and a goal typed into it is flown to.

Runs in an environment of its own (`make test-cfclient`); the simulator runs in the project's.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from ground.sim.process import SimulatorProcess

HERE = Path(__file__).parent
PROJECT_PYTHON = HERE.parent.parent / ".venv/bin/python"
SCANNED_PORT = 19853
GOAL = ("1.5", "0.75")
START_M = (1.25, 2.5)
"""Where the drone starts in the world `empty`, heading along x."""


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], dict[str, Any]]:
    """What cfclient showed, and the truth."""
    folder = tmp_path_factory.mktemp("cfclient")
    arguments = ("--world", "empty", "--speed", "4", "--silence", "60")
    with SimulatorProcess(*arguments, port=SCANNED_PORT, python=str(PROJECT_PYTHON)) as simulator:
        config = folder / "cfclient"
        config.mkdir()
        settings = {
            "link_uri": simulator.uri,
            "open_tabs": "Parameters,Flight Control",
            "window_size": [1200, 800],
        }
        (config / "config.json").write_text(json.dumps(settings))
        result = subprocess.run(
            [sys.executable, str(HERE / "drive.py"), simulator.uri, *GOAL, str(folder)],
            env=os.environ | {"QT_QPA_PLATFORM": "offscreen", "XDG_CONFIG_HOME": str(folder)},
            capture_output=True,
            text=True,
            timeout=250,
        )
        assert result.returncode == 0, result.stderr[-3000:]
        return json.loads(result.stdout.splitlines()[-1]), simulator.stop()


def test_its_parameters_tab_shows_the_app(flight: tuple[dict, dict]) -> None:
    seen, _ = flight
    assert {"goalX", "goalY", "cmd", "height", "speed", "planner", "slam"} <= seen["shown"].keys()
    assert float(seen["shown"]["height"]) > 0
    assert 3.0 < float(seen["battery"]) < 4.3


def test_the_drone_flew_to_the_goal_and_landed(flight: tuple[dict, dict]) -> None:
    seen, truth = flight
    goal = [float(part) for part in GOAL]
    assert [seen["arrived"]["way.x"], seen["arrived"]["way.y"]] == pytest.approx(goal, abs=0.3)
    x_m, y_m, z_m, _ = truth["true_pose"]
    assert [x_m - START_M[0], y_m - START_M[1]] == pytest.approx(goal, abs=0.5)
    assert z_m < 0.05 and truth["max_height_m"] > 0.3
    assert truth["collisions"] == 0 and truth["bad_packets"] == 0
