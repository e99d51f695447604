# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeded planning problems: a map, a start and a goal out of its sight, and the exact optimum."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.bench.plan.drawing import CELL_M, SIDE, inflated
from tests.bench.plan.exact import Bits, ExactMap, Place
from tests.bench.plan.families import DRAWN, Draw

APART_CELLS = 2.0 / CELL_M
MAGIC = b"WAYPLAN1"
_CHANGE_TRIES = 24


@dataclass(frozen=True, slots=True)
class Problem:
    """A map's obstacles, as they are and inflated; places and lengths in cells."""

    family: str
    raw: Bits
    blocked: Bits
    start: Place
    goal: Place
    optimum: float
    """Infinite where there is no way."""
    way: tuple[Place, ...] = ()
    """A shortest one."""


def _centre(x: int, y: int) -> Place:
    return (x + 0.5, y + 0.5)


def _ends(rng: np.random.Generator, blocked: Bits) -> tuple[Place, Place] | None:
    """Draw start and goal: connected, at least 2 m apart, without line of sight."""
    exact = ExactMap(blocked)
    free = np.argwhere(~blocked)
    if len(free) < 500:
        return None
    for _ in range(60):
        y, x = map(int, free[rng.integers(len(free))])
        region = exact.reachable(x, y)
        if region.mean() < 0.15:
            continue
        far = np.argwhere(region)
        far = far[np.hypot(far[:, 0] - y, far[:, 1] - x) >= APART_CELLS]
        for goal_y, goal_x in far[rng.integers(len(far), size=10)] if len(far) else ():
            start, goal = _centre(x, y), _centre(int(goal_x), int(goal_y))
            if not exact.sees(start, goal):
                return start, goal
    return None


def make_problem(family: str, draw: Draw, rng: np.random.Generator) -> Problem:
    """Make a problem that has a solution."""
    while True:
        raw = draw(rng)
        blocked = inflated(raw)
        ends = _ends(rng, blocked)
        if ends is not None:
            optimum, way = ExactMap(blocked).optimum(*ends)
            return Problem(family, raw, blocked, *ends, optimum, tuple(way))


def walled_off(problem: Problem, rng: np.random.Generator) -> Problem:
    """Close a wall around the goal: there is no path, and both ends are free."""
    goal_x, goal_y = map(int, problem.goal)
    distance = max(abs(a - b) for a, b in zip(problem.start, problem.goal, strict=True))
    half = int(rng.integers(6, max(7, min(30, int(distance) - 6))))
    raw = problem.raw.copy()
    ring = np.zeros_like(raw)
    ring[max(goal_y - half, 0) : goal_y + half + 1, max(goal_x - half, 0) : goal_x + half + 1] = (
        True
    )
    inner = half - 2
    ring[
        max(goal_y - inner, 0) : goal_y + inner + 1, max(goal_x - inner, 0) : goal_x + inner + 1
    ] = False
    raw |= ring
    return replace(problem, raw=raw, blocked=inflated(raw), optimum=float("inf"), way=())


def closed_on_the_way(problem: Problem, rng: np.random.Generator) -> Problem | None:
    """Close the shortest path, as a door does, so that another path is left."""
    for _ in range(_CHANGE_TRIES):
        leg = int(rng.integers(len(problem.way) - 1))
        part = rng.random()
        x, y = (
            round(a + part * (b - a))
            for a, b in zip(problem.way[leg], problem.way[leg + 1], strict=True)
        )
        raw = problem.raw.copy()
        half = int(rng.integers(2, 9))
        raw[max(y - 1, 0) : y + 2, max(x - half, 0) : x + half + 1] = True
        raw[max(y - half, 0) : y + half + 1, max(x - 1, 0) : x + 2] = True
        blocked = inflated(raw)
        ends = (problem.start, problem.goal)
        if any(blocked[int(y)][int(x)] for x, y in ends):
            continue
        optimum, way = ExactMap(blocked).optimum(*ends)
        if problem.optimum * 1.001 < optimum < float("inf"):
            changed = replace(problem, raw=raw, blocked=blocked, optimum=optimum, way=tuple(way))
            return changed
    return None


def make_set(seed: int, count: int, families: Mapping[str, Draw] = DRAWN) -> list[Problem]:
    """Make so many problems, the families in turn: same seed, same problems."""
    names = list(families)
    return [
        make_problem(name, families[name], np.random.default_rng([seed, number, k]))
        for number, name in enumerate(names)
        for k in range((count + len(names) - 1 - number) // len(names))
    ]


def make_unsolvable(problems: Iterable[Problem], seed: int) -> list[Problem]:
    rng = np.random.default_rng([seed, len(MAGIC)])
    return [walled_off(problem, rng) for problem in problems]


def make_changes(problems: Iterable[Problem], seed: int) -> list[tuple[Problem, Problem]]:
    """Problems before and after a change, where another path is left."""
    rng = np.random.default_rng([seed, SIDE])
    pairs = [(problem, closed_on_the_way(problem, rng)) for problem in problems]
    return [(before, after) for before, after in pairs if after is not None]


def write_problems(path: Path, problems: Iterable[Problem]) -> None:
    """Write problems in the format that drive.h reads."""
    listed = list(problems)
    with path.open("wb") as file:
        file.write(MAGIC + struct.pack("<I", len(listed)))
        for problem in listed:
            optimum = problem.optimum if np.isfinite(problem.optimum) else -1.0
            file.write(struct.pack("<5d", optimum, *problem.start, *problem.goal))
            file.write(problem.raw.astype(np.uint8).tobytes())
            file.write(problem.blocked.astype(np.uint8).tobytes())
