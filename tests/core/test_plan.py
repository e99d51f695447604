# SPDX-License-Identifier: GPL-3.0-or-later
"""The planner from Python: three lines for a path, and a clear error for invalid input."""

import math
import re
from itertools import pairwise

import numpy as np
import pytest

import ground.plan
from ground.plan import Status, plan

ROOM = np.zeros((100, 120), dtype=bool)


def walled() -> np.ndarray:
    room = ROOM.copy()
    room[:80, 60] = True
    return room


def test_the_three_lines_of_the_documentation_run(capsys: pytest.CaptureFixture[str]) -> None:
    lines = re.findall(r"^    (\w.*)$", ground.plan.__doc__ or "", re.MULTILINE)
    exec("\n".join(lines), {"blocked": ROOM})
    assert capsys.readouterr().out.startswith("FOUND 82.4")


def test_a_way_round_a_wall_is_the_shortest() -> None:
    way = plan(walled(), (20.5, 20.5), (100.5, 20.5))
    shortest = 2 * math.dist((20.5, 20.5), (60.0, 80.0)) + 1.0
    assert way.status is Status.FOUND
    assert shortest - 0.05 <= way.length <= 1.01 * shortest
    assert way.length == pytest.approx(sum(math.dist(a, b) for a, b in pairwise(way.points)))
    assert 0 < way.first_samples <= way.samples
    assert way.nearest is None


def test_the_clearance_is_kept() -> None:
    near, wide = (plan(walled(), (20.5, 20.5), (100.5, 20.5), clearance=c) for c in (0.0, 6.0))
    assert wide.length > near.length + 5.0
    corner = min(math.dist(point, (60.5, 80.0)) for point in wide.points)
    assert corner >= 6.0


def test_more_samples_never_make_it_worse_and_the_seed_decides() -> None:
    maze = np.random.default_rng(3).random((128, 128)) < 0.04
    maze[5, 5] = maze[120, 120] = False
    ends = ((5.5, 5.5), (120.5, 120.5))
    lengths = [plan(maze, *ends, samples=n).length for n in (50, 200, 800, 2000)]
    assert lengths == sorted(lengths, reverse=True)
    again = plan(maze, *ends, samples=200)
    assert again.length == lengths[1]
    assert again.samples == 200
    others = {plan(maze, *ends, samples=200, seed=seed).first_samples for seed in range(5)}
    assert len(others) > 1


def test_the_step_may_follow_the_obstacles() -> None:
    way = plan(walled(), (20.5, 20.5), (100.5, 20.5), adaptive=True)
    assert way.status is Status.FOUND


def test_no_way_is_a_result_with_the_nearest_place() -> None:
    room = walled()
    room[:, 60] = True
    way = plan(room, (20.5, 20.5), (100.5, 30.5))
    assert way.status is Status.NO_WAY
    assert len(way.points) == 0
    assert way.length == math.inf
    assert way.nearest == (59.5, 30.5)


@pytest.mark.parametrize(
    ("start", "goal", "status"),
    [
        ((60.5, 10.5), (10.5, 10.5), Status.START_BLOCKED),
        ((10.5, 10.5), (60.5, 10.5), Status.GOAL_BLOCKED),
        ((10.5, 10.5), (121.0, 10.5), Status.GOAL_BLOCKED),
        ((10.5, 10.5), (10.5, -3.0), Status.GOAL_BLOCKED),
        ((math.nan, 10.5), (10.5, 10.5), Status.START_BLOCKED),
    ],
)
def test_blocked_ends_are_said(
    start: tuple[float, float], goal: tuple[float, float], status: Status
) -> None:
    assert plan(walled(), start, goal).status is status


@pytest.mark.parametrize("shape", [(0, 5), (129, 5), (5,), (4, 4, 4)])
def test_a_map_of_another_shape_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="two dimensions"):
        plan(np.zeros(shape, dtype=bool), (0.5, 0.5), (1.5, 1.5))


@pytest.mark.parametrize("clearance", [-1.0, 13.0, math.nan])
def test_a_clearance_out_of_range_is_refused(clearance: float) -> None:
    with pytest.raises(ValueError, match="clearance"):
        plan(ROOM, (1.5, 1.5), (2.5, 2.5), clearance=clearance)
