# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a parameter and checks what the drone made of it."""

from __future__ import annotations

import math
import time

from ground.docparams import Variable, parameters
from ground.errors import ParameterRefused
from ground.model import Console, ParameterValue
from ground.station.station import Station

SETTLING_S = 0.3  # within its next ticks the app restores a value that it refuses
TOLERANCE = 1.0e-5  # relative precision of a 32-bit float, with some room


async def tune(station: Station, name: str, value: float) -> float:
    """Set a parameter of group way. @return its new value. Raises ParameterRefused, NoAnswer."""
    variable = parameters().get(name.removeprefix("way."))
    if variable is None or not name.startswith("way."):
        raise ParameterRefused(f"the drone has no parameter {name}")
    _check(variable, value)
    with station.listen(ParameterValue, Console) as listener:
        now = await station.set_parameter(name, value)
        until_s, reason = time.monotonic() + SETTLING_S, ""
        while (left_s := until_s - time.monotonic()) > 0:
            match await listener.next(left_s):
                case ParameterValue(given, told) if given == name:
                    now = told
                case Console(text) if name in text:
                    reason = text.strip().rpartition(": ")[2]
    if not math.isclose(now, value, rel_tol=TOLERANCE, abs_tol=TOLERANCE):
        raise ParameterRefused(f"{name} stays {now:g}: {reason or 'the drone refused the value'}")
    return now


def _check(variable: Variable, value: float) -> None:
    """Refuse at once what the drone would refuse."""
    low, high = variable.low, variable.high
    whole = variable.type == "float" or value == int(value)
    if not (low is None or high is None or low <= value <= high) or not whole:
        words = ", ".join(f"{n} {word}" for n, word in enumerate(variable.choices))
        raise ParameterRefused(f"way.{variable.name}: {words or variable.range_words}")
