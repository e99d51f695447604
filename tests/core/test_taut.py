# SPDX-License-Identifier: GPL-3.0-or-later
"""Pulling a path taut: the shortest on its side of every obstacle, and clear at every step."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core import oracles
from tests.core.maps import (
    PER_CELL,
    SIDE,
    Cell,
    Point,
    Steps,
    blocked_bits,
    from_picture,
    in_cells,
    is_clear,
    lattice_points,
    length,
    middle,
    raw_bytes,
    sees,
    with_walls,
)

CAPACITY: int = lib.TAUT_POINTS
PAST = lib.CLEARANCE_CORNER_STEPS / PER_CELL
STEPS_MAX = 2000
inside = st.tuples(st.integers(54, 73), st.integers(54, 73))
walls = st.sets(inside, max_size=120)
stops = st.lists(inside, min_size=2, max_size=5)


def begin(way: list[Steps]) -> CData:
    taut = ffi.new("taut_t *")
    for i, (x, y) in enumerate(way):
        taut.points[i].x, taut.points[i].y = x, y
    lib.taut_start(taut, len(way))
    return taut


def points_of(taut: CData) -> list[Steps]:
    return lattice_points(taut.points, taut.count)


def pulled(clearance: CData, way: list[Steps]) -> list[Steps]:
    taut = begin(way)
    for _ in range(STEPS_MAX):
        if lib.taut_step(taut, clearance):
            return points_of(taut)
    raise AssertionError("it does not end")


def wander(clearance: CData, cells: list[Cell]) -> list[Steps]:
    """From stop to stop, each by the wave; shorter where a stop cannot be reached or there is no
    room."""
    wave, array = ffi.new("wavefront_t *"), ffi.new("lattice_t[]", CAPACITY)
    way = [middle(cells[0])]
    for target, root in itertools.pairwise(cells):
        places = [ffi.new("grid_cell_t *", cell)[0] for cell in (root, target)]
        lib.wavefront_start(wave, lib.WAVEFRONT_TO_CELL, *places)
        lib.wavefront_extend(wave, clearance, ffi.NULL, 1000)
        count = lib.wavefront_path(wave, clearance, array, CAPACITY, SIDE * SIDE)
        leg = lattice_points(array, count)
        if not leg or len(way) + len(leg) > CAPACITY:
            break
        way += leg[::-1][1:] if leg[0] != way[-1] else leg[1:]
    return way


def ways_in(where: set[Cell], cells: list[Cell]) -> tuple[CData, list[Steps]]:
    _, clearance = with_walls(where - set(cells))
    way = wander(clearance, cells)
    assert sees(clearance, way)
    return clearance, way


def cells_length(way: list[Steps]) -> float:
    return length(in_cells(way))


@given(walls, stops)
def test_ends_are_kept_and_every_step_is_clear_and_never_longer(
    where: set[Cell], cells: list[Cell]
) -> None:
    clearance, way = ways_in(where, cells)
    taut, before = begin(way), cells_length(way)
    done = taut.stage == lib.TAUT_DONE
    while not done:
        done = lib.taut_step(taut, clearance)
        now = points_of(taut)
        assert sees(clearance, now)
        assert is_clear(clearance, in_cells(now))
        assert {now[0], now[-1]} == {way[0], way[-1]}
        assert cells_length(now) <= before + 1e-4
        before = cells_length(now)
    now = points_of(taut)
    assert (now[0], now[-1]) == (way[0], way[-1])


@given(walls, stops)
def test_pulling_again_gains_nothing(where: set[Cell], cells: list[Cell]) -> None:
    clearance, way = ways_in(where, cells)
    once = pulled(clearance, way)
    assert pulled(clearance, once) == once


@given(walls, stops)
def test_each_point_between_lies_just_past_a_corner_that_the_way_turns_round(
    where: set[Cell], cells: list[Cell]
) -> None:
    clearance, way = ways_in(where, cells)
    now = pulled(clearance, way)
    blocked = blocked_bits(clearance)
    for a, b, c in zip(now, now[1:], now[2:], strict=False):
        assert not sees(clearance, [a, c])
        vertex = [round(x / PER_CELL) for x in b]
        offset = [x - v * PER_CELL for x, v in zip(b, vertex, strict=True)]
        assert [abs(d) for d in offset] == [lib.CLEARANCE_CORNER_STEPS] * 2
        cell = vertex[0] - (offset[0] > 0), vertex[1] - (offset[1] > 0)
        assert oracles.is_blocked(blocked, cell)
        turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        inwards = turn * ((c[0] - a[0]) * -offset[1] - (c[1] - a[1]) * -offset[0])
        assert inwards > 0


@given(walls, stops)
def test_a_step_is_bounded_and_the_slicing_does_not_matter(
    where: set[Cell], cells: list[Cell]
) -> None:
    clearance, way = ways_in(where, cells)
    taut = begin(way)
    count = 0
    while taut.stage != lib.TAUT_DONE:
        lib.taut_step(taut, clearance)
        count += 1
    assert count <= 12 * CAPACITY
    before = raw_bytes(taut)
    assert lib.taut_step(taut, clearance)
    assert raw_bytes(taut) == before


def past(x: float, y: float, dx: int, dy: int) -> Point:
    """A place just outside a corner, with the obstacle at (-dx, -dy) of it."""
    return x + dx * PAST, y + dy * PAST


def assert_shortest(where: set[Cell], way: list[Point], shortest: list[Point]) -> None:
    _, clearance = with_walls(where)
    steps = [(round(x * PER_CELL), round(y * PER_CELL)) for x, y in way]
    assert sees(clearance, steps), "the example is wrong"
    for there, best in ((steps, shortest), (steps[::-1], shortest[::-1])):
        now = in_cells(pulled(clearance, there))
        assert now == best


BOX = {(x, y) for x in range(60, 68) for y in range(58, 72)}
START, GOAL = (40.5, 64.5), (90.5, 63.5)


@pytest.mark.parametrize("up", [1, -1])
def test_round_one_box_on_either_side(up: int) -> None:
    """The other side may be shorter, but a taut path stays on its side of a post."""
    side = 72 if up == 1 else 58
    way = [START, (50.5, 64.5 + 30 * up), (64.5, 64.5 + 35 * up), (80.5, 64.5 + 30 * up), GOAL]
    corners = [past(60, side, -1, up), past(68, side, 1, up)]
    assert_shortest(BOX, way, [START, *corners, GOAL])


def test_through_a_door() -> None:
    wall = {(64, y) for y in range(SIDE) if not 90 <= y < 100}
    way = [START, (50.5, 95.5), (64.5, 95.5), (75.5, 97.5), GOAL]
    assert_shortest(wall, way, [START, past(64, 90, -1, 1), past(65, 90, 1, 1), GOAL])


def test_a_door_in_the_straight_line_leaves_a_line() -> None:
    wall = {(64, y) for y in range(SIDE) if not 60 <= y < 70}
    way = [START, (50.5, 95.5), (60.5, 66.5), (66.5, 66.5), (75.5, 30.5), GOAL]
    assert_shortest(wall, way, [START, GOAL])


def test_a_slalom() -> None:
    low = {(x, y) for x in (50, 90) for y in range(80)}
    high = {(70, y) for y in range(40, SIDE)}
    way = [(30.5, 64.5), (50.5, 100.5), (70.5, 20.5), (90.5, 100.5), (110.5, 64.5)]
    shortest = [
        way[0],
        past(50, 80, -1, 1), past(51, 80, 1, 1),
        past(70, 40, -1, -1), past(71, 40, 1, -1),
        past(90, 80, -1, 1), past(91, 80, 1, 1),
        way[-1],
    ]  # fmt: skip
    assert_shortest(low | high, way, shortest)


def test_a_corner_on_the_outer_side_does_not_hold_the_string() -> None:
    """The path has a point beyond a cell on its left, but turns left there."""
    where = {(58, 65), (59, 67)}
    way = [(58.5, 70.5), past(59, 66, 1, 1), (61.5, 64.5)]
    assert_shortest(where, way, [way[0], past(59, 67, -1, -1), way[2]])


def upper_hull(spots: list[Point]) -> list[Point]:
    """The upper hull from left to right."""
    hull: list[Point] = []
    for x, y in sorted(spots):
        while len(hull) >= 2:
            (ax, ay), (bx, by) = hull[-2:]
            if (bx - ax) * (y - ay) < (by - ay) * (x - ax):
                break
            hull.pop()
        hull.append((x, y))
    return hull


@pytest.mark.parametrize("radius", [4.0, 9.5, 20.0])
def test_round_a_post_only_the_corners_of_its_hull_are_touched(radius: float) -> None:
    disc = {
        (x, y)
        for x, y in itertools.product(range(SIDE), repeat=2)
        if math.hypot(x - 64, y - 64) < radius
    }
    ends = [(40.5, 60.5), (90.5, 66.5)]
    tops = {x: 1 + max(y for a, y in disc if a == x) for x, _ in disc}
    corners = [past(x + side, y, 2 * side - 1, 1) for x, y in tops.items() for side in (0, 1)]
    shortest = upper_hull([*ends, *corners])
    assert len(shortest) >= 4
    assert_shortest(disc, [ends[0], (40.5, 100.5), (90.5, 100.5), ends[1]], shortest)


def test_a_detour_in_the_open_becomes_a_line() -> None:
    _, clearance = with_walls([])
    zigzag = [middle((20 + i, 64 + 5 * (i % 2))) for i in range(CAPACITY)]
    assert pulled(clearance, zigzag) == [zigzag[0], zigzag[-1]]


@pytest.mark.parametrize("count", [1, 2])
def test_what_is_straight_is_taut(count: int) -> None:
    taut = begin([middle((5, 5)), middle((9, 9))][:count])
    assert taut.stage == lib.TAUT_DONE
    assert taut.count == count


def test_of_a_way_that_fills_the_room_for_points_none_is_lost() -> None:
    """A wall in every fourth column, open at one end or the other."""
    columns = range(4, 124, 4)
    gaps = {x: 0 if x % 8 else SIDE - 1 for x in columns}
    walls = {(x, y) for x, gap in gaps.items() for y in range(SIDE) if y != gap}
    way, shortest = [(2.5, 64.5)], [(2.5, 64.5)]
    for x, gap in gaps.items():
        corner, outwards = (1, -1) if gap == 0 else (gap, 1)
        way += [(x - 0.5, gap + 0.5), (x + 1.5, gap + 0.5)]
        shortest += [past(x, corner, -1, outwards), past(x + 1, corner, 1, outwards)]
    end = (125.5, 64.5)
    assert len(way) + 1 == CAPACITY - 2
    assert_shortest(walls, [*way, end], [*shortest, end])


def test_out_of_a_room_and_round_its_wall() -> None:
    picture = [
        "....................",
        "##########.#########",
        "..........#.........",
        "..........#.........",
        "..........#.........",
        "..........#.........",
        ".####.#####.........",
    ]
    way = [(55.5, 63.5), (59.5, 62.5), (59.5, 59.5), (68.5, 58.5), (70.5, 63.5)]
    shortest = [
        way[0], past(59, 61, 1, 1), past(60, 60, -1, -1), past(65, 60, 1, -1), way[-1],
    ]  # fmt: skip
    assert_shortest(from_picture(picture, 54, 60), way, shortest)
