# SPDX-License-Identifier: GPL-3.0-or-later
"""A program that is killed while recording loses only seconds of it."""

import subprocess
import sys
import time
from pathlib import Path

from ground.model import Telemetry
from ground.record.reader import Heard, read_entries, read_recording, read_session
from ground.record.recorder import SENT
from ground.sim.process import SimulatorProcess

WRITTEN = 4  # so often it is seen to have grown
LOST_S = 3.0


def test_a_recording_replays_to_within_seconds_of_a_kill(tmp_path: Path) -> None:
    """The ground station only listens, which fills the file more slowly than a flight."""
    file = tmp_path / "killed.mcap"
    with SimulatorProcess("--speed", "1") as simulator:
        station = subprocess.Popen(
            [sys.executable, "-m", "ground", "ground", "--uri", simulator.uri, "--port", "0",
             "--record", str(file)],
            stdout=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            ends_s: set[float] = set()
            while len(ends_s) < WRITTEN:
                assert station.poll() is None
                time.sleep(0.1)
                if file.exists():
                    ends_s |= {max((time_s for time_s, _ in read_recording(file)), default=0.0)}
        finally:
            station.kill()
            station.wait()
    written_s = ends_s - {0.0}
    assert max(written_s) - min(written_s) < LOST_S * (len(written_s) - 1)
    assert max(time_s for time_s, _ in read_recording(file)) >= max(ends_s)
    heard = [word.message for word in read_session(file) if isinstance(word, Heard)]
    assert len([message for message in heard if isinstance(message, Telemetry)]) > 20
    assert any(entry.topic.startswith(SENT) for entry in read_entries(file))
