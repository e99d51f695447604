# SPDX-License-Identifier: GPL-3.0-or-later
"""A lost drone's flight on the emulated Cortex-M4F: the cost of a slice there."""

from __future__ import annotations

import struct
from typing import Final

import numpy as np

from ground.core import CData
from tests.bench.cycles import SAFETY
from tests.bench.reloc.drive import BUDGET, HERE
from tests.bench.slam.rooms import Array
from tests.firmware.build import HERE as FIRMWARE_TESTS
from tests.firmware.build import Program, build
from tests.firmware.chip import Chip
from tests.firmware.replay import on_this_machine
from tests.tools.objects import CORE

SLICE: Final = "reloc_work"
TICKS: Final = 750
PROGRAM: Final = Program(
    "lost",
    (HERE / "chip_lost.c", HERE / "lost.c", *sorted(CORE.glob("*.c"))),
    (HERE, FIRMWARE_TESTS, CORE),
)


def packed(grid: CData, odometry: Array, ranges_m: Array, budget: int = BUDGET) -> bytes:
    """The first ticks of a flight, in the format of chip_lost.c."""
    ticks = min(TICKS, len(odometry))
    cells = np.array(list(grid.cells), dtype="<u4").tobytes()
    half_m = 64.0 * grid.cell_m
    middle = (grid.origin_m.x + half_m, grid.origin_m.y + half_m)
    up = np.full((ticks, 1), -1.0)
    return b"".join(
        (
            cells,
            struct.pack("<3f2i", *middle, grid.cell_m, ticks, budget),
            odometry[:ticks].astype("<f4").tobytes(),
            np.hstack([ranges_m[:ticks], up]).astype("<f4").tobytes(),
        )
    )


def chip_figures(data: bytes) -> dict[str, float]:
    """Cycles of the slices; the worst with the cycle model's safety factor."""
    run = Chip(build(PROGRAM, "firmware")).run(data, (SLICE,))
    cycles = run.cycles[SLICE]
    return {
        "chip_slice_cycles_median": float(np.median(cycles[cycles > 1000])),
        "chip_slice_cycles_worst": float(SAFETY * cycles.max()),
        "chip_same_bits": float(run.output == on_this_machine(PROGRAM, data)),
        "chip_stack_bytes": float(run.stack_bytes[SLICE]),
    }
