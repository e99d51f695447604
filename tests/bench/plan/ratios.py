# SPDX-License-Identifier: GPL-3.0-or-later
"""How many times as fast a planner is, with a confidence interval."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.bench.plan.runs import Columns

RESAMPLED = 2000
CONFIDENCE = 0.95

Numbers = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate and the 95 % bootstrap interval around it."""

    value: float
    low: float
    high: float


def percentile(values: Numbers, percent: float) -> float:
    """A percentile without interpolation, since values may be infinite."""
    return float(np.percentile(values, percent, method="higher"))


def _bootstrap(count: int, estimate: Callable[[NDArray[np.int64]], Numbers]) -> Interval:
    """The estimate of all `count` problems, and of as many drawn from them with replacement.

    estimate takes rows of problem numbers and gives a number for each row.
    """
    rng = np.random.default_rng(count)
    drawn = estimate(rng.integers(count, size=(RESAMPLED, count)))
    tail = 50 * (1 - CONFIDENCE)
    low, high = np.percentile(drawn, [tail, 100 - tail])
    return Interval(float(estimate(np.arange(count)[None])[0]), float(low), float(high))


def by_problem(runs: Columns, name: str, budget_s: float) -> Numbers:
    """One row per problem, one column per seed; unsolved runs count with the whole budget."""
    problems = np.unique(runs["problem"])
    rows = [runs[name][runs["problem"] == problem] for problem in problems]
    return np.minimum(np.array(rows), budget_s)


def geometric_ratio(slower: Numbers, faster: Numbers) -> Interval:
    """Geometric mean over the problems of the ratio of medians over the seeds.

    A run that ends at the budget counts with the budget: that understates whoever is ahead.
    """
    logs = np.log(np.median(slower, axis=1)) - np.log(np.median(faster, axis=1))
    return _bootstrap(len(logs), lambda drawn: np.exp(logs[drawn].mean(axis=1)))


def tail_ratio(slower: Numbers, faster: Numbers, percent: float = 95.0) -> Interval:
    """Ratio of a percentile over all runs; the bootstrap draws whole problems."""

    def tail(runs: Numbers, drawn: NDArray[np.int64]) -> Numbers:
        rows = runs[drawn].reshape(len(drawn), -1)
        return np.percentile(rows, percent, axis=1, method="higher")

    return _bootstrap(len(slower), lambda drawn: tail(slower, drawn) / tail(faster, drawn))
