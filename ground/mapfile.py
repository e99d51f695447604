# SPDX-License-Identifier: GPL-3.0-or-later
"""The map in files: written as a picture or as arrays, read from arrays."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from ground.core import CellState
from ground.errors import GroundError
from ground.map import GroundMap
from ground.model import Point

PIXELS_PER_CELL = 6
_GREYS = {CellState.UNKNOWN: 205, CellState.FREE: 254, CellState.OCCUPIED: 0}


def save_map(grid: GroundMap, path: Path) -> None:
    """`.png`: a picture, north up. `.npz`: states, obstacles_m, cell_m, origin_m."""
    match path.suffix.lower():
        case ".png":
            path.write_bytes(_png(_picture(grid)))
        case ".npz":
            origin_m = (grid.origin.x_m, grid.origin.y_m)
            np.savez_compressed(
                path,
                states=grid.states,
                obstacles_m=grid.obstacles_m(),
                cell_m=grid.cell_m,
                origin_m=origin_m,
            )
        case suffix:
            raise GroundError(f"cannot write a map as {suffix or path.name!r}: use .png or .npz")


def load_map(path: Path) -> GroundMap:
    """What save_map wrote as `.npz`."""
    grid = GroundMap()
    try:
        with np.load(path) as kept:
            states, obstacles_m = kept["states"], kept["obstacles_m"]
            cell_m, origin_m = float(kept["cell_m"]), kept["origin_m"].astype(float)
    except (OSError, ValueError, KeyError, BadZipFile) as error:
        raise GroundError(f"{path}: not a map that `wayflie map save` wrote ({error})") from error
    known = np.isin(states, [int(state) for state in CellState])
    if states.shape != grid.states.shape or not known.all() or not 0 < cell_m < np.inf:
        raise GroundError(f"{path}: not a map of {len(grid.states)} x {len(grid.states)} cells")
    grid.cell_m, grid.origin = cell_m, Point(origin_m[0], origin_m[1])
    grid.states[:] = states
    grid.put_points(obstacles_m)
    return grid


def _picture(grid: GroundMap) -> NDArray[np.uint8]:
    shades = np.zeros(len(CellState), np.uint8)
    for state, grey in _GREYS.items():
        shades[state] = grey
    cells = shades[grid.states[::-1]]
    return cells.repeat(PIXELS_PER_CELL, axis=0).repeat(PIXELS_PER_CELL, axis=1)


def _png(grey: NDArray[np.uint8]) -> bytes:
    """A greyscale PNG (W3C PNG, 2003: signature, IHDR, IDAT, IEND; filter 0 in front of a row)."""
    height, width = grey.shape
    rows = np.insert(grey, 0, 0, axis=1).tobytes()
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    check = zlib.crc32(kind + data)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)
