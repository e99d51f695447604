# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids and clearances for tests, made through the public functions of the core only."""

import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ground.core import CData, ffi, lib

SIDE: int = lib.GRID_SIDE_CELLS
OCCUPIED: int = lib.GRID_VALUE_MAX
FREE = 3
Cell = tuple[int, int]
Cells = Iterable[Cell]
Bits = NDArray[np.bool_]
PER_CELL: int = lib.LATTICE_PER_CELL
STEPS_MAX: int = lib.LATTICE_MAX
Steps = tuple[int, int]
Point = tuple[float, float]
WHOLE_M = 1000.0


def vec2(x: float, y: float) -> CData:
    """A vec2_t; lives as long as the result is held."""
    return ffi.new("vec2_t *", (x, y))[0]


def xy(v: CData) -> tuple[float, float]:
    return v.x, v.y


def new_grid(cell_m: float = 0.05, centre_m: tuple[float, float] = (0.0, 0.0)) -> CData:
    """An empty grid with the default evidence."""
    grid = ffi.new("grid_t *")
    cfg = ffi.new("grid_config_t *", lib.grid_config_default())
    lib.grid_init(grid, cfg, vec2(*centre_m), cell_m)
    return grid


def occupy(grid: CData, cells: Cells, value: int = OCCUPIED) -> None:
    for ix, iy in cells:
        lib.grid_set_value(grid, ix, iy, value)


def fill(grid: CData, value: int) -> None:
    """Set every cell to this value."""
    ffi.memmove(
        grid.cells, bytes([value << 4 | value]) * ffi.sizeof(grid.cells), ffi.sizeof(grid.cells)
    )
    grid.known = SIDE * SIDE if value else 0
    ffi.memmove(grid.changed_rows, b"\xff" * 16, 16)


def new_clearance(
    grid: CData,
    radius_m: float = 0.0,
    low_m: tuple[float, float] = (-WHOLE_M, -WHOLE_M),
    high_m: tuple[float, float] = (WHOLE_M, WHOLE_M),
) -> CData:
    """The complete clearance of a grid."""
    clearance = ffi.new("clearance_t *")
    lib.clearance_init(clearance, grid, radius_m, vec2(*low_m), vec2(*high_m))
    assert lib.clearance_refresh(clearance, grid, SIDE) == 0
    return clearance


def with_walls(cells: Cells) -> tuple[CData, CData]:
    """A grid with these cells occupied, and its clearance of radius 0, which blocks only them."""
    grid = new_grid()
    occupy(grid, cells)
    return grid, new_clearance(grid)


def pose(x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0) -> CData:
    return ffi.new("pose2_t *", (x_m, y_m, yaw_rad))[0]


def frame(hits_m: dict[int, float], clear_m: dict[int, float] | None = None) -> CData:
    """A measured set of ranges, by beam."""
    clear_m = clear_m or {}
    made = ffi.new("scan_frame_t *")
    for beam, range_m in {**hits_m, **clear_m}.items():
        made.range_m[beam] = range_m
    made.hit = sum(1 << beam for beam in hits_m)
    made.clear = sum(1 << beam for beam in clear_m)
    return made


def from_picture(rows: list[str], ix0: int = 0, iy0: int = 0) -> set[tuple[int, int]]:
    """Cells marked # in a picture whose last row is iy0."""
    return {
        (ix0 + i, iy0 + len(rows) - 1 - j)
        for j, row in enumerate(rows)
        for i, mark in enumerate(row)
        if mark == "#"
    }


def blocked_bits(clearance: CData) -> Bits:
    """Clearance as an array [iy, ix]."""
    words = np.frombuffer(ffi.buffer(clearance.bits), dtype="<u4").reshape(SIDE, -1)
    return np.unpackbits(words.view(np.uint8), axis=1, bitorder="little").astype(bool)


def values(grid: CData) -> NDArray[np.uint8]:
    """All cell values as an array [iy, ix]."""
    raw = np.frombuffer(ffi.buffer(grid.cells), dtype=np.uint8).reshape(SIDE, -1)
    return np.stack([raw & 15, raw >> 4], axis=2).reshape(SIDE, SIDE)


def raw_bytes(pointer: CData) -> bytes:
    """The bytes of the struct that a pointer points to."""
    return bytes(ffi.buffer(pointer))


def lattice(at: Steps) -> CData:
    """A lattice_t; lives as long as the result is held."""
    return ffi.new("lattice_t *", at)[0]


def middle(cell: tuple[int, int]) -> Steps:
    """The lattice point at the centre of a cell."""
    return cell[0] * PER_CELL + PER_CELL // 2, cell[1] * PER_CELL + PER_CELL // 2


def steps(p: CData) -> Steps:
    return p.x, p.y


def in_cells(way: Iterable[Steps]) -> list[Point]:
    """Convert to cells, exactly: 1/256 is a power of two."""
    return [(x / PER_CELL, y / PER_CELL) for x, y in way]


def lattice_array(way: list[Steps], capacity: int = 64) -> CData:
    """A lattice_t array that starts with the path."""
    array = ffi.new("lattice_t[]", capacity)
    for i, (x, y) in enumerate(way):
        array[i].x, array[i].y = x, y
    return array


def lattice_points(array: CData, count: int) -> list[Steps]:
    """The first points of a lattice_t array."""
    return [steps(array[i]) for i in range(count)]


def sees(clearance: CData, way: list[Steps]) -> bool:
    """Check that each point of the path sees the next."""
    return all(
        lib.clearance_sees(clearance, lattice(a), lattice(b)) for a, b in itertools.pairwise(way)
    )


def points(array: CData, count: int) -> list[tuple[float, float]]:
    """The first points of a vec2_t array."""
    return [xy(array[i]) for i in range(count)]


def path_array(path: list[tuple[float, float]], capacity: int = 64) -> CData:
    """A vec2_t array that starts with the path."""
    array = ffi.new("vec2_t[]", capacity)
    for i, (x, y) in enumerate(path):
        array[i].x, array[i].y = x, y
    return array


def length(path: list[tuple[float, float]]) -> float:
    return float(sum(np.hypot(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(path)))


def is_clear(clearance: CData, path: list[tuple[float, float]]) -> bool:
    """Check that every piece of the path stays in free cells."""
    return all(
        lib.clearance_segment_free(clearance, vec2(*a), vec2(*b))
        for a, b in itertools.pairwise(path)
    )


def located(grid: CData, x_m: float, y_m: float) -> tuple[int, int] | None:
    """The cell of a point; None outside the grid."""
    cell = ffi.new("grid_cell_t *", (-7, -7))
    if lib.grid_locate(grid, vec2(x_m, y_m), cell):
        return cell.ix, cell.iy
    assert (cell.ix, cell.iy) == (-7, -7)
    return None
