# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of sight: never across anything blocked, refused only next to it; corners by brute force.

The oracle counts in fractions: nothing here rests on rounding but what is tested.
"""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core import oracles
from tests.core.maps import (
    PER_CELL,
    SIDE,
    STEPS_MAX,
    Bits,
    Steps,
    blocked_bits,
    from_picture,
    in_cells,
    middle,
    sees,
    steps,
    with_walls,
)

MARGIN: int = lib.CLEARANCE_MARGIN_STEPS
LOW, HIGH = 58, 70  # a room across the border of two words
Cells = set[tuple[int, int]]
inside = st.integers(LOW, HIGH - 1)
walls = st.sets(st.tuples(inside, inside), max_size=50)
# Where rounding decides: at a side, a margin from it, a step beyond.
offsets = st.sampled_from([0, 1, MARGIN - 1, MARGIN, MARGIN + 1, PER_CELL // 2])
coordinates = st.one_of(
    st.integers(LOW * PER_CELL, HIGH * PER_CELL),
    st.builds(
        lambda cell, offset, sign: cell * PER_CELL + sign * offset,
        st.integers(LOW, HIGH),
        offsets,
        st.sampled_from([-1, 1]),
    ),
)
spots = st.tuples(coordinates, coordinates)
everywhere = st.integers(0, STEPS_MAX)


def free(blocked: Bits, a: Steps, b: Steps) -> bool:
    return oracles.segment_free(blocked, *in_cells([a, b]))


def nearest_squared_steps(blocked: Bits, a: Steps, b: Steps) -> float:
    """Squared distance of the segment to the nearest blocked cell."""
    cells = [(int(ix), int(iy)) for iy, ix in np.argwhere(blocked)]
    return float(min((oracles.squared_distance(a, b, c) for c in cells), default=np.inf))


@given(walls, spots, spots)
def test_what_is_seen_is_free_even_if_its_ends_are_moved_a_step_sideways(
    where: Cells, a: Steps, b: Steps
) -> None:
    _, clearance = with_walls(where)
    if sees(clearance, [a, b]):
        blocked = blocked_bits(clearance)
        for da, db in itertools.product((-1, 0, 1), repeat=2):
            assert free(blocked, (a[0] + da, a[1]), (b[0] + db, b[1]))


@given(walls, spots, spots)
def test_what_is_not_seen_passes_something_blocked_within_the_margin(
    where: Cells, a: Steps, b: Steps
) -> None:
    _, clearance = with_walls(where)
    if not sees(clearance, [a, b]):
        assert nearest_squared_steps(blocked_bits(clearance), a, b) < (MARGIN + 1) ** 2


@given(walls, spots, spots)
def test_sight_is_mutual(where: Cells, a: Steps, b: Steps) -> None:
    _, clearance = with_walls(where)
    assert sees(clearance, [a, b]) == sees(clearance, [b, a])


@given(
    everywhere, everywhere, everywhere, everywhere, st.sets(st.tuples(*[st.integers(0, 127)] * 2))
)
def test_long_lines_are_as_exact_as_short_ones(
    ax: int, ay: int, bx: int, by: int, where: Cells
) -> None:
    """Errors that grow with the length would show at the far end."""
    a, b = (ax, ay), (bx, by)
    beside = {
        (x + dx, y + dy)
        for x, y in oracles.cells_along(*in_cells([a, b]))
        for dx, dy in ((0, 1), (1, 0), (0, -1), (-1, 0))
        if 0 <= x + dx < SIDE and 0 <= y + dy < SIDE
    } - set(oracles.cells_along(*in_cells([a, b])))
    for cells in (beside, where):
        _, clearance = with_walls(cells)
        if sees(clearance, [a, b]):
            assert free(blocked_bits(clearance), a, b)
        else:
            squared = nearest_squared_steps(blocked_bits(clearance), a, b)
            assert squared < (MARGIN + 1) ** 2


def test_a_line_keeps_its_margin_and_no_more() -> None:
    _, clearance = with_walls([(64, 64)])
    side = 64 * PER_CELL
    for x, clear in ((side - MARGIN - 1, True), (side - MARGIN, False), (side, False)):
        assert sees(clearance, [(x, side - 500), (x, side + 900)]) == clear
    right = side + PER_CELL
    for x, clear in ((right + MARGIN, True), (right + MARGIN - 1, False), (right, False)):
        assert sees(clearance, [(x, side + 900), (x, side - 500)]) == clear


def test_nothing_is_seen_between_two_cells_that_touch_at_a_corner() -> None:
    _, clearance = with_walls(from_picture([".#", "#."], 10, 10))
    assert not sees(clearance, [middle((10, 11)), middle((11, 10))])
    _, clearance = with_walls(from_picture([".#", ".."], 10, 10))
    beside = [(x - 16, y - 16) for x, y in (middle((10, 11)), middle((11, 10)))]
    assert sees(clearance, beside)


def test_an_empty_grid_is_seen_from_corner_to_corner() -> None:
    _, clearance = with_walls([])
    corners = list(itertools.product((0, STEPS_MAX), repeat=2))
    assert all(sees(clearance, [a, b]) for a, b in itertools.product(corners, repeat=2))


@pytest.mark.parametrize("cell", [(0, 0), (31, 5), (32, 5), (127, 127)])
def test_a_point_sees_itself_exactly_if_it_is_free(cell: tuple[int, int]) -> None:
    _, clearance = with_walls([cell])
    assert not sees(clearance, [middle(cell)] * 2)
    _, clearance = with_walls([])
    assert sees(clearance, [middle(cell)] * 2)


def corners_of(clearance: CData) -> dict[tuple[int, int], int]:
    """Every corner of the grid by its vertex, with its kind."""
    kinds = ffi.new("uint32_t[]", lib.CLEARANCE_CORNER_KINDS)
    found: dict[tuple[int, int], int] = {}
    for iy, word in itertools.product(range(1, SIDE), range(SIDE // 32)):
        together = lib.clearance_corners(clearance, iy, word, kinds)
        assert together == kinds[0] | kinds[1] | kinds[2] | kinds[3]
        for kind, bit in itertools.product(range(lib.CLEARANCE_CORNER_KINDS), range(32)):
            if kinds[kind] >> bit & 1:
                assert (word * 32 + bit, iy) not in found
                found[word * 32 + bit, iy] = kind
    return found


def expected_corners(blocked: Bits) -> dict[tuple[int, int], int]:
    """Vertices with exactly one blocked cell of four, and which one."""
    which = {
        (-1, -1): lib.CLEARANCE_CORNER_LOWER_LEFT,
        (0, -1): lib.CLEARANCE_CORNER_LOWER_RIGHT,
        (-1, 0): lib.CLEARANCE_CORNER_UPPER_LEFT,
        (0, 0): lib.CLEARANCE_CORNER_UPPER_RIGHT,
    }
    found = {}
    for ix, iy in itertools.product(range(SIDE), range(1, SIDE)):
        there = [kind for (dx, dy), kind in which.items()
                 if oracles.is_blocked(blocked, (ix + dx, iy + dy))]  # fmt: skip
        if len(there) == 1:
            found[ix, iy] = there[0]
    return found


@given(walls, st.sets(st.tuples(st.integers(0, 127), st.integers(0, 127)), max_size=60))
def test_corners_are_where_one_of_four_cells_is_blocked(where: Cells, other: Cells) -> None:
    _, clearance = with_walls(where | other)
    blocked = blocked_bits(clearance)
    found = corners_of(clearance)
    assert found == expected_corners(blocked)
    for (ix, iy), kind in found.items():
        past = steps(lib.clearance_past_corner(ix, iy, kind))
        offset = [p - c * PER_CELL for p, c in zip(past, (ix, iy), strict=True)]
        assert [abs(d) for d in offset] == [lib.CLEARANCE_CORNER_STEPS] * 2
        opposite = (past[0] // PER_CELL, past[1] // PER_CELL)
        assert not blocked[opposite[1], opposite[0]]
        mirrored = (2 * ix - 1 - opposite[0], 2 * iy - 1 - opposite[1])
        assert oracles.is_blocked(blocked, mirrored)
        assert sees(clearance, [past, past])
