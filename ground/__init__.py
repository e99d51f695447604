# SPDX-License-Identifier: GPL-3.0-or-later
"""Wayflie's ground station; scripts use `from ground import Station` (see ground/api.py).

The names below are imported on first use, so that building the C core can import this package.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ground.api import Station
    from ground.errors import CommandRefused, GroundError, NotReached
    from ground.model import Point, Pose

__all__ = ["CommandRefused", "GroundError", "NotReached", "Point", "Pose", "Station", "__version__"]
__version__ = "0.1.0"

_MODULES = {
    "CommandRefused": "ground.errors",
    "GroundError": "ground.errors",
    "NotReached": "ground.errors",
    "Point": "ground.model",
    "Pose": "ground.model",
    "Station": "ground.api",
}


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)
