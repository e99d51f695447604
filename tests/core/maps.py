# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids and clearances for tests, made through the public functions of the core only."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ground.core import ffi, lib

SIDE: int = lib.GRID_SIDE_CELLS
OCCUPIED: int = lib.GRID_VALUE_MAX
FREE = 3
Cells = Iterable[tuple[int, int]]
Bits = NDArray[np.bool_]
WHOLE_M = 1000.0


def vec2(x: float, y: float) -> Any:
    """A vec2_t; lives as long as the result is held."""
    return ffi.new("vec2_t *", (x, y))[0]


def xy(v: Any) -> tuple[float, float]:
    return v.x, v.y


def new_grid(cell_m: float = 0.05, centre_m: tuple[float, float] = (0.0, 0.0)) -> Any:
    """An empty grid with the default evidence."""
    grid = ffi.new("grid_t *")
    cfg = ffi.new("grid_config_t *", lib.grid_config_default())
    lib.grid_init(grid, cfg, vec2(*centre_m), cell_m)
    return grid


def occupy(grid: Any, cells: Cells, value: int = OCCUPIED) -> None:
    for ix, iy in cells:
        lib.grid_set_value(grid, ix, iy, value)


def fill(grid: Any, value: int) -> None:
    """Give every cell this value, at once."""
    ffi.memmove(
        grid.cells, bytes([value << 4 | value]) * ffi.sizeof(grid.cells), ffi.sizeof(grid.cells)
    )
    grid.known = SIDE * SIDE if value else 0
    ffi.memmove(grid.changed_rows, b"\xff" * 16, 16)


def new_clearance(
    grid: Any,
    radius_m: float = 0.0,
    low_m: tuple[float, float] = (-WHOLE_M, -WHOLE_M),
    high_m: tuple[float, float] = (WHOLE_M, WHOLE_M),
) -> Any:
    """The complete clearance of a grid."""
    clearance = ffi.new("clearance_t *")
    lib.clearance_init(clearance, grid, radius_m, vec2(*low_m), vec2(*high_m))
    assert lib.clearance_refresh(clearance, grid, SIDE) == 0
    return clearance


def with_walls(cells: Cells) -> tuple[Any, Any]:
    """A grid with these cells occupied, and its clearance of radius 0: exactly these are blocked."""
    grid = new_grid()
    occupy(grid, cells)
    return grid, new_clearance(grid)


def from_picture(rows: list[str], ix0: int = 0, iy0: int = 0) -> set[tuple[int, int]]:
    """Cells marked # in a picture whose last row is iy0."""
    return {
        (ix0 + i, iy0 + len(rows) - 1 - j)
        for j, row in enumerate(rows)
        for i, mark in enumerate(row)
        if mark == "#"
    }


def blocked_bits(clearance: Any) -> Bits:
    """Clearance as an array [iy, ix]."""
    words = np.frombuffer(ffi.buffer(clearance.bits), dtype="<u4").reshape(SIDE, -1)
    return np.unpackbits(words.view(np.uint8), axis=1, bitorder="little").astype(bool)


def values(grid: Any) -> NDArray[np.uint8]:
    """All cell values as an array [iy, ix]."""
    raw = np.frombuffer(ffi.buffer(grid.cells), dtype=np.uint8).reshape(SIDE, -1)
    return np.stack([raw & 15, raw >> 4], axis=2).reshape(SIDE, SIDE)


def raw_bytes(pointer: Any) -> bytes:
    """The bytes of the struct that a pointer points to."""
    return bytes(ffi.buffer(pointer))


def points(array: Any, count: int) -> list[tuple[float, float]]:
    """The first points of a vec2_t array."""
    return [xy(array[i]) for i in range(count)]


def path_array(path: list[tuple[float, float]], capacity: int = 64) -> Any:
    """A vec2_t array that begins with the path."""
    array = ffi.new("vec2_t[]", capacity)
    for i, (x, y) in enumerate(path):
        array[i].x, array[i].y = x, y
    return array


def length(path: list[tuple[float, float]]) -> float:
    return float(
        sum(np.hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(path, path[1:], strict=False))
    )


def is_clear(clearance: Any, path: list[tuple[float, float]]) -> bool:
    """Every piece of the path stays in free cells."""
    return all(
        lib.clearance_segment_free(clearance, vec2(*a), vec2(*b))
        for a, b in zip(path, path[1:], strict=False)
    )
