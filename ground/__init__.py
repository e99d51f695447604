# SPDX-License-Identifier: GPL-3.0-or-later
"""Wayflie's ground station. For scripts: `from ground import Station`, told in ground/api.py.

The names below are imported when they are asked for: what builds the C core imports this package.
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
