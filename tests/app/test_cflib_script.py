# SPDX-License-Identifier: GPL-3.0-or-later
"""A script that knows only cflib and the documented bytes flies the drone and sees its map."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ground.sim.process import SimulatorProcess
from ground.sim.world import load_world
from tests.sim.crtp_client import PATIENT

SCRIPT = Path(__file__).with_name("cflib_script.py")
GOAL_M = (1.5, 0.8)


@pytest.fixture(scope="module")
def flight() -> tuple[dict, dict]:
    """What the script printed, and the truth."""
    with SimulatorProcess("--world", "empty", "--speed", "max", *PATIENT) as simulator:
        command = [sys.executable, str(SCRIPT), simulator.uri, *map(str, GOAL_M)]
        result = subprocess.run(command, capture_output=True, text=True, timeout=200)
        assert result.returncode == 0, result.stderr
        return json.loads(result.stdout), simulator.stop()


def test_the_drone_went_there_and_landed(flight: tuple[dict, dict]) -> None:
    seen, truth = flight
    assert (seen["arrived"]["x"], seen["arrived"]["y"]) == pytest.approx(GOAL_M, abs=0.3)
    world = load_world("empty")
    x_m, y_m, z_m, _ = truth["true_pose"]
    assert world.to_map(x_m, y_m) == pytest.approx(GOAL_M, abs=0.5)
    assert z_m < 0.05 and truth["max_height_m"] > 0.3 and truth["collisions"] == 0


def test_the_map_that_it_rebuilt_is_the_room(flight: tuple[dict, dict]) -> None:
    seen, _ = flight
    world = load_world("empty")
    cells = np.array([list(row) for row in seen["grid"]])
    rows, columns = np.nonzero(cells == "#")
    map_m = np.column_stack((columns + 0.5, rows + 0.5)) * seen["cell_m"] + seen["origin_m"]
    world_m = np.column_stack(world.to_world(map_m[:, 0], map_m[:, 1]))
    assert len(rows) > 100
    assert np.median(world.surface_distance_m(world_m)) < 0.15
    assert np.count_nonzero(cells == ".") * seen["cell_m"] ** 2 > 10
    assert np.count_nonzero(cells == "?") > 0
