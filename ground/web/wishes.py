# SPDX-License-Identifier: GPL-3.0-or-later
"""What a page may wish for, and what of it makes sense: from JSON to the cockpit."""

from __future__ import annotations

import contextlib
import math
from typing import Any

from ground.errors import GroundError
from ground.model import Point
from ground.requests import Stick
from ground.web.cockpit import Cockpit, Timeline


async def perform(cockpit: Cockpit, wish: dict[str, Any]) -> None:
    """Do as a page wishes. Raises a GroundError with the sentence to show."""
    match wish:
        case {"do": "fly" | "patrol" as name}:
            await cockpit.fly_along(name, _points(wish.get("points")))
        case {"do": "area"}:
            x0_m, y0_m, x1_m, y1_m = (_number(wish.get(key), key) for key in AREA_KEYS)
            await cockpit.set_area(Point(x0_m, y0_m), Point(x1_m, y1_m))
        case {"do": "spin", "turns": turns}:
            await cockpit.spin(_number(turns, "turns"))
        case {"do": "set", "name": str(name), "value": value}:
            await cockpit.set_parameter(name, _number(value, name))
        case {"do": str(name)}:
            await cockpit.command(name, _goal(wish))


def stick_of(wish: dict[str, Any]) -> Stick:
    """Of a wish `manual`: m/s, degrees and m a second. Raises a GroundError."""
    vx, vy, yaw, up = (_number(wish.get(key, 0.0), key) for key in ("vx", "vy", "yaw", "up"))
    return Stick(vx, vy, math.radians(yaw), up)


AREA_KEYS = ("x0", "y0", "x1", "y1")


def wind(line: Timeline, wish: dict[str, Any]) -> None:
    """Play, pause or seek, as a page wishes; what makes no sense does nothing."""
    match wish:
        case {"do": "play"}:
            line.play()
        case {"do": "pause"}:
            line.pause()
        case {"do": "seek", "s": int() | float() as time_s} if math.isfinite(time_s):
            line.seek(float(time_s))


def _goal(wish: dict[str, Any]) -> Point | None:
    with contextlib.suppress(GroundError):
        return Point(_number(wish.get("x"), "x"), _number(wish.get("y"), "y"))
    return None


def _points(given: object) -> list[Point]:
    if not isinstance(given, list):
        raise GroundError("waypoints are pairs of numbers")
    points = []
    for pair in given:
        if not (isinstance(pair, list) and len(pair) == 2):
            raise GroundError("waypoints are pairs of numbers")
        points.append(Point(_number(pair[0], "x"), _number(pair[1], "y")))
    return points


def _number(value: object, name: str) -> float:
    """A finite number; JSON knows no largest one, and Python reads NaN."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        with contextlib.suppress(OverflowError):
            if math.isfinite(number := float(value)):
                return number
    raise GroundError(f"{name}: not a number")
