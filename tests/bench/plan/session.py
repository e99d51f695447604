# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs all planners of a bench on its problems.

For each seed and family all planners run before the next, so that drift of the machine meets all
of them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console

from ground.progress import waiting
from tests.bench.plan.compiled import BUILT, workshop
from tests.bench.plan.figures import Results
from tests.bench.plan.problems import Problem, make_changes, make_unsolvable, write_problems
from tests.bench.plan.python_rrtstar import run_plain_on
from tests.bench.plan.runs import (
    ASTAR,
    OURS,
    PYTHON,
    Columns,
    Task,
    joined,
    read_columns,
    run_ours,
    runner,
    write_columns,
)

Families = Mapping[str, Sequence[Problem]]


@dataclass(frozen=True, slots=True)
class Session:
    """A session of runs on this machine, one after the other."""

    families: Families
    opponents: Sequence[str]
    seed: int
    """Of what is made from the problems."""
    seeds: int
    reuse: bool
    """Take what opponents needed in an earlier run on the same problems."""

    def run(self, out: Console) -> Results:
        """Run every planner on every problem with every seed."""
        results = Results()
        parts: dict[str, dict[str, list[Columns]]] = {OURS: {}}
        for seed in range(1, self.seeds + 1):
            for family, problems in self.families.items():
                path = workshop() / f"{family}.bin"
                write_problems(path, problems)
                for name in (OURS, *self.opponents):
                    if name == PYTHON and seed > 1:  # it takes minutes
                        continue
                    with waiting(out, f"{name}, {family}, seed {seed} of {self.seeds}"):
                        columns = self._plan(name, Task(path, seed), problems)
                    parts.setdefault(name, {}).setdefault(family, []).append(columns)
            if self.opponents:
                out.print(f"seed {seed} of {self.seeds} done")
        results.plans = {name: _by_family(found) for name, found in parts.items()}
        self._measure_unsolvable(results)
        self._measure_replans(results)
        return results

    def _plan(self, name: str, task: Task, problems: Sequence[Problem]) -> Columns:
        """Run one planner on one file, with the optimum of each run beside it."""
        columns = run_ours(task) if name == OURS else self._opponent(name, task, problems)
        columns["optimum"] = np.array([problems[int(k)].optimum for k in columns["problem"]])
        return columns

    def _opponent(self, name: str, task: Task, problems: Sequence[Problem]) -> Columns:
        digest = hashlib.sha256(task.problems.read_bytes()).hexdigest()[:16]
        kept = BUILT / "kept" / f"{digest}-{task.seed}-{name.replace(' ', '_')}.csv"
        if self.reuse and kept.exists():
            return read_columns(kept.read_text())
        plain = name == PYTHON
        columns = run_plain_on(problems, task.seed) if plain else runner(name)(task)
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(write_columns(columns))
        return columns

    def _measure_unsolvable(self, results: Results) -> None:
        solvable, walled_off = workshop() / "solvable.bin", workshop() / "unsolvable.bin"
        problems = [problem for listed in self.families.values() for problem in listed]
        write_problems(solvable, problems)
        write_problems(walled_off, make_unsolvable(problems, self.seed))
        prove: dict[str, Callable[[Task], Columns]] = {
            OURS: lambda task: run_ours(task, "prove"),
            ASTAR: runner(ASTAR),
        }
        parts: dict[str, list[Columns]] = {name: [] for name in prove}
        for seed in range(1, self.seeds + 1):
            for name, run in prove.items():
                parts[name].append(run(Task(walled_off, seed)))
        results.unsolvable = {name: joined(found) for name, found in parts.items()}
        results.solvable = run_ours(Task(solvable, 1), "prove")

    def _measure_replans(self, results: Results) -> None:
        path = workshop() / "changes.bin"
        problems = [problem for listed in self.families.values() for problem in listed]
        pairs = make_changes(problems, self.seed)
        write_problems(path, [problem for pair in pairs for problem in pair])
        parts: dict[str, list[Columns]] = {"repair": [], "anew": []}
        for seed in range(1, self.seeds + 1):
            for mode, found in parts.items():
                found.append(run_ours(Task(path, seed), mode))
        results.replans = {name: joined(found) for name, found in parts.items()}


def _by_family(parts: Mapping[str, Sequence[Columns]]) -> dict[str, Columns]:
    """Merge the runs of several seeds, with problems numbered over all families."""
    numbered: dict[str, Columns] = {}
    before = 0.0
    for family, found in parts.items():
        runs = joined(found)
        runs["problem"] = runs["problem"] + before
        before = runs["problem"].max() + 1
        numbered[family] = runs
    return numbered
