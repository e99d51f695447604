# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of the planning bench, and which of them are checked against what."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ground.checks import Check, Sense
from tests.bench.plan.drawing import least_clearance
from tests.bench.plan.ratios import (
    Interval,
    Numbers,
    by_problem,
    geometric_ratio,
    percentile,
    tail_ratio,
)
from tests.bench.plan.runs import (
    ASTAR,
    BUDGET_MS,
    CONNECT,
    OMPL,
    OPTIMAL,
    OURS,
    THETA,
    Columns,
    joined,
)

Figures = dict[str, object]
TIMES = ("first_s", "within_105_s", "within_102_s")
LIMITS: tuple[tuple[str, Sense, float], ...] = (
    ("t_first_speedup_vs_best_optimal", ">=", 4.0),
    ("t_first_speedup_vs_rrtconnect", ">=", 1.0),
    ("t105_speedup_vs_best_optimal", ">=", 15.0),
    ("t105_speedup_vs_theta", ">=", 2.0),
    ("t105_speedup_vs_rrtconnect_worst_family", ">=", 1.0),
    ("t102_speedup_vs_best_optimal", ">=", 25.0),
    ("p95_t105_speedup_vs_any_ompl", ">=", 10.0),
    ("p95_t105_speedup_vs_theta", ">=", 1.0),
    ("final_cost_ratio_median", "<=", 1.01),
    ("final_cost_ratio_p95", "<=", 1.03),
    ("solved_fraction", "==", 1.0),
    ("collisions", "==", 0),
    ("opponents_invalid", "==", 0),
    ("planner_ram_bytes", "<=", 8192),
    ("planner_stack_bytes", "<=", 512),
    ("unsolvable_proven", "==", 1.0),
    ("solvable_refused", "==", 0),
    ("unsolvable_time_vs_astar", "<=", 1.0),
    ("replan_solved", "==", 1.0),
    ("replan_ratio", "<=", 1 / 3),
    ("chip_first_ms_median", "<=", 5.0),
    ("chip_first_ms_p95", "<=", 25.0),
    ("chip_worst_slice_ms", "<=", 1.0),
    ("chip_same_bits", "==", True),
    ("one_session", "==", True),
)

Compare = Callable[[Numbers, Numbers], Interval]


@dataclass(slots=True)
class Results:
    """Runs by planner and family, each with a column `optimum`."""

    plans: dict[str, dict[str, Columns]] = field(default_factory=dict)
    unsolvable: dict[str, Columns] = field(default_factory=dict)
    """How long OURS and ASTAR took to know that there is no way."""
    solvable: Columns = field(default_factory=dict)
    """What OURS says where there is one."""
    replans: dict[str, Columns] = field(default_factory=dict)
    """By what was done: `repair` and `anew`."""

    def of(self, planner: str, family: str | None = None) -> Columns:
        """The runs of a planner, in one family or in all of them."""
        families = self.plans[planner]
        return families[family] if family else joined(list(families.values()))


def _times(runs: Columns, name: str) -> Numbers:
    return by_problem(runs, name, BUDGET_MS / 1000)


def speedup(
    results: Results, other: str, name: str, compare: Compare, family: str | None = None
) -> Interval:
    """How many times as fast our planner is."""
    ours, theirs = (_times(results.of(planner, family), name) for planner in (OURS, other))
    return compare(theirs, ours)


def _hardest(results: Results, others: Iterable[str], name: str, compare: Compare) -> Interval:
    """The speedup over the fastest opponent."""
    found = [speedup(results, other, name, compare) for other in others if other in results.plans]
    return min(found, key=lambda interval: interval.low)


def speedups(results: Results) -> dict[str, Interval]:
    """Speedups over the opponents that took part."""
    found: dict[str, Interval] = {}
    there = results.plans
    if any(name in there for name in OPTIMAL):
        for key, name in zip(("t_first", "t105", "t102"), TIMES, strict=True):
            hardest = _hardest(results, OPTIMAL, name, geometric_ratio)
            found[f"{key}_speedup_vs_best_optimal"] = hardest
        found["p95_t105_speedup_vs_any_ompl"] = _hardest(results, OMPL, "within_105_s", tail_ratio)
    for key, other in (("rrtconnect", CONNECT), ("theta", THETA)):
        if other in there:
            for time, name in zip(("t_first", "t105", "t102"), TIMES, strict=True):
                ratio = speedup(results, other, name, geometric_ratio)
                found[f"{time}_speedup_vs_{key}"] = ratio
            tail = speedup(results, other, "within_105_s", tail_ratio)
            found[f"p95_t105_speedup_vs_{key}"] = tail
    if CONNECT in there:
        by_family = {
            family: speedup(results, CONNECT, "within_105_s", geometric_ratio, family)
            for family in there[OURS]
        }
        found |= {f"t105_speedup_vs_rrtconnect_{family}": x for family, x in by_family.items()}
        worst = min(by_family.values(), key=lambda interval: interval.low)
        found["t105_speedup_vs_rrtconnect_worst_family"] = worst
    return found


