# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone's planner alone: a grid in, the shortest path out.

    from ground.plan import plan
    way = plan(blocked, start=(10.5, 20.5), goal=(90.5, 40.5))
    print(way.status.name, way.length, way.points)

It is the C code that plans on board (firmware_app/core/pathfinder.h), with the same fixed memory
and the same results, bit for bit. Coordinates are in cells: cell (ix, iy) covers
[ix, ix + 1) x [iy, iy + 1), and x is the second index of an array.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ground.core import GRID_SIDE_CELLS, CData, ffi, lib
from ground.coregrid import put_values

Point = tuple[float, float]

_CELL_M = 0.05
_BEYOND_M = 1000.0


class Status(IntEnum):
    """State or result of a search."""

    SEARCHING = lib.PATHFINDER_SEARCHING
    FOUND = lib.PATHFINDER_FOUND
    NO_WAY = lib.PATHFINDER_NO_WAY
    TOO_WINDING = lib.PATHFINDER_TOO_WINDING
    START_BLOCKED = lib.PATHFINDER_START_BLOCKED
    GOAL_BLOCKED = lib.PATHFINDER_GOAL_BLOCKED


@dataclass(frozen=True, slots=True)
class Way:
    """The result of a search."""

    status: Status
    points: NDArray[np.float32]
    """(n, 2) from start to goal in cells, each in line of sight of the next; n is 0 if none."""
    length: float
    """In cells; infinite without a path."""
    samples: int
    first_samples: int
    """Number of samples after which the first path was known."""
    nodes: int
    nearest: Point | None
    """The reachable point nearest to the goal, once it is proven that there is no path."""


def plan(
    blocked: ArrayLike,
    start: Point,
    goal: Point,
    *,
    clearance: float = 0.0,
    samples: int | None = None,
    seed: int = 1,
    adaptive: bool = False,
) -> Way:
    """Find the shortest path from start to goal that stays `clearance` cells off blocked cells.

    `blocked` is an array of truth values, at most 128 x 128; everything outside is blocked. The
    search continues until the planner has enough, or for `samples` samples. Invalid arguments raise
    ValueError; blocked ends and proven impossibility are results.
    """
    layer = _clearance_of(_checked(blocked), clearance)
    planner, cfg = ffi.new("pathfinder_t *"), ffi.new("pathfinder_config_t *")
    cfg[0] = lib.pathfinder_config_default()
    cfg.adaptive = adaptive
    ends = [ffi.new("vec2_t *", end)[0] for end in (start, goal)]
    lib.pathfinder_start(planner, cfg, layer, *ends, seed)
    while not _done(planner, samples):
        lib.pathfinder_extend(planner, layer, ffi.NULL, 1)
    return _result(planner)


def _done(planner: CData, samples: int | None) -> bool:
    if planner.stage == lib.PATHFINDER_END:
        return True
    if samples is None:
        return bool(lib.pathfinder_enough(planner))
    return bool(planner.stage == lib.PATHFINDER_GROW and planner.samples >= samples)


def _checked(blocked: ArrayLike) -> NDArray[np.bool_]:
    cells = np.asarray(blocked, dtype=bool)
    if cells.ndim != 2 or 0 in cells.shape or max(cells.shape) > GRID_SIDE_CELLS:
        raise ValueError(
            f"a map has two dimensions of 1 to {GRID_SIDE_CELLS} cells, not {cells.shape}"
        )
    return cells


def _clearance_of(blocked: NDArray[np.bool_], clearance: float) -> CData:
    """The planner's bit layer, made by the core's own inflation of obstacles."""
    if not 0.0 <= clearance <= lib.CLEARANCE_REACH_MAX:
        raise ValueError(f"clearance must be 0 to {lib.CLEARANCE_REACH_MAX} cells, not {clearance}")
    whole = np.ones((GRID_SIDE_CELLS, GRID_SIDE_CELLS), dtype=bool)
    whole[: blocked.shape[0], : blocked.shape[1]] = blocked
    values = np.where(whole, lib.GRID_VALUE_MAX, lib.GRID_FREE_MIN).astype(np.uint8)
    grid, layer = ffi.new("grid_t *"), ffi.new("clearance_t *")
    cfg = ffi.new("grid_config_t *", lib.grid_config_default())
    lib.grid_init(grid, cfg, ffi.new("vec2_t *")[0], _CELL_M)
    put_values(grid, values)
    low, high = (ffi.new("vec2_t *", (sign * _BEYOND_M,) * 2)[0] for sign in (-1, 1))
    lib.clearance_init(layer, grid, clearance * _CELL_M, low, high)
    lib.clearance_refresh(layer, grid, GRID_SIDE_CELLS)
    return layer


def _result(planner: CData) -> Way:
    way = ffi.new("vec2_t[]", lib.PATHFINDER_POINTS)
    count = lib.pathfinder_path(planner, way, lib.PATHFINDER_POINTS)
    points = np.array([(way[i].x, way[i].y) for i in range(count)], dtype=np.float32)
    nearest = lib.pathfinder_nearest(planner) if planner.status == lib.PATHFINDER_NO_WAY else None
    return Way(
        status=Status(planner.status),
        points=points.reshape(-1, 2),
        length=float(planner.best_cells) if count else float("inf"),
        samples=int(planner.samples),
        first_samples=int(planner.first_samples),
        nodes=int(lib.pathfinder_nodes(planner)),
        nearest=(nearest.x, nearest.y) if nearest is not None else None,
    )
