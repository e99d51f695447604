# SPDX-License-Identifier: GPL-3.0-or-later
"""Every example runs on one simulated drone and does what it says."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from ground.sim.process import SimulatorProcess
from tests.project.files import ROOT

EXAMPLES = {
    path.stem for path in (ROOT / "ground" / "examples").glob("*.py") if path.stem != "__init__"
}
SAYS = {
    "visit": "left out: could not go to a point: the goal is outside",
    "listen": " m\n",
    "explore": "",
    "recording": ".mcap: ",
}


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What each example printed; they ran in their own folder."""
    folder = tmp_path_factory.mktemp("examples")
    said = {"": str(folder)}
    with SimulatorProcess("--world", "empty", "--speed", "max") as simulator:
        for name in SAYS:
            done = subprocess.run(
                [sys.executable, "-m", f"ground.examples.{name}"],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": str(ROOT), "CFLIB_URI": simulator.uri},
                capture_output=True,
                text=True,
            )
            assert done.returncode == 0, done.stderr
            said[name] = done.stdout
        truth = simulator.stop()
    assert truth["true_pose"][2] < 0.05, "the last one that flew has landed"
    return said


def test_no_example_is_left_out() -> None:
    assert set(SAYS) == EXAMPLES


@pytest.mark.parametrize("name", SAYS)
def test_an_example_says_what_it_did(name: str, said: dict[str, str]) -> None:
    assert SAYS[name] in said[name]


def test_the_examples_leave_maps(said: dict[str, str]) -> None:
    folder = Path(said[""])
    about = yaml.safe_load((folder / "room.yaml").read_text())
    assert (folder / about["image"]).exists()
    assert (folder / "room.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "recording.svg").read_text().count("<circle") > 50


def test_the_first_example_is_ten_lines() -> None:
    lines = (ROOT / "ground" / "examples" / "explore.py").read_text().splitlines()
    code = [line for line in lines if line.strip() and not line.lstrip().startswith(("#", '"""'))]
    assert len(code) <= 10
