# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters of a drone as pages show them: what they are, and what they may be."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from ground.docparams import Variable, parameters
from ground.web.cockpit import AREA, Cockpit

GROUPS = {
    "Flying": ("height", "speed", "clearance", "yawMode", "yawRate", "turns"),
    "Looking": ("lookAge", "lookWidth", "watch", "yield"),
    "Area": ("areaX0", "areaY0", "areaX1", "areaY1"),
    "Finding the way": ("planner", "slam", "frontier", "cell"),
    "When something is wrong": ("lost", "lostTime", "lowBat", "selftest"),
}


def parameters_version(cockpit: Cockpit) -> object:
    """Differs whenever a value has changed."""
    return dict(cockpit.station.picture.parameters) if cockpit.station else None


def parameters_frame(cockpit: Cockpit) -> str:
    """JSON of all that can be tuned, group by group."""
    known = cockpit.station.picture.parameters if cockpit.station else {}
    table = parameters()
    rows = [
        _row(group, table[name], known)
        for group, names in GROUPS.items()
        for name in names
        if f"way.{name}" in known
    ]
    return json.dumps({"kind": "parameters", "rows": rows}, allow_nan=False)


def area_of(values: Mapping[str, float]) -> list[float] | None:
    """The fence, as far as it is known: x0, y0, x1, y1."""
    return [values[name] for name in AREA] if all(name in values for name in AREA) else None


def alone(values: Mapping[str, float]) -> str:
    """What the drone does when it hears nobody, as far as it is known."""
    if not {"way.lost", "way.lostTime"} <= values.keys():
        return ""
    what = parameters()["lost"].choices[int(values["way.lost"])]
    return f"after {values['way.lostTime']:g} s without a ground station it will {what}"


def _row(group: str, variable: Variable, known: Mapping[str, float]) -> dict[str, Any]:
    return {
        "group": group,
        "name": f"way.{variable.name}",
        "type": variable.type,
        "min": variable.low,
        "max": variable.high,
        "default": variable.default,
        "value": _shown(known[f"way.{variable.name}"]),
        "unit": variable.unit,
        "choices": variable.choices,
        "help": variable.help,
    }


def _shown(value: float) -> float:
    """Without what a float of 32 bits adds to a decimal number."""
    return float(f"{value:.7g}")
