# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench's geometry against a slow solver in rational numbers, and what its checker rejects."""

import heapq
import math
from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.bench.plan.exact import Bits, ExactMap

Point = tuple[Fraction, Fraction]
HALF = Fraction(1, 2)


def blocked(cells: Bits, x: int, y: int) -> bool:
    height, width = cells.shape
    return not (0 <= x < width and 0 <= y < height) or bool(cells[y, x])


def touching(at: Fraction) -> set[int]:
    """The cells along one axis that contain a coordinate: two on a border."""
    return {math.floor(at), math.ceil(at) - 1}


def is_pinch(cells: Bits, x: Fraction, y: Fraction) -> bool:
    """Two blocked cells touch here diagonally, and the other two are free."""
    if x.denominator != 1 or y.denominator != 1:
        return False
    low_left, low_right, high_left, high_right = (
        blocked(cells, int(x) + dx, int(y) + dy) for dy, dx in product((-1, 0), (-1, 0))
    )
    return low_left == high_right != low_right == high_left


def sees(cells: Bits, a: Point, b: Point) -> bool:
    """Cut the segment at each lattice line, and look at the middle of each piece."""
    cuts = {Fraction(0), Fraction(1)}
    for start, end in zip(a, b, strict=True):
        if start != end:
            lines = range(math.ceil(min(start, end)), math.floor(max(start, end)) + 1)
            cuts |= {(line - start) / (end - start) for line in lines}

    def at(part: Fraction) -> Point:
        return (a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]))

    ordered = sorted(cuts)
    for low, high in pairwise(ordered):
        x, y = at((low + high) / 2)
        if all(blocked(cells, i, j) for i in touching(x) for j in touching(y)):
            return False
    return not any(is_pinch(cells, *at(part)) for part in ordered)


def slow_optimum(cells: Bits, start: Point, goal: Point) -> float:
    """Dijkstra's algorithm over all lattice corners at which a path may be."""
    height, width = cells.shape
    corners = [
        (Fraction(x), Fraction(y))
        for x, y in product(range(width + 1), range(height + 1))
        if not all(blocked(cells, i, j) for i in (x - 1, x) for j in (y - 1, y))
    ]
    places = [start, goal, *corners]
    best, done, ahead = {0: 0.0}, set[int](), [(0.0, 0)]
    while ahead:
        cost, here = heapq.heappop(ahead)
        if here == 1:
            return cost
        if here in done:
            continue
        done.add(here)
        for there in set(range(len(places))) - done:
            through = cost + math.dist(places[here], places[there])
            if through < best.get(there, math.inf) - 1e-12 and sees(
                cells, places[here], places[there]
            ):
                best[there] = through
                heapq.heappush(ahead, (through, there))
    return math.inf


@st.composite
def small_problems(draw: st.DrawFn) -> tuple[Bits, Point, Point]:
    side = draw(st.integers(3, 7))
    share = draw(st.sampled_from([0.15, 0.3, 0.45]))
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    cells = rng.random((side, side)) < share
    ends = rng.integers(side, size=4)
    cells[ends[1], ends[0]] = cells[ends[3], ends[2]] = False
    start, goal = (
        (Fraction(int(x)) + HALF, Fraction(int(y)) + HALF) for x, y in (ends[:2], ends[2:])
    )
    return cells, start, goal


def as_floats(point: Point) -> tuple[float, float]:
    return (float(point[0]), float(point[1]))


@settings(max_examples=40, deadline=None)
@given(small_problems())
def test_the_optimum_is_that_of_a_slow_solver(problem: tuple[Bits, Point, Point]) -> None:
    cells, start, goal = problem
    exact = ExactMap(cells)
    length, way = exact.optimum(as_floats(start), as_floats(goal))
    assert length == pytest.approx(slow_optimum(cells, start, goal), abs=1e-9)
    reached = exact.reachable(int(start[0]), int(start[1]))
    assert math.isfinite(length) == reached[int(goal[1]), int(goal[0])]
    if math.isfinite(length):
        assert exact.way_length(way) == pytest.approx(length, abs=1e-9)


@settings(max_examples=300, deadline=None)
@given(small_problems(), st.data())
def test_sight_is_that_of_rational_numbers(
    problem: tuple[Bits, Point, Point], data: st.DataObject
) -> None:
    """Between any two places of a lattice of quarter cells, in cells and on their borders."""
    cells, _, _ = problem
    quarter = st.integers(0, 4 * len(cells)).map(lambda k: Fraction(k, 4))
    a, b = data.draw(st.tuples(quarter, quarter)), data.draw(st.tuples(quarter, quarter))
    if a != b:
        assert ExactMap(cells).sees(as_floats(a), as_floats(b)) == sees(cells, a, b)


def drawn(*rows: str) -> ExactMap:
    """Parse a picture: the first row is y = 0, # is blocked."""
    return ExactMap(np.array([[sign == "#" for sign in row] for row in rows]))


ROOM = drawn(
    ".....",
    ".##..",
    ".##..",
    "...#.",
    ".....",
)  # fmt: skip


@pytest.mark.parametrize(
    ("way", "why"),
    [
        ([(0.5, 0.5), (4.5, 4.5)], "straight through"),
        ([(0.5, 1.5), (1.0001, 1.5), (0.5, 2.5)], "a tenth of a millimetre into a cell"),
        ([(2.0, 0.5), (2.0, 3.5)], "along the seam of two blocked cells"),
        ([(2.5, 3.5), (3.5, 2.5)], "between two cells that touch at a corner"),
        ([(2.5, 3.5), (3.0, 3.0), (3.5, 2.5)], "the same with a point at that corner"),
        ([(0.5, 0.5), (-0.5, 0.5), (0.5, 1.5)], "off the map"),
        ([(0.5, 0.5), (math.nan, 0.5)], "no number"),
        ([(0.5, 0.5), (math.inf, 0.5)], "not finite"),
    ],
)
def test_a_way_that_breaks_a_rule_is_found(way: list[tuple[float, float]], why: str) -> None:
    assert ROOM.way_length(way) is None, why


@pytest.mark.parametrize(
    ("way", "length"),
    [
        ([(0.5, 0.5), (0.5, 4.5)], 4.0),
        ([(1.0, 0.5), (1.0, 4.5)], 4.0),
        ([(0.5, 0.5), (3.0, 1.0), (3.0, 2.5)], math.hypot(2.5, 0.5) + 1.5),
    ],
    ids=["straight", "along a wall", "round a corner"],
)
def test_a_way_that_grazes_is_free(way: list[tuple[float, float]], length: float) -> None:
    assert ROOM.way_length(way) == pytest.approx(length)


def test_clearance_is_the_distance_to_the_nearest_blocked_cell() -> None:
    assert ROOM.clearance([(0.5, 0.5), (0.5, 4.5)]) == pytest.approx(0.5)
    assert ROOM.clearance([(4.5, 0.0), (4.5, 2.0)]) == pytest.approx(math.hypot(0.5, 1.0))
    assert ROOM.clearance([(0.5, 0.5), (4.5, 4.5)]) == 0.0
