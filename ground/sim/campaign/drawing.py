# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawings of a campaign: one flight in its world, or all results."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from ground.errors import GroundError
from ground.sim.campaign.flights import Flight
from ground.sim.campaign.rows import Row
from ground.sim.worldspec import Obstacle

_FLIGHT_M: Final = 0.44
_DPI: Final = 120


def draw_flight(flight: Flight, path: Path) -> None:
    """Draw the world from above, the true and the estimated path, and the drone's map."""
    figure = _figure(7, 7)
    axes = figure.add_subplot()
    for obstacle in flight.spec.obstacles:
        if obstacle.bottom_m < 1.0:
            axes.add_patch(_outline(obstacle))
    if flight.way_m:
        axes.plot(*zip(*flight.way_m, strict=True), ":", color="tab:green", label="shortest path")
    axes.plot(flight.trail[:, 1], flight.trail[:, 2], color="tab:blue", label="flown")
    axes.plot(*flight.believed_m.T, "--", color="tab:cyan", linewidth=0.8, label="estimated")
    axes.plot(*flight.drawn_m.T, ".", color="tab:purple", markersize=2, label="its map")
    axes.plot(*flight.spec.start_m, "o", color="tab:blue")
    if flight.goal_m is not None:
        axes.plot(*flight.goal_m, "*", color="tab:red", markersize=12, label="goal")
    axes.plot(*flight.contacts_m.T, "x", color="tab:red", markersize=10)
    axes.set_title(f"{flight.row.style} {flight.row.task}: {flight.row.cause or flight.row.reason}")
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.legend(loc="upper right")
    figure.savefig(path, dpi=_DPI)


def draw_results(rows: Sequence[Row], path: Path) -> None:
    """Draw three diagrams: causes of failure, path lengths, and coverage or misses."""
    figure = _figure(13, 4)
    left, middle, right = figure.subplots(1, 3)
    causes = Counter(row.cause or "succeeded" for row in rows).most_common()
    left.barh([name for name, _ in causes], [count for _, count in causes])
    left.set_title(f"{len(rows)} missions")
    both = [(row.shortest_m, row.flown_m) for row in rows if row.shortest_m and row.flown_m]
    if both:
        middle.plot(*zip(*both, strict=True), ".")
        most = max(shortest for shortest, _ in both)
        middle.plot([0, most], [0, most], color="gray")
        middle.set(xlabel="shortest path [m]", ylabel="flown [m]")
    covered = [row.covered for row in rows if row.covered is not None]
    misses = [row.miss_m for row in rows if row.miss_m is not None and row.outcome == "arrived"]
    right.hist(covered or misses, bins=30)
    right.set_xlabel("share of the reachable area known" if covered else "true miss [m]")
    figure.savefig(path, dpi=_DPI)


def _figure(wide: float, high: float) -> Any:  # noqa: ANN401  matplotlib has no types here
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise GroundError(
            f"--plot needs matplotlib ({error})", "pip install 'wayflie[plot]'"
        ) from error
    return Figure((wide, high), layout="constrained")


def _outline(obstacle: Obstacle) -> Any:  # noqa: ANN401  likewise
    from matplotlib.patches import Circle, Rectangle

    color = "0.35" if obstacle.top_m > _FLIGHT_M else "0.8"
    if obstacle.changes:
        color = "tab:orange"
    if obstacle.radius_m > 0:
        return Circle(obstacle.center_m, obstacle.radius_m, color=color)
    wide, deep = (2 * half for half in obstacle.half_m)
    corner = (obstacle.center_m[0] - wide / 2, obstacle.center_m[1] - deep / 2)
    turn = math.degrees(obstacle.yaw_rad)
    return Rectangle(corner, wide, deep, angle=turn, rotation_point="center", color=color)
