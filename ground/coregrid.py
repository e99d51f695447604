# SPDX-License-Identifier: GPL-3.0-or-later
"""Fills a grid of the C core with given contents."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ground.core import GRID_SIDE_CELLS, CData, CellState, ffi, lib
from ground.model import Point

VALUE_OF = np.array(
    [
        {CellState.FREE: lib.GRID_FREE_MIN, CellState.OCCUPIED: lib.GRID_VALUE_MAX}.get(state, 0)
        for state in CellState
    ],
    np.uint8,
)


def put_values(grid: CData, values: NDArray[np.uint8]) -> None:
    """Set the cells to these values, 0 to 15; (side, side), row 0 in the south."""
    packed = (values[:, 0::2] | values[:, 1::2] << 4).tobytes()
    ffi.memmove(grid.cells, packed, len(packed))


def lay_out(grid: CData, states: NDArray[np.uint8], origin: Point, cell_m: float) -> None:
    """Initialise the grid at a place, with cells in these states and without points."""
    half_m = 0.5 * GRID_SIDE_CELLS * cell_m
    centre = ffi.new("vec2_t *", (origin.x_m + half_m, origin.y_m + half_m))[0]
    cfg = ffi.new("grid_config_t *", lib.grid_config_default())
    lib.grid_init(grid, cfg, centre, cell_m)
    put_values(grid, VALUE_OF[states])
