# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of a run of the planning bench."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tests.bench.plan.figures import Results, speedup
from tests.bench.plan.problems import Problem
from tests.bench.plan.ratios import geometric_ratio
from tests.bench.plan.runs import ASTAR, BUDGET_MS, CONNECT, OURS, THETA

SHOWN = (OURS, CONNECT, "Informed RRT* tuned", "RRT* tuned", "BIT* tuned", THETA, ASTAR)
TARGETS: Mapping[str, str] = {
    "first_s": "the first way",
    "within_105_s": "1.05 x optimum",
    "within_102_s": "1.02 x optimum",
}


def _shown(results: Results) -> list[str]:
    return [name for name in SHOWN if name in results.plans]


def plot_times(results: Results, path: Path) -> None:
    """Plot the share of all runs that had reached each target by a time."""
    figure, axes = plt.subplots(
        1, len(TARGETS), figsize=(14, 4.4), sharey=True, layout="constrained"
    )
    for panel, (name, what) in zip(axes, TARGETS.items(), strict=True):
        for planner in _shown(results):
            times_ms = np.sort(results.of(planner)[name]) * 1000
            share = np.arange(1, len(times_ms) + 1) / len(times_ms)
            wide = 2.5 if planner == OURS else 1.2
            panel.step(times_ms, share, where="post", linewidth=wide, label=planner)
        panel.set(xscale="log", xlim=(5e-3, BUDGET_MS), xlabel=f"ms to {what}", ylim=(0, 1))
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("share of runs")
    _legend(figure, axes[0])
    _save(path)


def plot_speedups(results: Results, path: Path) -> None:
    """Plot geometric means by family, with their 95 % intervals."""
    families = [None, *results.plans[OURS]]
    others = [name for name in _shown(results) if name != OURS]
    figure, axes = plt.subplots(
        1, len(TARGETS), figsize=(14, 4.4), sharey=True, layout="constrained"
    )
    for panel, (name, what) in zip(axes, TARGETS.items(), strict=True):
        for k, other in enumerate(others):
            found = [speedup(results, other, name, geometric_ratio, of) for of in families]
            values = np.array([interval.value for interval in found])
            below = values - [interval.low for interval in found]
            above = [interval.high for interval in found] - values
            at = np.arange(len(families)) + 0.12 * (k - len(others) / 2)
            panel.errorbar(at, values, [below, above], fmt="o", markersize=4, label=other)
        panel.axhline(1.0, color="black", linewidth=0.8)
        panel.set(yscale="log", title=f"times as fast to {what}")
        panel.set_xticks(range(len(families)), [family or "all" for family in families])
        panel.tick_params(axis="x", rotation=30)
        panel.grid(alpha=0.3)
    _legend(figure, axes[0])
    _save(path)


def _draw(panel: Axes, problem: Problem) -> None:
    picture = np.where(problem.raw, 0.0, np.where(problem.blocked, 0.75, 1.0))
    side = len(picture)
    panel.imshow(picture, cmap="gray", origin="lower", extent=(0, side, 0, side))
    panel.plot(*zip(*problem.way, strict=True), color="tab:red", linewidth=1.5)
    panel.plot(*problem.start, "o", color="tab:green")
    panel.plot(*problem.goal, "*", color="tab:blue", markersize=10)
    panel.set(title=problem.family, xticks=[], yticks=[])


def plot_problems(families: Mapping[str, Sequence[Problem]], path: Path) -> None:
    """Draw the first problem of each family with its shortest path."""
    _, axes = plt.subplots(1, len(families), figsize=(3 * len(families), 3.4), layout="constrained")
    for panel, problems in zip(axes, families.values(), strict=True):
        _draw(panel, problems[0])
    _save(path)


def _legend(figure: Figure, panel: Axes) -> None:
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8)


def _save(path: Path) -> None:
    plt.savefig(path, dpi=120)
    plt.close()


def write_plots(
    folder: Path, families: Mapping[str, Sequence[Problem]], results: Results
) -> Iterable[Path]:
    """Write problems.png and times.png, and with opponents speedups.png."""
    folder.mkdir(parents=True, exist_ok=True)
    written = [folder / "problems.png", folder / "times.png"]
    plot_problems(families, written[0])
    plot_times(results, written[1])
    if len(_shown(results)) > 1:
        written.append(folder / "speedups.png")
        plot_speedups(results, written[-1])
    return written
