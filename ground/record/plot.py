# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots a recorded flight: its map (over the truth, if known), paths, errors, planning times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from ground.core import CellState, MissionState
from ground.errors import BadInput, GroundError
from ground.map.files import check_file
from ground.model import Health, Odometry, Telemetry
from ground.record.reader import Sent, read_session
from ground.station.picture import Picture

Array = NDArray[np.float64]
DPI = 120
KINDS = (".png", ".svg", ".pdf")
SHADES = {CellState.UNKNOWN: 0.88, CellState.FREE: 1.0, CellState.OCCUPIED: 0.62}


@dataclass(frozen=True, slots=True)
class Truth:
    """Map frame: outlines of obstacles, and (n, 4) rows of time [s], x, y [m], yaw [rad]."""

    outlines: list[Array]
    trail: Array


@dataclass(frozen=True, slots=True)
class Flight:
    """The contents of a recording; pose and odometry are (n, 4) as Truth.trail.

    The others are (n, 2), a time and a value: `planning` [s], how long the drone waited for a path;
    `computing` [ms], the planner's own time, none in a simulator; `confidence` [%] of the pose.
    """

    picture: Picture
    pose: Array
    odometry: Array
    planning: Array
    computing: Array
    confidence: Array


def plot_flight(file: Path, image: Path, truth: Truth | None, force: bool, out: Console) -> bool:
    """Draw the flight into an image file."""
    if image.suffix.lower() not in KINDS:
        raise BadInput(f"cannot draw into {image.name}", "use .png, .svg or .pdf")
    check_file(image, force)
    draw(read_flight(file), truth, file.stem).savefig(image, dpi=DPI)
    out.print(f"{image}")
    return True


def read_flight(file: Path) -> Flight:
    """Read what is drawn; odometry from before the first take-off is left out."""
    picture = Picture()
    pose: list[tuple[float, ...]] = []
    odometry: list[tuple[float, ...]] = []
    computing: list[tuple[float, ...]] = []
    told: list[Telemetry] = []
    for word in read_session(file):
        if isinstance(word, Sent):
            continue
        picture.take(word.message, word.time_s)
        match word.message:
            case Telemetry(ms, at, _, state) if state.airborne:
                pose.append((ms / 1000, at.x_m, at.y_m, at.yaw_rad))
                told.append(word.message)
            case Odometry(ms, at) if pose:
                odometry.append((ms / 1000, at.x_m, at.y_m, at.yaw_rad))
            case Health() if word.message.plan_us:
                plan = (word.message.drone_ms / 1000, word.message.plan_us / 1000)
                if not computing or computing[-1][1] != plan[1]:
                    computing.append(plan)
    if not pose:
        raise GroundError(f"{file}: nothing flies in this recording")
    flown = np.array(pose)
    return Flight(
        picture,
        flown,
        _laid_on(_table(odometry, 4), flown[0]),
        _planning(told),
        _table(computing, 2),
        _table([(t.drone_ms / 1000, t.confidence_percent) for t in told], 2),
    )


def _planning(told: Sequence[Telemetry]) -> Array:
    """When each planning began, and how long it took [s]."""
    rows: list[tuple[float, ...]] = []
    begin_s: float | None = None
    for telemetry in told:
        now_s = telemetry.drone_ms / 1000
        if telemetry.state is MissionState.PLAN:
            begin_s = now_s if begin_s is None else begin_s
        elif begin_s is not None:
            rows.append((begin_s, now_s - begin_s))
            begin_s = None
    return _table(rows, 2)


def _table(rows: Sequence[tuple[float, ...]], columns: int) -> Array:
    return np.array(rows, float).reshape(-1, columns)


def _laid_on(way: Array, begin: Array) -> Array:
    """Rotate and shift a path to begin at this pose, since odometry has its own frame."""
    if not len(way):
        return way
    turn = begin[3] - way[0, 3]
    cos, sin = np.cos(turn), np.sin(turn)
    x, y = (way[:, 1:3] - way[0, 1:3]).T
    moved = way.copy()
    moved[:, 1] = begin[1] + cos * x - sin * y
    moved[:, 2] = begin[2] + sin * x + cos * y
    moved[:, 3] += turn
    return moved


