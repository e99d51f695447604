# SPDX-License-Identifier: GPL-3.0-or-later
"""The core's relocalisation, and the flight that draws its map, compiled with their C loops."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ground.core import CData
from tests.bench.slam.drive import HERE as SLAM
from tests.bench.slam.drive import SAID as SAID_OF_SLAM
from tests.bench.slam.drive import TICK_MS, as_given, compiled
from tests.bench.slam.rooms import Array

HERE = Path(__file__).parent
BUDGET: Final = 400
"""Units a tick."""
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
    """What a lost drone estimated, a row per tick."""

    poses: Array
    known: NDArray[np.bool_]
    sure: NDArray[np.bool_]


@cache
def _library() -> tuple[CData, CData]:
    """Compile the library, once per process."""
    return compiled([SLAM, HERE], ["drive", "lost"])


def draw(odometry: Array, ranges_m: Array, centre_m: tuple[float, float], cell_m: float) -> Drawn:
    """Draw a map: run the core's SLAM over a whole flight."""
    ffi, lib = _library()
    state = ffi.new("drive_t *")
    configs = [
        ffi.new(f"{name}_config_t *", getattr(lib, f"{name}_config_default")())
        for name in ("scan", "slam", "grid")
    ]
    poses, ranges = as_given(odometry, ranges_m)
    said = np.zeros(len(poses), dtype=SAID_OF_SLAM)
    assert ffi.sizeof("drive_said_t") == SAID_OF_SLAM.itemsize
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
    """Run the core's relocalisation in a map."""
    ffi, lib = _library()
    poses, ranges = as_given(odometry, ranges_m)
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
