# SPDX-License-Identifier: GPL-3.0-or-later
"""The map in files: pictures, ROS maps, tables and arrays; read back from arrays and ROS maps."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ground.core import CellState
from ground.errors import BadInput, GroundError
from ground.map import GroundMap
from ground.mapsvg import svg_text
from ground.model import Point
from ground.rosmap import save_ros, shades

PIXELS_PER_CELL = 6
CELL_MIN_M, CELL_MAX_M, FARTHEST_M = 1e-3, 10.0, 1e4
KINDS = (".yaml", ".png", ".svg", ".csv", ".npz")


def check_free(files: Iterable[Path], force: bool) -> None:
    """Nothing is overwritten unasked. Raises GroundError, also for an ending that is unknown."""
    for file in files:
        if file.suffix.lower() not in KINDS:
            raise BadInput(f"cannot write {file.name}", f"use {_listed()}")
        pair = [file, file.with_suffix(".pgm")] if file.suffix == ".yaml" else [file]
        for path in pair:
            if path.exists() and not force:
                raise GroundError(f"{path} exists already", "name another file, or --force")


def save_map(grid: GroundMap, path: Path) -> None:
    """By its ending.

    `.yaml`: with a `.pgm`, for ROS map_server. `.png` and `.svg`: pictures, north up. `.csv`: the
    obstacles, x and y in metres. `.npz`: states, obstacles_m, cell_m, origin_m.
    """
    match path.suffix.lower():
        case ".yaml":
            save_ros(grid, path)
        case ".png":
            Image.fromarray(_enlarged(shades(grid))).save(path)
        case ".svg":
            path.write_text(svg_text(grid))
        case ".csv":
            save_table(path, ("x_m", "y_m"), grid.obstacles_m().tolist())
        case ".npz":
            _save_arrays(grid, path)
        case suffix:
            raise BadInput(f"cannot write a map as {suffix or path.name!r}", f"use {_listed()}")


def save_table(path: Path, names: Iterable[str], rows: Iterable[Iterable[float]]) -> None:
    """A CSV file: a line of names, then numbers with six digits."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([f"{value:.6g}" for value in row] for row in rows)


def load_map(path: Path) -> GroundMap:
    """What save_map wrote as `.npz`."""
    grid = GroundMap()
    try:
        with path.open("rb") as file, np.load(file) as kept:
            states, obstacles_m = kept["states"], kept["obstacles_m"]
            origin_m, cell_m = kept["origin_m"], float(kept["cell_m"])
    except Exception as error:  # zipfile, zlib and numpy raise many kinds for a damaged file
        raise GroundError(f"{path}: not a map that `wayflie map save` wrote ({error})") from error
    whole = states.shape == grid.states.shape and states.dtype.kind in "iu"
    if not whole or not np.isin(states, [int(state) for state in CellState]).all():
        raise GroundError(f"{path}: not a map of {len(grid.states)} x {len(grid.states)} cells")
    if not (_are_places(origin_m, (2,)) and _are_places(obstacles_m, (obstacles_m.size // 2, 2))):
        raise GroundError(f"{path}: its origin or its obstacles are no places")
    if not CELL_MIN_M <= cell_m <= CELL_MAX_M:
        raise GroundError(f"{path}: cells of {cell_m} m")
    grid.cell_m, grid.origin = cell_m, Point(origin_m[0], origin_m[1])
    grid.states[:] = states
    grid.put_points(obstacles_m)
    return grid


def _are_places(values: NDArray[Any], shape: tuple[int, ...]) -> bool:
    if values.shape != shape or values.dtype.kind != "f":
        return False
    return bool((np.abs(values) < FARTHEST_M).all())


def _save_arrays(grid: GroundMap, path: Path) -> None:
    np.savez_compressed(
        path,
        states=grid.states,
        obstacles_m=grid.obstacles_m(),
        cell_m=grid.cell_m,
        origin_m=(grid.origin.x_m, grid.origin.y_m),
    )


def _enlarged(cells: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return cells.repeat(PIXELS_PER_CELL, axis=0).repeat(PIXELS_PER_CELL, axis=1)


def _listed() -> str:
    return f"{', '.join(KINDS[:-1])} or {KINDS[-1]}"
