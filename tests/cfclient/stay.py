# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the real cfclient connected beside another client, and uses its parameters meanwhile.

    python stay.py URI SECONDS

Run by the Python that has cfclient installed. The other client writes `way.goalY` meanwhile.
"""

import json
import os
import sys
import time

from cfclient.ui.main import UIState
from drive import Parameters, click, connected, wait_for, watch
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication

PAUSE_MS = 1000


def stay(uri: str, seconds: float) -> dict[str, object]:
    """Connect, type a parameter repeatedly, and check that each value gets through."""
    window = connected(uri)
    parameters = Parameters(window)
    window.tab_widget.setCurrentWidget(parameters.tab)
    status = watch(window)
    begin_s, written, heard = time.monotonic(), 0, set()
    while time.monotonic() - begin_s < seconds:
        value = str((2 * (written % 16) + 1) / 16)
        parameters.type_value("way", "goalX", value)
        wait_for(f"{value} is set", lambda v=value: parameters.shown("way")["goalX"] == v)
        heard.add(parameters.shown("way")["goalY"])
        assert window.uiState == UIState.CONNECTED
        written += 1
        QTest.qWait(PAUSE_MS)
    status.clear()
    wait_for("logs still come", lambda: bool(status))
    stayed_s = time.monotonic() - begin_s
    click(window.connectButton)
    wait_for("it is disconnected", lambda: window.uiState == UIState.DISCONNECTED)
    return {"stayed_s": stayed_s, "written": written, "heard": len(heard)}


def main() -> None:
    uri, seconds = sys.argv[1:]
    application = QApplication(sys.argv[:1])
    application.setStyle("Fusion")
    try:
        print(json.dumps(stay(uri, float(seconds))), flush=True)
        code = 0
    except (AssertionError, TimeoutError) as error:
        print(f"waited in vain until {error}", file=sys.stderr, flush=True)
        code = 1
    # cflib and cfclient leave threads behind that would keep the process alive.
    os._exit(code)


if __name__ == "__main__":
    main()
