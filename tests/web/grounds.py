# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie ground` in its own process, always at the same port."""

from __future__ import annotations

import re
import subprocess
import sys
from urllib.parse import urlsplit


class GroundProcess:
    """Context in which the ground station runs and serves the page at its address."""

    def __init__(self, *uris: str, record: str = "off") -> None:
        self._command = [sys.executable, "-m", "ground", "ground", "--record", record]
        self._command += [part for uri in uris for part in ("--uri", uri)]
        self._process: subprocess.Popen[str] | None = None
        self.address = ""

    def __enter__(self) -> GroundProcess:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.kill()

    @property
    def pid(self) -> int:
        """Process id of the running station."""
        assert self._process is not None
        return self._process.pid

    def start(self) -> None:
        """Run it and wait until it prints where the page is."""
        port = urlsplit(self.address).port or 0
        self._process = subprocess.Popen(
            [*self._command, "--port", str(port)], stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        found = re.search(r"http://\S+", self._process.stdout.readline())
        assert found, "the ground station ended at once"
        self.address = found[0]

    def kill(self) -> None:
        """Kill it; nothing that it would do at its end may be needed afterwards."""
        if self._process is not None:
            with self._process as process:
                process.kill()
