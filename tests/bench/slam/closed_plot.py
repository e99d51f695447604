# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of closed-loop flights: truth, estimate and map, and the error over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ground.sim.footprints import Array
from ground.sim.world import World, load_world
from tests.bench.slam.closed_loop import Flown

_FLIGHT_M = 0.4


def _outline(world: World, row: int) -> Array:
    """Corners of an obstacle, in the map frame."""
    obstacle = world.spec.obstacles[row]
    turn = np.linspace(0.0, 2 * np.pi, 33)
    if obstacle.radius_m > 0:
        corners = obstacle.radius_m * np.column_stack([np.cos(turn), np.sin(turn)])
    else:
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * obstacle.half_m
    c, s = np.cos(obstacle.yaw_rad), np.sin(obstacle.yaw_rad)
    x_m, y_m = (corners @ np.array([[c, s], [-s, c]]) + obstacle.center_m).T
    return np.column_stack(world.to_map(x_m, y_m))


def _draw_room(panel: Axes, flown: Flown, world: World) -> None:
    places = world.footprints
    for row in np.flatnonzero((places.bottom_m < _FLIGHT_M) & (places.top_m > _FLIGHT_M)):
        panel.fill(*_outline(world, int(row)).T, color="0.88", zorder=0)
    panel.plot(*flown.grid.obstacles_m().T, "k.", markersize=1.5, label="its map")
    panel.plot(*flown.true[:, 1:].T, color="tab:green", linewidth=0.7, label="truth")
    panel.plot(*flown.believed[:, 1:].T, color="tab:red", linewidth=0.7, label="belief")
    panel.set_aspect("equal")
    there = f"{flown.truly_there} of {len(flown.legs)} goals, {len(flown.touches)} touches"
    panel.set_title(f"seed {flown.plan.seed}: {there}")


def plot_flights(flights: Sequence[Flown], path: Path) -> None:
    """Plot the flights, one column each."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(
        2,
        len(flights),
        figsize=(5.2 * len(flights), 8.0),
        squeeze=False,
        layout="constrained",
        height_ratios=(3, 1),
    )
    for flown, room, errors in zip(flights, *axes, strict=True):
        _draw_room(room, flown, load_world(flown.plan.world))
        errors.plot(flown.believed[:, 0], flown.errors_m, linewidth=0.8)
        errors.set(xlabel="s", ylabel="error of the pose [m]", ylim=(0, None))
        errors.grid(alpha=0.3)
    axes[0, 0].legend(loc="lower left", fontsize=8)
    figure.savefig(path, dpi=90)
    plt.close(figure)
