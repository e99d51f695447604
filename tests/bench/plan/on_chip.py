# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench's problems on the emulated Cortex-M4F: what the first route costs there."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from tests.bench.cycles import SAFETY
from tests.bench.plan.compiled import HERE, core_files
from tests.bench.plan.figures import Figures
from tests.bench.plan.problems import Problem
from tests.bench.plan.ratios import percentile
from tests.firmware.build import HERE as FIRMWARE_TESTS
from tests.firmware.build import Program, build
from tests.firmware.chip import CLOCK_HZ, Chip
from tests.firmware.replay import on_this_machine
from tests.tools.objects import CORE

HOMES: Final = ("furniture", "rooms")
SLICE: Final = "chip_slice"
STEPS: Final = ("ours_start", "ours_search", "ours_route")
PROGRAM: Final = Program(
    "plan",
    (HERE / "chip_plan.c", HERE / "ours.c", *core_files(HERE / "ours.c")),
    (HERE, FIRMWARE_TESTS, CORE),
)


def packed(problems: Iterable[Problem], seed: int) -> bytes:
    """The problems as chip_plan.c reads them."""
    return b"".join(
        np.packbits(problem.blocked, axis=1, bitorder="little").tobytes()
        + struct.pack("<4fI", *problem.start, *problem.goal, seed * 7919 + k)
        for k, problem in enumerate(problems)
    )


def outcomes(output: bytes) -> list[tuple[float, int]]:
    """For each problem the length of its first path (infinite without one), and its slices."""
    found, at = [], 0
    while at < len(output):
        cost, slices, points = struct.unpack_from("<fii", output, at)
        found.append((cost, slices))
        at += struct.calcsize("<fii") + struct.calcsize("<2f") * points
    return found


def chip_figures(problems: Sequence[Problem], seed: int) -> Figures:
    """Milliseconds at the drone's clock rate; the worst slice with the model's safety factor."""
    data = packed(problems, seed)
    run = Chip(build(PROGRAM, "firmware")).run(data, (SLICE, *STEPS))
    costs, slices = zip(*outcomes(run.output), strict=True)
    slice_ms = run.cycles[SLICE] / CLOCK_HZ * 1000
    parts = np.split(slice_ms, np.cumsum(slices)[:-1])
    first_ms = np.array([part.sum() for part in parts])
    first_ms[np.isinf(costs)] = np.inf
    return {
        "chip_problems": len(problems),
        "chip_first_ms_median": percentile(first_ms, 50),
        "chip_first_ms_p95": percentile(first_ms, 95),
        "chip_worst_slice_ms": float(SAFETY * slice_ms.max()),
        "chip_worst_cycles": {name: int(run.cycles[name].max()) for name in (SLICE, *STEPS)},
        "chip_same_bits": run.output == on_this_machine(PROGRAM, data),
        "planner_stack_bytes": run.stack_bytes[SLICE],
    }
