# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattice points: the rounding of places, and arithmetic that is exact up to the corners."""

import itertools
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from ground.core import ffi, lib
from tests.core.maps import (
    PER_CELL,
    SIDE,
    STEPS_MAX,
    Steps,
    in_cells,
    lattice,
    lattice_array,
    lattice_points,
    length,
    steps,
    vec2,
    xy,
)

coordinates = st.integers(0, STEPS_MAX)
spots = st.tuples(coordinates, coordinates)
corners = st.sampled_from([0, STEPS_MAX])
anywhere = st.one_of(spots, st.tuples(corners, corners))
ways = st.lists(spots, min_size=0, max_size=20)
in_grid = st.floats(0.0, float(SIDE), width=32, exclude_max=True)


def from_cells(x: float, y: float) -> Steps:
    return steps(lib.lattice_from_cells(vec2(x, y)))


@given(in_grid, in_grid)
@example(63.9999, 0.99999)
@example(math.nextafter(64.0, 0.0), 1e-30)
def test_a_place_stays_in_its_cell_and_near(x: float, y: float) -> None:
    x, y = xy(vec2(x, y))
    at_x, at_y = from_cells(x, y)
    assert (at_x // PER_CELL, at_y // PER_CELL) == (math.floor(x), math.floor(y))
    assert max(abs(at_x - x * PER_CELL), abs(at_y - y * PER_CELL)) < 1.0


@given(spots)
def test_there_and_back_is_the_same(at: Steps) -> None:
    (cells,) = in_cells([at])
    assert xy(lib.lattice_to_cells(lattice(at))) == cells
    assert from_cells(*cells) == at


@pytest.mark.parametrize(
    ("outside", "inside"),
    [
        ((-0.001, 128.0), (0, STEPS_MAX)),
        ((-1e30, 1e30), (0, STEPS_MAX)),
        ((math.inf, -math.inf), (STEPS_MAX, 0)),
        ((math.nan, math.nan), (0, 0)),
    ],
)
def test_what_lies_outside_comes_in(outside: tuple[float, float], inside: Steps) -> None:
    assert from_cells(*outside) == inside


@given(anywhere, anywhere, anywhere)
def test_the_side_of_a_point_is_exact(o: Steps, a: Steps, b: Steps) -> None:
    exact = (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    assert lib.lattice_cross(lattice(o), lattice(a), lattice(b)) == exact


def test_the_side_of_a_point_is_exact_in_the_corners_of_the_grid() -> None:
    square = list(itertools.product((0, 1, STEPS_MAX - 1, STEPS_MAX), repeat=2))
    for o, a, b in itertools.product(square, repeat=3):
        exact = (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
        assert lib.lattice_cross(lattice(o), lattice(a), lattice(b)) == exact


@given(anywhere, anywhere)
def test_a_distance_is_in_cells_and_the_same_back(a: Steps, b: Steps) -> None:
    there = lib.lattice_distance(lattice(a), lattice(b))
    assert there == pytest.approx(math.dist(*in_cells([a, b])), rel=1e-6)
    assert there == lib.lattice_distance(lattice(b), lattice(a))
    assert (there == 0.0) == (a == b) == lib.lattice_equal(lattice(a), lattice(b))


@given(ways)
def test_a_way_is_as_long_as_its_pieces_and_turns_round(way: list[Steps]) -> None:
    array = lattice_array(way)
    long = lib.lattice_length(array, len(way))
    assert long == pytest.approx(length(in_cells(way)), rel=1e-5)
    lib.lattice_reverse(array, len(way))
    assert lattice_points(array, len(way)) == way[::-1]
    assert all(steps(array[i]) == (0, 0) for i in range(len(way), 64))


def test_a_point_takes_four_bytes() -> None:
    assert ffi.sizeof("lattice_t") == 4
