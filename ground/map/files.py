# SPDX-License-Identifier: GPL-3.0-or-later
"""Map files: writes images, ROS maps, tables and arrays; reads arrays (ROS maps: ros.py)."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ground.core import CellState
from ground.errors import BadInput, GroundError
from ground.map.groundmap import GroundMap
from ground.map.ros import save_ros, shades
from ground.map.svg import svg_text
from ground.model import Point

PIXELS_PER_CELL = 6
CELL_MIN_M, CELL_MAX_M, FARTHEST_M = 1e-3, 10.0, 1e4


def check_free(file: Path, force: bool) -> None:
    """Check that a map can be saved there; only `force` permits replacement. Raises GroundError."""
    _writer(file)
    check_file(file, force)
    if file.suffix.lower() == ".yaml":
        check_file(file.with_suffix(".pgm"), force)


def check_file(file: Path, force: bool) -> None:
    """Check that the folder exists and the file does not, unless `force`. Raises GroundError."""
    if not file.absolute().parent.is_dir():
        raise BadInput(f"there is no folder {file.absolute().parent}", "make it first")
    if file.exists() and not force:
        raise GroundError(f"{file} exists already", "name another file, or --force")


def save_map(grid: GroundMap, path: Path) -> None:
    """Write a map in the format that the file name's ending selects.

    `.yaml`: with a `.pgm`, for ROS map_server. `.png` and `.svg`: images, north up. `.csv`: the
    obstacles, x and y in metres. `.npz`: states, obstacles_m, cell_m, origin_m.
    """
    _writer(path)(grid, path)


def save_table(path: Path, names: Iterable[str], rows: Iterable[Iterable[float]]) -> None:
    """Write a CSV file: a line of names, then numbers with six digits."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([f"{value:.6g}" for value in row] for row in rows)


def load_map(path: Path) -> GroundMap:
    """Read a `.npz` that save_map() wrote."""
    grid = GroundMap()
    try:
        with path.open("rb") as file, np.load(file) as kept:
            states, obstacles_m = kept["states"], kept["obstacles_m"]
            origin_m, cell_m = kept["origin_m"], float(kept["cell_m"])
    except OSError as error:
        raise GroundError(f"cannot read {path}: {error.strerror}") from error
    except Exception as error:  # zipfile, zlib and numpy raise various errors for a damaged file
        raise GroundError(f"{path}: not a map that `wayflie map save` wrote ({error})") from error
    whole = states.shape == grid.states.shape and states.dtype.kind in "iu"
    if not whole or not np.isin(states, [int(state) for state in CellState]).all():
        raise GroundError(f"{path}: not a map of {len(grid.states)} x {len(grid.states)} cells")
    if not (_are_places(origin_m, (2,)) and _are_places(obstacles_m, (obstacles_m.size // 2, 2))):
        raise GroundError(f"{path}: its origin or obstacles are not valid positions")
    if not CELL_MIN_M <= cell_m <= CELL_MAX_M:
        raise GroundError(f"{path}: not a valid cell size: {cell_m} m")
    grid.cell_m, grid.origin = cell_m, Point(origin_m[0], origin_m[1])
    grid.states[:] = states
    grid.put_points(obstacles_m)
    return grid


def _are_places(values: NDArray[Any], shape: tuple[int, ...]) -> bool:
    if values.shape != shape or values.dtype.kind != "f":
        return False
    return bool((np.abs(values) < FARTHEST_M).all())


def _save_picture(grid: GroundMap, path: Path) -> None:
    enlarged = shades(grid).repeat(PIXELS_PER_CELL, axis=0).repeat(PIXELS_PER_CELL, axis=1)
    Image.fromarray(enlarged).save(path)


def _save_svg(grid: GroundMap, path: Path) -> None:
    path.write_text(svg_text(grid))


def _save_obstacles(grid: GroundMap, path: Path) -> None:
    save_table(path, ("x_m", "y_m"), grid.obstacles_m().tolist())


def _save_arrays(grid: GroundMap, path: Path) -> None:
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            states=grid.states,
            obstacles_m=grid.obstacles_m(),
            cell_m=grid.cell_m,
            origin_m=(grid.origin.x_m, grid.origin.y_m),
        )


_WRITERS: dict[str, Callable[[GroundMap, Path], None]] = {
    ".yaml": save_ros,
    ".png": _save_picture,
    ".svg": _save_svg,
    ".csv": _save_obstacles,
    ".npz": _save_arrays,
}


def _writer(path: Path) -> Callable[[GroundMap, Path], None]:
    if (suffix := path.suffix.lower()) not in _WRITERS:
        *first, last = _WRITERS
        raise BadInput(f"cannot write a map as {path.name}", f"use {', '.join(first)} or {last}")
    return _WRITERS[suffix]
