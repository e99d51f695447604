# SPDX-License-Identifier: GPL-3.0-or-later
"""How the drone and the link to it are doing, in numbers."""

from __future__ import annotations

import math
import time
from typing import Any

from ground.station.picture import Picture
from ground.web.cockpit import Cockpit


def status(cockpit: Cockpit, picture: Picture) -> dict[str, Any]:
    """All of it; what is not known is left out."""
    found: dict[str, Any] = {"correction": _correction(picture)}
    if (station := cockpit.station) is not None:
        cockpit.rate.look(station.stats, time.monotonic())
        found["rate_hz"] = round(cockpit.rate.per_s, 1)
        found["loss"] = round(cockpit.rate.loss, 4)
        found["round_trip_ms"] = station.pulse.round_trip_ms
        found["unanswered"] = station.pulse.unanswered
    ages_s = picture.map.tile_ages_s(time.monotonic())
    heard = [float(age_s) for age_s in ages_s if math.isfinite(age_s)]
    found["map_age_s"] = round(max(heard), 1) if heard else None
    if picture.telemetry is not None:
        found["confidence"] = picture.telemetry.confidence_percent
    if (health := picture.health) is not None:
        found["tick_us"] = health.tick_us
        found["plan_us"] = health.plan_us
    return found


def _correction(picture: Picture) -> dict[str, float] | None:
    """When SLAM moved the drone in its map last, and how far."""
    last, telemetry = picture.trail.last_correction, picture.telemetry
    if last is None or telemetry is None:
        return None
    x_m, y_m = telemetry.pose.x_m - last.x_m, telemetry.pose.y_m - last.y_m
    cosine, sine = math.cos(last.yaw_rad), math.sin(last.yaw_rad)
    before = (cosine * x_m + sine * y_m, cosine * y_m - sine * x_m)
    return {
        "ago_s": round(max(0, picture.drone_ms - last.drone_ms) / 1000, 1),
        "moved_m": round(
            math.hypot(telemetry.pose.x_m - before[0], telemetry.pose.y_m - before[1]), 4
        ),
        "turned_deg": round(math.degrees(last.yaw_rad), 3),
    }
