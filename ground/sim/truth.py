# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth of a simulated flight in the drone's map frame, to draw over its map."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ground.errors import GroundError
from ground.record.plot import Truth
from ground.sim.world import World, load_world
from ground.sim.worldspec import Obstacle

_FLIGHT_M: Final = 0.44
_DISC_CORNERS: Final = 24


def read_truth(world: str, flown: Path | None) -> Truth:
    """Read the truth from a world, or from a file that `wayflie sim --trail --json` wrote."""
    figures = {}
    if flown:
        try:
            figures = json.loads(flown.read_text())
            world = world or figures["world"]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise GroundError(f"{flown}: not what `wayflie sim --json` wrote ({error})") from error
    room = load_world(world)
    trail = np.array(figures.get("trail", ()), float).reshape(-1, 5)
    outlines = [
        np.column_stack(room.to_map(*_corners_m(obstacle).T))
        for obstacle in room.spec.obstacles
        if obstacle.bottom_m < _FLIGHT_M < obstacle.top_m
    ]
    return Truth(outlines, _in_map(room, trail))


def _in_map(room: World, trail: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert rows of time, x, y, z, yaw in the world to time, x, y, yaw in the map frame."""
    x_m, y_m = room.to_map(trail[:, 1], trail[:, 2])
    return np.column_stack([trail[:, 0], x_m, y_m, trail[:, 4] - room.spec.start_yaw_rad])


def _corners_m(obstacle: Obstacle) -> NDArray[np.float64]:
    if obstacle.radius_m > 0:
        turns = np.linspace(0, math.tau, _DISC_CORNERS, endpoint=False)
        corners = obstacle.radius_m * np.column_stack([np.cos(turns), np.sin(turns)])
    else:
        wide, deep = obstacle.half_m
        corners = np.array([(wide, deep), (-wide, deep), (-wide, -deep), (wide, -deep)])
        cos, sin = math.cos(obstacle.yaw_rad), math.sin(obstacle.yaw_rad)
        corners = corners @ np.array([(cos, sin), (-sin, cos)])
    return np.asarray(corners + np.array(obstacle.center_m), float)