def _broken(runs: Columns) -> int:
    """Paths that broke a rule, and runs whose last path came too near to an obstacle."""
    too_near = runs["clearance"] < least_clearance() - 1e-3
    return int(runs["invalid"].sum() + too_near.sum())


def quality(results: Results) -> Figures:
    """The quality of our routes; a collision is any broken rule of any returned path."""
    runs = results.of(OURS)
    ratio, flown, enough = (
        runs[name] / runs["optimum"] for name in ("fixed_cost", "flown_cost", "enough_cost")
    )
    others = [name for name in results.plans if name != OURS]
    return {
        "final_cost_ratio_median": percentile(ratio, 50),
        "final_cost_ratio_p95": percentile(ratio, 95),
        "flown_cost_ratio_median": percentile(flown, 50),
        "flown_cost_ratio_p95": percentile(flown, 95),
        "first_ms_median": 1000 * percentile(runs["first_s"], 50),
        "enough_ms_median": 1000 * percentile(runs["enough_s"], 50),
        "enough_ms_p95": 1000 * percentile(runs["enough_s"], 95),
        "enough_cost_ratio_p95": percentile(enough, 95),
        "solved_fraction": float(np.isfinite(runs["cost"]).mean()),
        "collisions": sum(_broken(found) for found in (runs, *results.replans.values())),
        "opponents_invalid": int(sum(results.of(name)["invalid"].sum() for name in others)),
    }


def unsolvable(results: Results) -> tuple[dict[str, float], dict[str, Interval]]:
    """How often our planner proved that there is no path, and how long that took."""
    ours, astar = results.unsolvable[OURS], results.unsolvable[ASTAR]
    ratio = geometric_ratio(_times(ours, "end_s"), _times(astar, "end_s"))
    found = {
        "unsolvable_proven": float(np.isinf(ours["cost"]).mean()),
        "solvable_refused": int(np.isinf(results.solvable["cost"]).sum()),
    }
    return found, {"unsolvable_time_vs_astar": ratio}


def replans(results: Results) -> tuple[dict[str, float], dict[str, Interval]]:
    """Repairing after something closed, as a share of planning anew: until the planner has enough,
    which is when a route is handed on, and beside it until three lengths; and the price of it."""
    repair, anew = results.replans["repair"], results.replans["anew"]
    endings = ("_first", "_105", "_102", "")
    ratios = {
        f"replan_ratio{ending}": geometric_ratio(_times(repair, name), _times(anew, name))
        for ending, name in zip(endings, (*TIMES, "enough_s"), strict=True)
    }
    longer = repair["enough_cost"] / anew["enough_cost"]
    found = {
        "replan_solved": float(np.isfinite(repair["cost"]).mean()),
        "replan_length_ratio_median": percentile(longer, 50),
        "replan_length_ratio_p95": percentile(longer, 95),
    }
    return found, ratios


def bounds(intervals: Mapping[str, Interval]) -> Figures:
    """Under the figure's own name the worse bound for us, and beside it the estimate."""
    worse = {name: sense for name, sense, _ in LIMITS}
    figures: Figures = {}
    for name, interval in intervals.items():
        less_is_better = worse.get(name, "<=" if name.startswith("replan") else ">=") == "<="
        figures[name] = interval.high if less_is_better else interval.low
        figures[f"{name}_estimate"] = interval.value
    return figures


def finite(value: object) -> object:
    """None for values that were never reached, since JSON has no infinity."""
    return None if isinstance(value, float) and not np.isfinite(value) else value


def checks(figures: Mapping[str, object]) -> Sequence[Check]:
    """The checks of the figures that were measured."""
    return [
        Check(name, figures[name], limit, sense)  # type: ignore[arg-type]
        for name, sense, limit in LIMITS
        if name in figures
    ]
