# SPDX-License-Identifier: GPL-3.0-or-later
"""The arithmetic from the drivers' numbers to the report, and checks of the drivers themselves."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from ground.errors import GroundError
from tests.bench.plan import figures
from tests.bench.plan.command import Options, run_plan
from tests.bench.plan.figures import Results
from tests.bench.plan.problems import make_set, make_unsolvable, write_problems
from tests.bench.plan.python_rrtstar import run_plain
from tests.bench.plan.ratios import by_problem, geometric_ratio, percentile, tail_ratio
from tests.bench.plan.runs import (
    ASTAR,
    CONNECT,
    OURS,
    THETA,
    Columns,
    Task,
    read_columns,
    run_ours,
    runner,
    write_columns,
)
from tests.tools.needed import need

INFORMED = "Informed RRT* tuned"


def runs(times_s: list[float], **others: float) -> Columns:
    """Runs with two seeds of each problem, which took the same time."""
    count = len(times_s)
    columns = {name: np.array(times_s * 2) for name in figures.TIMES}
    columns["problem"] = np.array(list(range(count)) * 2, float)
    defaults = {
        "enough_s": 2.0e-4,
        "enough_cost": 10.2,
        "cost": 10.0,
        "fixed_cost": 10.0,
        "flown_cost": 10.1,
        "optimum": 10.0,
        "clearance": 2.5,
        "invalid": 0.0,
    }
    return columns | {
        name: np.full(2 * count, value) for name, value in (defaults | others).items()
    }


def results(**plans: Columns) -> Results:
    names = {"ours": OURS, "connect": CONNECT, "theta": THETA, "informed": INFORMED}
    return Results({names[key]: {"maze": found} for key, found in plans.items()})


def test_a_constant_ratio_is_certain() -> None:
    ours = np.array([[0.1, 0.2], [0.3, 0.4], [0.01, 0.02]])
    for found in (geometric_ratio(3 * ours, ours), tail_ratio(3 * ours, ours)):
        assert (found.value, found.low, found.high) == pytest.approx((3.0, 3.0, 3.0))


def test_the_geometric_mean_treats_faster_and_slower_alike() -> None:
    ours, theirs = np.array([[1.0], [1.0]]), np.array([[4.0], [0.25]])
    found = geometric_ratio(theirs, ours)
    assert found.value == pytest.approx(1.0)
    assert found.low < 1.0 < found.high


def test_the_interval_narrows_with_more_problems() -> None:
    rng = np.random.default_rng(3)

    def width(count: int) -> float:
        found = geometric_ratio(np.exp(rng.normal(1.0, 0.5, (count, 1))), np.ones((count, 1)))
        assert found.low < math.e < found.high
        return found.high - found.low

    assert width(400) < 0.7 * width(50)


def test_what_was_not_reached_took_the_budget() -> None:
    columns = {"problem": np.array([0.0, 1, 0, 1]), "first_s": np.array([0.1, math.inf, 0.3, 0.2])}
    assert by_problem(columns, "first_s", 1.0).tolist() == [[0.1, 0.3], [1.0, 0.2]]


def test_a_percentile_of_infinite_times_is_infinite() -> None:
    assert percentile(np.array([1.0] * 9 + [math.inf]), 95) == math.inf
    assert percentile(np.array([1.0] * 9 + [math.inf]), 50) == 1.0


def test_the_rival_that_comes_closest_counts() -> None:
    found = figures.speedups(
        results(ours=runs([1.0e-4] * 4), connect=runs([2.0e-4] * 4), informed=runs([5.0e-4] * 4))
    )
    assert found["t105_speedup_vs_best_optimal"].low == pytest.approx(5.0)
    assert found["p95_t105_speedup_vs_any_ompl"].low == pytest.approx(2.0)
    assert found["t105_speedup_vs_rrtconnect_maze"].value == pytest.approx(2.0)
    assert "t105_speedup_vs_theta" not in found


def test_only_what_was_measured_is_checked_and_the_worse_bound_counts() -> None:
    ours, theta = runs([1.0e-4] * 4), runs([1.0e-4, 1.0e-4, 9.0e-4, 9.0e-4])
    taken = figures.bounds(figures.speedups(results(ours=ours, theta=theta)))
    assert taken["t105_speedup_vs_theta_estimate"] == pytest.approx(3.0)
    (check,) = [check for check in figures.checks(taken) if check.name == "t105_speedup_vs_theta"]
    assert check.value == taken["t105_speedup_vs_theta"]
    assert check.value < 2.0
    assert not check.ok
    assert "chip_first_ms_p95" not in {check.name for check in figures.checks(taken)}


@pytest.mark.parametrize(
    ("changed", "collisions", "solved"),
    [({}, 0, 1.0), ({"invalid": 1.0}, 8, 1.0), ({"clearance": 1.9}, 8, 1.0),
     ({"cost": math.inf, "fixed_cost": math.inf}, 0, 0.0)],
    ids=["sound", "broken rule", "too near", "unsolved"],
)  # fmt: skip
def test_broken_ways_are_counted(changed: dict[str, float], collisions: int, solved: float) -> None:
    found = figures.quality(results(ours=runs([1.0e-4] * 4, **changed)))
    assert found["collisions"] == collisions
    assert found["solved_fraction"] == solved


def test_a_collision_after_a_change_counts() -> None:
    found = results(ours=runs([1.0e-4] * 4))
    found.replans = {"repair": runs([1.0e-5] * 4, invalid=1.0), "anew": runs([1.0e-4] * 4)}
    assert figures.quality(found)["collisions"] == 8
    solved, ratios = figures.replans(found)
    assert solved["replan_solved"] == 1.0
    assert ratios["replan_ratio_first"].value == pytest.approx(0.1)


def test_columns_survive_being_written() -> None:
    columns = {"first_s": np.array([0.25, math.inf]), "nodes": np.array([3.0, -1.0])}
    again = read_columns(write_columns(columns))
    assert {name: column.tolist() for name, column in again.items()} == {
        name: column.tolist() for name, column in columns.items()
    }


def test_no_driver_returns_a_way_that_breaks_a_rule(tmp_path: Path) -> None:
    problems = make_set(6, 10)
    optimum = np.array([problem.optimum for problem in problems])
    path = tmp_path / "problems.bin"
    write_problems(path, problems)
    for name in (OURS, ASTAR, THETA):
        found = runner(name)(Task(path, 1))
        solved = np.isfinite(found["cost"])
        assert solved.sum() >= 5
        assert found["invalid"].sum() == 0
        assert (found["cost"] >= optimum - 0.01)[solved].all()
        assert (found["cost"] < 1.4 * optimum)[solved].all()
        assert (found["clearance"][solved] >= 2.0 - 1e-3).all()
        assert (found["first_s"] <= found["within_105_s"]).all()
        assert (found["within_105_s"] <= found["within_102_s"]).all()


def test_no_driver_finds_a_way_where_there_is_none(tmp_path: Path) -> None:
    path = tmp_path / "problems.bin"
    write_problems(path, make_unsolvable(make_set(6, 5), 6))
    for found in (run_ours(Task(path, 1), "prove"), runner(ASTAR)(Task(path, 1))):
        assert (found["cost"] == math.inf).all()
        assert (found["end_s"] > 0).all()


def test_plain_python_finds_a_way(tmp_path: Path) -> None:
    problem = make_set(6, 5)[0]
    found = run_plain(problem, 1)
    assert problem.optimum <= found["cost"] < 1.5 * problem.optimum
    assert 0 < found["first_s"] <= found["end_s"]


def test_without_its_driver_ompl_is_not_compared_with(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("tests.bench.plan.command.OMPL_DRIVER", tmp_path / "absent")
    with pytest.raises(GroundError, match="make bench-ompl"):
        run_plan(Options(against=("ompl",)), Console(quiet=True))


def test_the_command_writes_every_figure_it_checks(tmp_path: Path) -> None:
    need("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi", "planning on the chip")
    file = tmp_path / "out.json"
    options = Options(
        seed=6, problems=10, against=("astar",), seeds=1, json_file=file, plots=tmp_path
    )
    holds = run_plan(options, Console(quiet=True))
    written = json.loads(file.read_text())
    assert holds == all(check["ok"] for check in written["checks"])
    assert {check["name"]: check["value"] for check in written["checks"]}.items() <= written.items()
    assert written["opponents"] == [ASTAR]
    assert written["unsolvable_proven"] == 1.0
    assert written["chip_same_bits"] is True
    assert {path.name for path in tmp_path.glob("*.png")} == {
        "problems.png", "speedups.png", "times.png",
    }  # fmt: skip
