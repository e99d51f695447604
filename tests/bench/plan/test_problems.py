# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench's problems: the same seed gives the same ones, and they are what they claim to be."""

import math
from pathlib import Path

import numpy as np
import pytest

from ground.errors import GroundError
from tests.bench.plan.drawing import SIDE, inflated, least_clearance
from tests.bench.plan.exact import ExactMap
from tests.bench.plan.families import DRAWN
from tests.bench.plan.movingai import crop, crops_of, load_map
from tests.bench.plan.problems import (
    APART_CELLS,
    Problem,
    make_changes,
    make_problem,
    make_set,
    make_unsolvable,
    write_problems,
)

SEED = 5
PROBLEMS = make_set(SEED, 10)


def bytes_of(problems: list[Problem], folder: Path) -> bytes:
    path = folder / "problems.bin"
    write_problems(path, problems)
    return path.read_bytes()


def test_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    first, again, other = (
        bytes_of(make_set(seed, 10), tmp_path) for seed in (SEED, SEED, SEED + 1)
    )
    assert first == again == bytes_of(PROBLEMS, tmp_path)
    assert first != other
    assert len(first) == 12 + 10 * (40 + 2 * SIDE * SIDE)


def test_every_family_has_its_share() -> None:
    assert [problem.family for problem in make_set(SEED, 7)] == [
        "furniture", "furniture", "rooms", "rooms", "maze", "clutter", "caverns",
    ]  # fmt: skip


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.family)
def test_a_problem_has_a_way_and_is_not_trivial(problem: Problem) -> None:
    exact = ExactMap(problem.blocked)
    apart = math.dist(problem.start, problem.goal)
    assert np.array_equal(problem.blocked, inflated(problem.raw))
    assert apart >= APART_CELLS
    assert not exact.sees(problem.start, problem.goal)
    assert apart < problem.optimum < math.inf
    assert exact.way_length(problem.way) == pytest.approx(problem.optimum)
    assert ExactMap(problem.raw).clearance(problem.way) >= least_clearance()


def test_walled_off_goals_are_free_and_cannot_be_reached() -> None:
    for problem in make_unsolvable(PROBLEMS, SEED):
        start_x, start_y = map(int, problem.start)
        goal_x, goal_y = map(int, problem.goal)
        reached = ExactMap(problem.blocked).reachable(start_x, start_y)
        assert reached[start_y, start_x]
        assert not problem.blocked[goal_y, goal_x]
        assert not reached[goal_y, goal_x]


def test_after_a_change_the_old_way_is_closed_and_another_is_left() -> None:
    pairs = make_changes(PROBLEMS, SEED)
    assert len(pairs) >= len(PROBLEMS) // 2
    for before, after in pairs:
        exact = ExactMap(after.blocked)
        assert (before.blocked <= after.blocked).all()
        assert exact.way_length(before.way) is None
        assert before.optimum < after.optimum < math.inf
        assert exact.way_length(after.way) == pytest.approx(after.optimum)


def test_inflation_blocks_a_disc_and_the_rim() -> None:
    cells = np.zeros((15, 15), bool)
    cells[7, 7] = True
    wide = inflated(cells)
    y, x = np.mgrid[0:15, 0:15]
    rim = np.minimum.reduce([x, y, 14 - x, 14 - y]) < 3
    assert np.array_equal(wide, rim | ((x - 7) ** 2 + (y - 7) ** 2 <= 9))
    assert least_clearance() == 2.0


@pytest.mark.parametrize("family", DRAWN)
def test_maps_of_a_family_differ(family: str) -> None:
    first, second = (DRAWN[family](np.random.default_rng(k)) for k in (1, 2))
    assert first.shape == second.shape == (SIDE, SIDE)
    assert (first != second).any()


def movingai_text(cells: np.ndarray) -> str:
    height, width = cells.shape
    signs = np.where(cells, "@", ".")
    signs[0, 0], signs[0, 1], signs[0, 2] = "T", "G", "W"
    rows = "\n".join("".join(row) for row in signs)
    return f"type octile\nheight {height}\nwidth {width}\nmap\n{rows}\n"


def test_a_movingai_map_is_read_as_its_format_says(tmp_path: Path) -> None:
    path = tmp_path / "small.map"
    path.write_text("type octile\r\nheight 2\r\nwidth 5\r\nmap\r\n.GS@T\r\nOW..@\r\n")
    assert load_map(path).astype(int).tolist() == [[0, 0, 0, 1, 1], [1, 1, 0, 0, 1]]


@pytest.mark.parametrize("text", ["", "type octile\nheight 3\nwidth 2\nmap\n..\n..\n", "map"])
def test_what_is_no_map_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "broken.map"
    path.write_text(text)
    with pytest.raises(GroundError, match=r"broken\.map"):
        load_map(path)


def test_a_crop_keeps_what_most_of_the_cells_are() -> None:
    large = np.kron(np.eye(SIDE, dtype=bool), np.ones((3, 3), bool))
    found = {crop(large, np.random.default_rng(k)).sum() for k in range(20)}
    assert SIDE in found  # the whole map, three cells as one
    assert len(found) > 1


def test_crops_of_a_folder_become_problems(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "cave.map").write_text(movingai_text(DRAWN["caverns"](rng)))
    problem = make_problem("movingai", crops_of(tmp_path), rng)
    assert problem.family == "movingai"
    with pytest.raises(GroundError, match=r"no \.map files"):
        crops_of(tmp_path / "nowhere")
