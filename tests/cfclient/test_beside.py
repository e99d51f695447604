# SPDX-License-Identifier: GPL-3.0-or-later
"""cfclient and the station on one drone: neither blocks the other's parameters.

A third of a minute; `make test-cfclient MINUTES=10` for longer.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ground.sim.process import SimulatorProcess

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PROJECT_PYTHON = ROOT / ".venv/bin/python"
SCANNED_PORT = 19858
SECONDS = 60 * float(os.environ.get("MINUTES") or 0.3)


@pytest.mark.timeout(SECONDS + 250)
def test_cfclient_and_the_station_share_a_drone(tmp_path: Path) -> None:
    arguments = ("--world", "empty", "--silence", "60")
    python = str(PROJECT_PYTHON)
    with SimulatorProcess(*arguments, port=SCANNED_PORT, python=python) as simulator:
        config = tmp_path / "cfclient"
        config.mkdir()
        settings = {"link_uri": simulator.uri, "open_tabs": "Parameters,Flight Control"}
        (config / "config.json").write_text(json.dumps(settings))
        with subprocess.Popen(
            [python, str(HERE / "beside.py"), simulator.uri],
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        ) as beside:
            assert beside.stdout is not None
            assert beside.stdout.readline() == "there\n"
            client = subprocess.run(
                [sys.executable, str(HERE / "stay.py"), simulator.uri, str(SECONDS)],
                env=os.environ | {"QT_QPA_PLATFORM": "offscreen", "XDG_CONFIG_HOME": str(tmp_path)},
                capture_output=True,
                text=True,
                timeout=SECONDS + 200,
            )
            beside.terminate()
            station = json.loads(beside.stdout.readline())
        assert client.returncode == 0, client.stderr[-3000:]
        seen = json.loads(client.stdout.splitlines()[-1])
        truth = simulator.stop()
    print(f"cfclient {seen}, station {station}")
    assert seen["stayed_s"] >= SECONDS
    assert seen["written"] > 2 and seen["heard"] > 1, "it hears what the station writes"
    assert station["written"] > seen["written"]
    assert station["unanswered"] == station["other"] == 0
    assert station["heard"] > 1, "it hears what cfclient writes"
    assert truth["bad_packets"] == 0
