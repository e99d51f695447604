# SPDX-License-Identifier: GPL-3.0-or-later
"""Operate the real cfclient as a user does, by mouse and keys, and print what it showed.

    python drive.py URI GOAL_X GOAL_Y FOLDER

Run by the Python that has cfclient installed. The simulator at URI must be there first: cfclient
offers what its scan at the start finds. FOLDER gets pictures of the window.
"""

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from cfclient.ui.main import MainUI, UIState
from cflib.crazyflie.log import LogConfig
from PyQt6.QtCore import QModelIndex, Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication, QWidget

LIMIT_S = 90.0
VALUE_COLUMN = 4
GO_TO, LAND = "2", "5"
IDLE, HOVER = 0, 6


def wait_for(what: str, condition: Callable[[], bool]) -> None:
    """Process window events until the condition holds."""
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        if time.monotonic() > end_s:
            raise TimeoutError(what)
        QTest.qWait(20)


def click(widget: QWidget) -> None:
    QTest.mouseClick(widget, Qt.MouseButton.LeftButton)


class Parameters:
    """The Parameters tab."""

    def __init__(self, window: MainUI) -> None:
        self.tab = window.loaded_tab_toolboxes["Parameters"]
        self.model = self.tab.proxyModel

    def _child(self, parent: QModelIndex, name: str) -> QModelIndex:
        rows = (self.model.index(row, 0, parent) for row in range(self.model.rowCount(parent)))
        return next((index for index in rows if index.data() == name), QModelIndex())

    def shown(self, group: str) -> dict[str, str]:
        """Names and values of one group, as the tree shows them."""
        parent = self._child(QModelIndex(), group)
        return {
            self.model.index(row, 0, parent).data(): self.model.index(
                row, VALUE_COLUMN, parent
            ).data()
            for row in range(self.model.rowCount(parent))
        }

    def type_value(self, group: str, name: str, value: str) -> None:
        """Select a parameter in the tree, type a value, press the button."""
        tree = self.tab.paramTree
        index = self._child(self._child(QModelIndex(), group), name)
        tree.expand(index.parent())
        tree.scrollTo(index)
        QTest.mouseClick(
            tree.viewport(), Qt.MouseButton.LeftButton, pos=tree.visualRect(index).center()
        )
        wait_for(f"{name} is selected", lambda: self.tab.paramDetailsLabel.text().endswith(name))
        wait_for("the default value is shown", lambda: self.tab.defaultValue.text() != "-")
        self.tab.currentValue.selectAll()
        QTest.keyClicks(self.tab.currentValue, value)
        click(self.tab.setParamButton)


def watch(window: MainUI) -> dict[str, float]:
    """Keep up to date what the app says about itself."""
    status: dict[str, float] = {}
    block = LogConfig("watch", 100)
    for name in ("way.state", "way.x", "way.y"):
        block.add_variable(name)
    window.cf.log.add_config(block)
    block.data_received_cb.add_callback(lambda time_ms, values, _: status.update(values))
    block.start()
    wait_for("the app's state is logged", lambda: bool(status))
    return status


def found(window: MainUI, uri: str) -> bool:
    """Whether the drone is offered; a scan listens for a moment only, so it is repeated."""
    if window.interfaceCombo.currentText() == uri:
        return True
    if window.scanButton.isEnabled():
        click(window.scanButton)
    return False


def connected(uri: str) -> MainUI:
    """A window that is connected to the drone, with all parameters read."""
    window = MainUI()
    window.show()
    wait_for("the scan finds the drone", lambda: found(window, uri))
    click(window.connectButton)
    wait_for("it is connected", lambda: window.uiState == UIState.CONNECTED)
    wait_for("all parameters are read", lambda: window.cf.param.is_updated)
    return window


def drive(uri: str, goal: tuple[str, str], folder: Path) -> dict[str, object]:
    """Connect, look, fly to the goal, land."""
    window = connected(uri)
    parameters = Parameters(window)
    wait_for("the tree shows values", lambda: all(parameters.shown("way").values()))
    shown = parameters.shown("way")
    window.tab_widget.setCurrentWidget(parameters.tab)
    status = watch(window)
    for name, value in zip(("goalX", "goalY"), goal, strict=True):
        parameters.type_value("way", name, value)
        wait_for(f"{name} is set", lambda n=name, v=value: parameters.shown("way")[n] == v)
    window.grab().save(str(folder / "goal.png"))
    parameters.type_value("way", "cmd", GO_TO)
    wait_for("it takes off", lambda: status["way.state"] != IDLE)
    wait_for("it arrives", lambda: status["way.state"] == HOVER)
    arrived = dict(status)
    window.grab().save(str(folder / "arrived.png"))
    parameters.type_value("way", "cmd", LAND)
    wait_for("it lands", lambda: status["way.state"] == IDLE)
    wait_for("the command reads back as taken", lambda: parameters.shown("way")["cmd"] == "0")
    battery = window._aff_volts.text()
    click(window.connectButton)
    wait_for("it is disconnected", lambda: window.uiState == UIState.DISCONNECTED)
    return {"shown": shown, "arrived": arrived, "battery": battery}


def main() -> None:
    uri, goal_x, goal_y, folder = sys.argv[1:]
    application = QApplication(sys.argv[:1])
    application.setStyle("Fusion")
    try:
        print(json.dumps(drive(uri, (goal_x, goal_y), Path(folder))), flush=True)
        code = 0
    except TimeoutError as error:
        print(f"waited in vain until {error}", file=sys.stderr, flush=True)
        code = 1
    # cflib and cfclient leave threads behind that would keep the process alive.
    os._exit(code)


if __name__ == "__main__":
    main()
