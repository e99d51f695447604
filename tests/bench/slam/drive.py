# SPDX-License-Identifier: GPL-3.0-or-later
"""The core's scan, slam and grid, compiled with the C loop that feeds them a whole flight."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Mapping
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
_SAID = np.dtype(
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
    """What the core made of a flight."""

    poses: Array
    """x, y, yaw a tick, known in that tick."""
    bias_rps: Array
    scale: Array
    sd_m: Array
    """Of the position along each axis, as SLAM believes; none by the particle filter."""
    confidence: NDArray[np.uint8]
    occupied: Array
    """Where the map's occupied cells put their obstacles: x, y."""


@cache
def _library() -> tuple[CData, CData]:
    """ffi and the functions; compiled once a process."""
    folder = Path(tempfile.mkdtemp(prefix="wayflie-slam-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    target = folder / "drive.so"
    sources = [HERE / "drive.c", HERE / "particles.c", *sorted(CORE.glob("*.c"))]
    HOST.run(
        "gcc",
        *HOST.flags,
        "-fPIC",
        "-shared",
        f"-I{CORE}",
        f"-I{HERE}",
        *sources,
        "-lm",
        "-o",
        target,
    )
    ffi = FFI()
    ffi.cdef(declarations(CORE))
    for name in ("drive.h", "particles.h"):
        own = (HERE / name).read_text().splitlines()
        ffi.cdef("\n".join(line for line in own if not line.startswith("#")))
    return ffi, ffi.dlopen(str(target))


def _configured(default: CData, changes: Mapping[str, float]) -> CData:
    for name, value in changes.items():
        owner, _, field = name.rpartition(".")
        setattr(getattr(default, owner) if owner else default, field, value)
    return default


def _occupied(ffi: CData, lib: CData, grid: CData) -> Array:
    """The obstacle point of each occupied cell, its middle where it has none."""
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
    """Fly the core, or the particle filter, through a flight; scan and slam change the defaults."""
    ffi, lib = _library()
    ticks = len(odometry)
    poses = np.ascontiguousarray(odometry, dtype=np.float32)
    up = np.full((ticks, 1), _UP_M)
    ranges = np.ascontiguousarray(np.hstack([ranges_m, up]), dtype=np.float32)
    said = np.zeros(ticks, dtype=_SAID)
    assert ffi.sizeof("drive_said_t") == _SAID.itemsize
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
