# SPDX-License-Identifier: GPL-3.0-or-later
"""The map as SVG: one unit is one metre, north is up."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ground.core import CellState
from ground.map.groundmap import GroundMap

FREE, OCCUPIED, OBSTACLE, BACKGROUND = "#ffffff", "#a3aeaa", "#16211d", "#e6e9e7"
PIXELS_PER_M = 120


def svg_text(grid: GroundMap) -> str:
    """Draw the known part of the map."""
    rows, columns = np.nonzero(grid.states)
    if not len(rows):
        rows = columns = np.arange(len(grid.states))
    first, last = columns.min() - 2, columns.max() + 3
    low, high = rows.min() - 2, rows.max() + 3
    cell_m = grid.cell_m
    x_m, top_m = grid.origin.x_m + first * cell_m, grid.origin.y_m + high * cell_m
    width_m, height_m = (last - first) * cell_m, (high - low) * cell_m
    box = f"{x_m:.3f} {-top_m:.3f} {width_m:.3f} {height_m:.3f}"
    size = f'width="{width_m * PIXELS_PER_M:.0f}" height="{height_m * PIXELS_PER_M:.0f}"'
    corner = f'x="{x_m:.3f}" y="{-top_m:.3f}" width="{width_m:.3f}" height="{height_m:.3f}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" {size}>',
        f'<rect {corner} fill="{BACKGROUND}"/>',
        f'<path fill="{FREE}" d="{"".join(_runs(grid, CellState.FREE))}"/>',
        f'<path fill="{OCCUPIED}" d="{"".join(_runs(grid, CellState.OCCUPIED))}"/>',
        f'<g fill="{OBSTACLE}">',
        *(
            f'<circle cx="{x:.3f}" cy="{-y:.3f}" r="{0.25 * cell_m:.4f}"/>'
            for x, y in grid.obstacles_m()
        ),
        "</g>",
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _runs(grid: GroundMap, state: CellState) -> Iterator[str]:
    """Path data: a box for each run of cells of this state in a row."""
    cell_m = grid.cell_m
    for row, cells in enumerate(grid.states == state):
        edges = np.flatnonzero(np.diff(cells.astype(np.int8), prepend=0, append=0))
        y_m = -(grid.origin.y_m + (row + 1) * cell_m)
        for begin, end in edges.reshape(-1, 2):
            x_m, length_m = grid.origin.x_m + begin * cell_m, (end - begin) * cell_m
            yield f"M{x_m:.3f} {y_m:.3f}h{length_m:.3f}v{cell_m:.3f}h{-length_m:.3f}z"