def draw(flight: Flight, truth: Truth | None, title: str) -> Any:  # noqa: ANN401
    """Draw a matplotlib figure."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise GroundError(
            f"plotting needs matplotlib ({error})", "pip install 'wayflie[plot]'"
        ) from error
    figure = Figure((13, 7.5), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.6, 1))
    _draw_map(figure.add_subplot(grid[:, 0]), flight, truth, title)
    errors = figure.add_subplot(grid[0, 1])
    _draw_errors(errors, flight, truth)
    plans = figure.add_subplot(grid[1, 1], sharex=errors)
    if len(flight.computing):
        plans.plot(*flight.computing.T, "o", color="tab:blue")
        plans.set(ylabel="planner's time [ms]")
    else:
        plans.plot(*flight.planning.T, "o", color="tab:blue")
        plans.set(ylabel="wait for a path [s]")
    plans.set_ylim(bottom=0)
    sure = figure.add_subplot(grid[2, 1], sharex=errors)
    sure.plot(*flight.confidence.T, color="tab:blue")
    sure.set(ylabel="confidence [%]", xlabel="drone time [s]", ylim=(0, 105))
    return figure


def _draw_map(axes: Any, flight: Flight, truth: Truth | None, title: str) -> None:  # noqa: ANN401
    grid = flight.picture.map
    low, side_m = grid.origin, len(grid.states) * grid.cell_m
    shades = np.array([SHADES[CellState(state)] for state in range(len(CellState))])
    axes.imshow(
        shades[grid.states], cmap="gray", vmin=0, vmax=1, origin="lower", zorder=0,
        extent=(low.x_m, low.x_m + side_m, low.y_m, low.y_m + side_m),
    )  # fmt: skip
    for number, outline in enumerate(truth.outlines if truth else ()):
        label = "truth" if number == 0 else None
        axes.fill(*outline.T, color="tab:orange", alpha=0.35, linewidth=0, label=label)
    axes.plot(*grid.obstacles_m().T, ".", color="black", markersize=2, label="mapped obstacles")
    if truth is not None and len(truth.trail):
        axes.plot(*truth.trail[:, 1:3].T, color="tab:orange", label="true path")
    axes.plot(*flight.odometry[:, 1:3].T, "--", color="tab:gray", linewidth=1, label="odometry")
    axes.plot(*flight.pose[:, 1:3].T, color="tab:blue", label="pose in its map")
    rows, columns = np.nonzero(grid.states)
    if len(rows):
        axes.set_xlim(
            *(low.x_m + grid.cell_m * (columns.min() - 4, columns.max() + 5)[i] for i in (0, 1))
        )
        axes.set_ylim(
            *(low.y_m + grid.cell_m * (rows.min() - 4, rows.max() + 5)[i] for i in (0, 1))
        )
    axes.set(title=title, xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axes.legend(loc="best", fontsize="small")


def _draw_errors(axes: Any, flight: Flight, truth: Truth | None) -> None:  # noqa: ANN401
    """Plot the error against the truth or, without it, the distance of pose and odometry."""
    if truth is None or not len(truth.trail):
        axes.plot(flight.pose[:, 0], _apart_m(flight.pose, flight.odometry), color="tab:blue")
        axes.set(ylabel="corrected by [m]")
        return
    for way, name, color in (
        (flight.odometry, "odometry", "tab:gray"),
        (flight.pose, "pose in its map", "tab:blue"),
    ):
        axes.plot(way[:, 0], _apart_m(way, truth.trail), color=color, label=name)
    axes.set(ylabel="error [m]")
    axes.legend(fontsize="small")


def _apart_m(way: Array, other: Array) -> Array:
    """Distance of the second path from the first, at the times of the first."""
    if not len(other):
        return np.full(len(way), np.nan)
    x, y = (np.interp(way[:, 0], other[:, 0], other[:, axis]) for axis in (1, 2))
    apart: Array = np.hypot(way[:, 1] - x, way[:, 2] - y)
    return apart
