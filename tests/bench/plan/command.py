# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench plan`: the planner compared with widely used planners."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from ground.checks import write_report
from ground.errors import GroundError
from tests.bench.plan import figures
from tests.bench.plan.families import DRAWN
from tests.bench.plan.figures import Figures, Results
from tests.bench.plan.movingai import crops_of
from tests.bench.plan.on_chip import HOMES, chip_figures
from tests.bench.plan.plots import write_plots
from tests.bench.plan.problems import Problem, make_set
from tests.bench.plan.runs import OMPL, OMPL_DRIVER, OPPONENTS, planner_bytes
from tests.bench.plan.session import Session
from tests.bench.plan.tables import print_tables


@dataclass(frozen=True, slots=True)
class Options:
    """The options of `wayflie bench plan`."""

    seed: int = 101
    problems: int = 250
    against: tuple[str, ...] = tuple(OPPONENTS)
    seeds: int = 3
    maps: Path | None = None
    reuse: bool = False
    json_file: Path | None = None
    plots: Path | None = None

    @property
    def opponents(self) -> list[str]:
        return [name for group in self.against for name in OPPONENTS[group]]


def make_families(options: Options) -> dict[str, list[Problem]]:
    """Problems by family; crops of real maps replace the caverns if there are any."""
    draws = dict(DRAWN)
    if options.maps:
        del draws["caverns"]
        draws["movingai"] = crops_of(options.maps)
    problems = make_set(options.seed, options.problems, draws)
    return {name: [p for p in problems if p.family == name] for name in draws}


def take_figures(options: Options, results: Results, chip: Figures) -> Figures:
    """All measured figures by the names used in the report."""
    proven, proof_time = figures.unsolvable(results)
    replanned, replan_time = figures.replans(results)
    intervals = figures.speedups(results) | proof_time | replan_time
    return {
        "seed": options.seed,
        "problems": options.problems,
        "planner_seeds": options.seeds,
        "opponents": options.opponents,
        **figures.bounds(intervals),
        **figures.quality(results),
        **proven,
        **replanned,
        "planner_ram_bytes": planner_bytes(),
        **chip,
        "one_session": not (options.reuse and options.opponents),
    }


def run_plan(options: Options, out: Console) -> bool:
    """Print the tables; True if every check holds."""
    if set(options.opponents) & set(OMPL) and not OMPL_DRIVER.exists():
        raise GroundError("OMPL's driver is missing: run `make bench-ompl`, or leave out ompl")
    families = make_families(options)
    session = Session(families, options.opponents, options.seed, options.seeds, options.reuse)
    results = session.run(out)
    homes = [problem for family in HOMES for problem in families[family]]
    taken = take_figures(options, results, chip_figures(homes, seed=1))
    found = {name: figures.finite(value) for name, value in taken.items()}
    checks = figures.checks(found)
    print_tables(results, checks, out)
    if options.json_file:
        write_report(options.json_file, found, checks)
    if options.plots:
        for path in write_plots(options.plots, families, results):
            out.print(f"drew {path}")
    return all(check.ok for check in checks)
