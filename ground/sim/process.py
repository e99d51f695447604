# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the simulator in its own process, and so with its own interpreter lock."""

import json
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any

from ground.errors import SimulatorFailed

READY = "Crazyflie at "
"""Start of the first line of output, printed once clients can connect; the URI follows."""
_STOP_S = 20.0


def _failure(told: str, otherwise: str) -> SimulatorFailed:
    """Make an error of what the simulator printed; `otherwise` if that was nothing."""
    sentence, _, step = told.strip().removeprefix("wayflie: ").partition("\n  next: ")
    return SimulatorFailed(sentence or otherwise, step)


class SimulatorProcess:
    """Context in which the simulator runs and answers at `uri`; stop() returns its status."""

    def __init__(
        self, *arguments: str, port: int = 0, python: str = sys.executable, drones: int = 1
    ) -> None:
        self._command = [python, "-m", "ground.sim", *arguments, "--port", str(port)]
        self._command += ["--drones", str(drones)] if drones > 1 else []
        self._drones = drones
        self._folder = tempfile.TemporaryDirectory(prefix="wayflie-sim-")
        self._json = Path(self._folder.name) / "status.json"
        self._process: subprocess.Popen[str] | None = None
        self.uri = ""
        self.uris: list[str] = []
        """URIs of all drones; `uri` is the first."""

    def __enter__(self) -> "SimulatorProcess":
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.kill()
        self._folder.cleanup()

    def start(self) -> str:
        """Start the simulator, wait until clients can connect, and return the URI."""
        command = [*self._command, "--with-parent", "--json", str(self._json)]
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,  # Ctrl-C goes only to the program that flies, which lands first
        )
        self._process = process
        assert process.stdout is not None
        line = process.stdout.readline()
        if not line.startswith(READY):
            _, errors = process.communicate()
            self._folder.cleanup()
            raise _failure(errors, "the simulator ended at once")
        lines = [line, *(process.stdout.readline() for _ in range(1, self._drones))]
        self.uris = [line.removeprefix(READY).split(",")[0].strip() for line in lines]
        self.uri = self.uris[0]
        return self.uri

    def say(self, line: str) -> None:
        """Write a line to the simulator's standard input."""
        if self._process is None or self._process.stdin is None:
            raise SimulatorFailed("the simulator was not started")
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def stop(self) -> dict[str, Any]:
        """End the simulator and read the true figures of the flight."""
        if self._process is None:
            raise SimulatorFailed("the simulator was not started")
        self._process.send_signal(signal.SIGTERM)
        try:
            _, errors = self._process.communicate(timeout=_STOP_S)
        except subprocess.TimeoutExpired:
            raise SimulatorFailed(f"the simulator did not end within {_STOP_S:.0f} s") from None
        if self._process.returncode != 0:
            raise _failure(errors, "the simulator failed")
        status: dict[str, Any] = json.loads(self._json.read_text())
        return status

    def kill(self) -> None:
        """Kill the simulator if it still runs."""
        if self._process is not None:
            with self._process as process:  # closes its pipes, even if it has ended by itself
                if process.poll() is None:
                    process.kill()
