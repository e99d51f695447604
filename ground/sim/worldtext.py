# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a WorldSpec as a world file, which worldfile.py reads back as the same world."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from typing import Final

from ground.sim.worldspec import Motion, Obstacle, Patch, WorldSpec

_CEILING: Final = "ceiling"

Value = str | float | bool | tuple[float, float] | tuple[tuple[float, float], ...]


def world_text(spec: WorldSpec) -> str:
    """The TOML text of a world."""
    lines = [f"title = {_toml(spec.title)}"]
    lids = [obstacle for obstacle in spec.obstacles if obstacle.name == _CEILING]
    if lids:
        lines.append(f"ceiling_m = {_toml(lids[0].bottom_m)}")
    start = {"x_m": spec.start_m[0], "y_m": spec.start_m[1]}
    lines += _table("[start]", {**start, "yaw_deg": math.degrees(spec.start_yaw_rad)})
    lines += _table("[floor]", {"quality": spec.floor_quality})
    for patch in spec.patches:
        lines += _table("[[floor.patch]]", _patch(patch))
    for obstacle in spec.obstacles:
        if obstacle.name != _CEILING:
            lines += _obstacle(obstacle)
    if spec.eeprom:
        lines += _table("[eeprom]", {json.dumps(name): v for name, v in spec.eeprom.items()})
    if spec.demo_goal_m is not None:
        lines += _table("[demo]", {"goal": spec.demo_goal_m})
    return "\n".join(lines) + "\n"


def _patch(patch: Patch) -> dict[str, Value]:
    return {"from": patch.low_m, "to": patch.high_m, "quality": patch.quality}


def _obstacle(obstacle: Obstacle) -> Iterator[str]:
    values: dict[str, Value] = {"name": obstacle.name, "center": obstacle.center_m}
    if obstacle.radius_m > 0:
        kind = "disc"
        values["radius_m"] = obstacle.radius_m
    else:
        kind = "box"
        values["size"] = (2 * obstacle.half_m[0], 2 * obstacle.half_m[1])
        values["yaw_deg"] = math.degrees(math.remainder(obstacle.yaw_rad, math.tau))
    values["bottom_m"] = obstacle.bottom_m
    values["height_m"] = obstacle.top_m - obstacle.bottom_m
    values["reflectivity"] = obstacle.reflectivity
    values["appears_s"] = obstacle.appears_s
    if math.isfinite(obstacle.vanishes_s):
        values["vanishes_s"] = obstacle.vanishes_s
    yield from _table(f"[[{kind}]]", values)
    if obstacle.motion is not None:
        yield from _motion(kind, obstacle.motion)


def _motion(kind: str, motion: Motion) -> Iterator[str]:
    values: dict[str, Value] = {
        "path": motion.path_m,
        "speed_mps": motion.speed_mps,
        "start_s": motion.start_s,
        "loop": motion.loop,
        "pause_s": motion.pause_s,
    }
    yield from _table(f"[{kind}.motion]", values)
    if motion.trigger is not None:
        near: dict[str, Value] = {
            "center": motion.trigger.center_m,
            "radius_m": motion.trigger.radius_m,
        }
        yield from _table(f"[{kind}.motion.when_near]", near)


def _table(head: str, values: Mapping[str, Value]) -> list[str]:
    return ["", head, *(f"{name} = {_toml(value)}" for name, value in values.items())]


def _toml(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, tuple):
        return "[" + ", ".join(_toml(part) for part in value) + "]"
    return repr(float(value))
