# SPDX-License-Identifier: GPL-3.0-or-later
"""The core's relocalisation, and the flight that draws its map, compiled with their C loops."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from ground.core import CData
from ground.core_build import declarations
from tests.bench.slam.rooms import Array
from tests.tools.objects import CORE, HOST

HERE = Path(__file__).parent
SLAM = HERE.parent / "slam"
TICK_MS: Final = 20
BUDGET: Final = 400
"""Units a tick."""
_UP_M: Final = -1.0
_MAPPED = np.dtype(
    [("pose", "<f4", 3), ("bias_rps", "<f4"), ("scale", "<f4"), ("confidence", "<u4")]
)
_SAID = np.dtype([("pose", "<f4", 3), ("score", "<f4"), ("known", "<u4"), ("sure", "<u4")])


@dataclass(frozen=True, slots=True)
class Drawn:
    """A map that the core drew."""

    state: CData
    grid: CData
    poses: Array
    """Where it believed to be, x, y, yaw a tick."""


@dataclass(frozen=True, slots=True)
class Lost:
    """What a lost drone believed, a tick."""

    poses: Array
    known: NDArray[np.bool_]
    sure: NDArray[np.bool_]


@cache
def _library() -> tuple[CData, CData]:
    """ffi and the functions; compiled once a process."""
    folder = Path(tempfile.mkdtemp(prefix="wayflie-reloc-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    target = folder / "drive.so"
    sources = [HERE / "lost.c", SLAM / "drive.c", *sorted(CORE.glob("*.c"))]
    includes = [f"-I{path}" for path in (CORE, SLAM, HERE)]
    HOST.run("gcc", *HOST.flags, "-fPIC", "-shared", *includes, *sources, "-lm", "-o", target)
    ffi = FFI()
    ffi.cdef(declarations(CORE))
    for header in (SLAM / "drive.h", HERE / "lost.h"):
        own = header.read_text().splitlines()
        ffi.cdef("\n".join(line for line in own if not line.startswith("#")))
    return ffi, ffi.dlopen(str(target))


def _arrays(odometry: Array, ranges_m: Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    up = np.full((len(odometry), 1), _UP_M)
    ranges = np.ascontiguousarray(np.hstack([ranges_m, up]), dtype=np.float32)
    return np.ascontiguousarray(odometry, dtype=np.float32), ranges


def draw(odometry: Array, ranges_m: Array, centre_m: tuple[float, float], cell_m: float) -> Drawn:
    """Fly the core's SLAM over a whole flight."""
    ffi, lib = _library()
    state = ffi.new("drive_t *")
    configs = [
        ffi.new(f"{name}_config_t *", getattr(lib, f"{name}_config_default")())
        for name in ("scan", "slam", "grid")
    ]
    poses, ranges = _arrays(odometry, ranges_m)
    said = np.zeros(len(poses), dtype=_MAPPED)
    assert ffi.sizeof("drive_said_t") == _MAPPED.itemsize
    lib.drive_start(state, *configs, centre_m, cell_m)
    lib.drive_fly(
        state,
        ffi.cast("float *", poses.ctypes.data),
        ffi.cast("float *", ranges.ctypes.data),
        len(poses),
        TICK_MS,
        ffi.cast("drive_said_t *", said.ctypes.data),
    )
    return Drawn(state, ffi.addressof(state, "grid"), said["pose"].astype(float))


def be_lost(drawn: Drawn, odometry: Array, ranges_m: Array, budget: int = BUDGET) -> Lost:
    """Let the core find itself in a map."""
    ffi, lib = _library()
    poses, ranges = _arrays(odometry, ranges_m)
    said = np.zeros(len(poses), dtype=_SAID)
    assert ffi.sizeof("lost_said_t") == _SAID.itemsize
    lib.lost_fly(
        ffi.new("lost_t *"),
        drawn.grid,
        ffi.new("scan_config_t *", lib.scan_config_default()),
        ffi.cast("float *", poses.ctypes.data),
        ffi.cast("float *", ranges.ctypes.data),
        len(poses),
        TICK_MS,
        budget,
        ffi.cast("lost_said_t *", said.ctypes.data),
    )
    return Lost(said["pose"].astype(float), said["known"] != 0, said["sure"] != 0)
