# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes maps of ROS map_server: a PGM image and a YAML file beside it.

A pixel is occupied with p = (255 - value) / 255, or with `negate` value / 255: above
occupied_thresh it is an obstacle, below free_thresh it is free. Row 0 is the farthest in y;
`origin` is the pose of the lower left corner of the lower left pixel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from ground.core import CellState
from ground.errors import GroundError
from ground.map.groundmap import GroundMap
from ground.model import Pose

OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
SHADES = {CellState.UNKNOWN: 205, CellState.FREE: 254, CellState.OCCUPIED: 0}
SAMPLES_LEAST = 3  # along a cell's side, when a map is resampled on the drone's grid
SIDE_PIXELS_MAX = 8192
_NAME_A_MAP = "name the .yaml of a map, or a .npz that `wayflie map save` wrote"


@dataclass(frozen=True, slots=True)
class RosMap:
    """`states` holds CellState, row 0 in the south; `origin` is the lower left corner's pose."""

    states: NDArray[np.uint8]
    resolution_m: float
    origin: Pose


def shades(grid: GroundMap) -> NDArray[np.uint8]:
    """(side, side) grey values, row 0 in the north."""
    table = np.zeros(len(CellState), np.uint8)
    for state, grey in SHADES.items():
        table[state] = grey
    return table[grid.states[::-1]]


def save_ros(grid: GroundMap, path: Path) -> None:
    """Write FILE.yaml with FILE.pgm beside it."""
    image = path.with_suffix(".pgm")
    Image.fromarray(shades(grid)).save(image, format="PPM")
    about = {
        "image": image.name,
        "mode": "trinary",
        "resolution": round(grid.cell_m, 6),
        "origin": [round(grid.origin.x_m, 6), round(grid.origin.y_m, 6), 0.0],
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESH,
        "free_thresh": FREE_THRESH,
    }
    path.write_text(yaml.safe_dump(about, sort_keys=False, default_flow_style=None))


def load_ros(path: Path) -> RosMap:
    """Load what map_server would load, in its trinary mode."""
    try:
        about = yaml.safe_load(path.read_text())
        resolution_m = float(about["resolution"])
        origin = [float(number) for number in about["origin"]]
        with Image.open(path.parent / str(about["image"])) as image:
            if max(image.size) > SIDE_PIXELS_MAX:
                raise GroundError(f"{path}: an image of {image.size} pixels is too large")
            grey = np.asarray(image.convert("L"), float)
        states = _classified(grey, about)
    except (OSError, UnidentifiedImageError, UnicodeDecodeError) as error:
        raise GroundError(f"{path}: {error}") from error
    except (yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        why = " ".join(str(error).split())
        raise GroundError(f"{path} is not a map for ROS map_server ({why})", _NAME_A_MAP) from error
    if not 0 < resolution_m < 10 or len(origin) != 3 or not all(map(math.isfinite, origin)):
        why = "resolution or origin"
        raise GroundError(f"{path} is not a map for ROS map_server ({why})", _NAME_A_MAP)
    return RosMap(states[::-1], resolution_m, Pose(origin[0], origin[1], 0.0, origin[2]))


def _classified(grey: NDArray[np.float64], about: dict[str, Any]) -> NDArray[np.uint8]:
    occupied = grey / 255 if int(about.get("negate", 0)) else 1 - grey / 255
    states = np.full(grey.shape, CellState.UNKNOWN, np.uint8)
    states[occupied < float(about["free_thresh"])] = CellState.FREE
    states[occupied > float(about["occupied_thresh"])] = CellState.OCCUPIED
    return states


def fit(ros: RosMap, drone: GroundMap, stands: Pose | None) -> GroundMap:
    """Resample the map on the drone's grid; its pose `stands` becomes the drone's map origin.

    A cell is occupied if any sample in it is; its point is the mean of the occupied samples.
    """
    grid = GroundMap()
    grid.cell_m, grid.origin = drone.cell_m, drone.origin
    side = len(grid.states)
    samples = max(SAMPLES_LEAST, math.ceil(1.5 * grid.cell_m / ros.resolution_m))
    axis_m = (np.arange(side * samples) + 0.5) * grid.cell_m / samples
    x_m, y_m = np.meshgrid(grid.origin.x_m + axis_m, grid.origin.y_m + axis_m)
    found = _looked_up(ros, *_moved(x_m, y_m, stands))
    cells = found.reshape(side, samples, side, samples)
    occupied = (cells == CellState.OCCUPIED).any(axis=(1, 3))
    free = (cells == CellState.FREE).mean(axis=(1, 3)) >= 0.5
    grid.states[free] = CellState.FREE
    grid.states[occupied] = CellState.OCCUPIED
    if not grid.states.any():
        raise GroundError("nothing of that map lies in the drone's grid: check origin and pose")
    _put_middles(grid, found == CellState.OCCUPIED, x_m, y_m)
    return grid


def _moved(
    x_m: NDArray[np.float64], y_m: NDArray[np.float64], by: Pose | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if by is None:
        return x_m, y_m
    cos, sin = math.cos(by.yaw_rad), math.sin(by.yaw_rad)
    return by.x_m + cos * x_m - sin * y_m, by.y_m + sin * x_m + cos * y_m


def _looked_up(
    ros: RosMap, x_m: NDArray[np.float64], y_m: NDArray[np.float64]
) -> NDArray[np.uint8]:
    """States at these places; unknown outside the map."""
    cos, sin = math.cos(ros.origin.yaw_rad), math.sin(ros.origin.yaw_rad)
    dx_m, dy_m = x_m - ros.origin.x_m, y_m - ros.origin.y_m
    columns = np.floor((cos * dx_m + sin * dy_m) / ros.resolution_m).astype(int)
    rows = np.floor((cos * dy_m - sin * dx_m) / ros.resolution_m).astype(int)
    height, width = ros.states.shape
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    found = np.full(x_m.shape, CellState.UNKNOWN, np.uint8)
    found[inside] = ros.states[rows[inside], columns[inside]]
    return found


def _put_middles(
    grid: GroundMap,
    hit: NDArray[np.bool_],
    x_m: NDArray[np.float64],
    y_m: NDArray[np.float64],
) -> None:
    side = len(grid.states)
    samples = len(hit) // side
    shape = (side, samples, side, samples)
    counts = hit.reshape(shape).sum(axis=(1, 3))
    occupied = counts > 0
    sums = [(hit * axis_m).reshape(shape).sum(axis=(1, 3)) for axis_m in (x_m, y_m)]
    grid.put_points(np.column_stack([total[occupied] / counts[occupied] for total in sums]))
