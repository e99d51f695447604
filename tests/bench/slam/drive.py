# SPDX-License-Identifier: GPL-3.0-or-later
"""The core's scan, slam and grid, compiled with the C loop that feeds them a whole flight."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from ground.core import CData
from ground.core_build import declarations
from tests.bench.slam.rooms import Array
from tests.tools.objects import CORE, HOST

HERE = Path(__file__).parent
TICK_MS = 20
_UP_M = -1.0
Method: TypeAlias = Literal["slam", "pf"]
"""The core's own, or the particle filter that it is compared with."""
SAID = np.dtype(
    [
        ("pose", "<f4", 3),
        ("bias_rps", "<f4"),
        ("scale", "<f4"),
        ("sd_m", "<f4"),
        ("confidence", "<u4"),
    ]
)


@dataclass(frozen=True, slots=True)
class Driven:
    """The core's estimates for a flight."""

    poses: Array
    """x, y, yaw a tick, known in that tick."""
    bias_rps: Array
    scale: Array
    sd_m: Array
    """Of the position along each axis, as SLAM believes; none by the particle filter."""
    confidence: NDArray[np.uint8]
    occupied: Array
    """Where the map's occupied cells put their obstacles: x, y."""


def compiled(folders: Sequence[Path], sources: Sequence[str]) -> tuple[CData, CData]:
    """Compile these sources of the core, with their headers, and return ffi and functions."""
    folder = Path(tempfile.mkdtemp(prefix="wayflie-drive-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    target = folder / "drive.so"
    own = [next(path for at in folders if (path := at / f"{name}.c").exists()) for name in sources]
    includes = [f"-I{path}" for path in (CORE, *folders)]
    code = [*own, *sorted(CORE.glob("*.c"))]
    HOST.run("gcc", *HOST.flags, "-fPIC", "-shared", *includes, *code, "-lm", "-o", target)
    ffi = FFI()
    ffi.cdef(declarations(CORE))
    for source in own:
        lines = source.with_suffix(".h").read_text().splitlines()
        ffi.cdef("\n".join(line for line in lines if not line.startswith("#")))
    return ffi, ffi.dlopen(str(target))


def as_given(odometry: Array, ranges_m: Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Poses and sets of SCAN_RANGES as the C loops take them; the range upwards is none."""
    ranges = np.hstack([ranges_m, np.full((len(odometry), 1), _UP_M)])
    return (
        np.ascontiguousarray(odometry, dtype=np.float32),
        np.ascontiguousarray(ranges, dtype=np.float32),
    )


@cache
def _library() -> tuple[CData, CData]:
    """Compile the library, once per process."""
    return compiled([HERE], ["drive", "particles"])


def _configured(default: CData, changes: Mapping[str, float]) -> CData:
    for name, value in changes.items():
        owner, _, field = name.rpartition(".")
        setattr(getattr(default, owner) if owner else default, field, value)
    return default


def _occupied(ffi: CData, lib: CData, grid: CData) -> Array:
    """The obstacle point of each occupied cell, or its centre without one."""
    point = ffi.new("vec2_t *")
    found = []
    for iy in range(lib.GRID_SIDE_CELLS):
        for ix in range(lib.GRID_SIDE_CELLS):
            if lib.grid_state(grid, ix, iy) == lib.GRID_CELL_OCCUPIED:
                if not lib.grid_point(grid, ix, iy, point):
                    point[0] = lib.grid_centre_m(grid, (ix, iy))
                found.append((point.x, point.y))
    return np.array(found).reshape(-1, 2)


def drive(
    odometry: Array,
    ranges_m: Array,
    centre_m: tuple[float, float],
    cell_m: float,
    *,
    tick_ms: int = TICK_MS,
    method: Method = "slam",
    scan: Mapping[str, float] | None = None,
    slam: Mapping[str, float] | None = None,
) -> Driven:
    """Run the core, or the particle filter, on a flight; `scan` and `slam` change the defaults."""
    ffi, lib = _library()
    ticks = len(odometry)
    poses, ranges = as_given(odometry, ranges_m)
    said = np.zeros(ticks, dtype=SAID)
    assert ffi.sizeof("drive_said_t") == SAID.itemsize
    filter_ = ffi.new("particles_t *")
    state = ffi.addressof(filter_, "drive")
    configs = [
        ffi.new("scan_config_t *", _configured(lib.scan_config_default(), scan or {})),
        ffi.new("slam_config_t *", _configured(lib.slam_config_default(), slam or {})),
        ffi.new("grid_config_t *", lib.grid_config_default()),
    ]
    lib.drive_start(state, *configs, centre_m, cell_m)
    flown = (
        ffi.cast("float *", poses.ctypes.data),
        ffi.cast("float *", ranges.ctypes.data),
        ticks,
        tick_ms,
        ffi.cast("drive_said_t *", said.ctypes.data),
    )
    if method == "slam":
        lib.drive_fly(state, *flown)
    else:
        lib.particles_start(filter_, 1)
        lib.particles_fly(filter_, *flown)
    return Driven(
        said["pose"].astype(float),
        said["bias_rps"].astype(float),
        said["scale"].astype(float),
        said["sd_m"].astype(float),
        (said["confidence"] & 0xFF).astype(np.uint8),
        _occupied(ffi, lib, ffi.addressof(state, "grid")),
    )
