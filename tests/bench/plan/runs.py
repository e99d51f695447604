# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the drivers on a set of problems and read what they measured."""

from __future__ import annotations

import csv
import io
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.bench.plan.compiled import BUILT, driver

BUDGET_MS = 1000.0
FIXED_SAMPLES = 2000
OMPL_DRIVER = BUILT / "drive_ompl"

Columns = dict[str, NDArray[np.float64]]
"""What a driver printed: a number per run, by the names of drive.c's header, and seed."""

OURS = "ours"
CONNECT = "RRT-Connect tuned"
THETA = "lazy Theta*"
ASTAR = "A* + string pulling"
PYTHON = "plain Python RRT*"
OPTIMAL = tuple(
    f"{name} {kind}" for name in ("RRT*", "Informed RRT*", "BIT*") for kind in ("default", "tuned")
)
OMPL = ("RRT-Connect default", CONNECT, *OPTIMAL)
OPPONENTS: Mapping[str, tuple[str, ...]] = {
    "ompl": OMPL,
    "astar": (ASTAR,),
    "theta": (THETA,),
    "python": (PYTHON,),
}


@dataclass(frozen=True, slots=True)
class Task:
    """A problem file and the seed of the planners."""

    problems: Path
    seed: int


def _driven(*command: str | Path | int | float) -> Columns:
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{Path(words[0]).name} failed: {done.stderr.strip()}")
    return read_columns(done.stdout)


def read_columns(text: str) -> Columns:
    """Read numbers by the names in the first line."""
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def write_columns(columns: Columns) -> str:
    """Write the same format again."""
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(repr, map(float, row))) for row in rows)])


def run_ours(task: Task, mode: str = "plan") -> Columns:
    return _driven(driver("ours"), mode, task.problems, task.seed, BUDGET_MS, FIXED_SAMPLES)


def run_grid(name: str) -> Callable[[Task], Columns]:
    return lambda task: _driven(driver("grid"), name, task.problems)


def run_ompl(name: str) -> Callable[[Task], Columns]:
    planner, kind = name.rsplit(" ", 1)
    return lambda task: _driven(OMPL_DRIVER, planner, kind, task.problems, task.seed, BUDGET_MS)


def runner(name: str) -> Callable[[Task], Columns]:
    """The function that runs a planner of this name."""
    if name == OURS:
        return run_ours
    if name in OMPL:
        return run_ompl(name)
    return run_grid("theta" if name == THETA else "astar")


def joined(parts: Sequence[Columns]) -> Columns:
    """Concatenate runs."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def planner_bytes() -> int:
    """Size of the planner's state and its blocked bits."""
    done = subprocess.run([driver("ours"), "sizes"], capture_output=True, text=True, check=True)
    return sum(map(int, done.stdout.split(",")))
