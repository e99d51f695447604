# SPDX-License-Identifier: GPL-3.0-or-later
"""Frontiers: their value, which one is chosen, and when none is left."""

import math
from dataclasses import dataclass, field
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core import oracles
from tests.core.maps import (
    FREE,
    SIDE,
    Bits,
    Cell,
    blocked_bits,
    fill,
    new_clearance,
    new_grid,
    occupy,
    vec2,
)
from tests.core.searches import LONGEST, centre, path_of

ROOM = range(40, 81)
HALF_DISC = math.pi * lib.FRONTIER_SIGHT_CELLS**2 / 2
in_room = st.tuples(st.sampled_from(ROOM), st.sampled_from(ROOM))
holes = st.lists(st.tuples(in_room, st.integers(1, 14), st.integers(1, 14)), max_size=4)


def c_cell(cell: Cell) -> CData:
    return ffi.new("grid_cell_t *", cell)[0]


@dataclass
class Place:
    """A map in which some cells were never observed."""

    unseen: set[Cell]
    walls: set[Cell] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.grid = new_grid()
        fill(self.grid, FREE)
        occupy(self.grid, self.walls)
        self.known: Bits = np.ones((SIDE, SIDE), dtype=bool)
        for x, y in self.unseen - self.walls:
            lib.grid_set_value(self.grid, x, y, lib.GRID_UNKNOWN)
            self.known[y, x] = False
        self.clearance = new_clearance(self.grid)

    def gain(self, cell: Cell) -> int:
        return int(lib.frontier_gain(self.grid, self.clearance, c_cell(cell)))

    def search(
        self,
        start: Cell,
        mode: int = lib.FRONTIER_GAIN,
        vain: CData = None,
        last: Cell = (0, 0),
        slices: int = LONGEST,
    ) -> CData:
        planner = ffi.new("pathfinder_t *")
        cfg = ffi.new("pathfinder_config_t *", lib.pathfinder_config_default())
        lib.pathfinder_start_frontier(
            planner,
            cfg,
            self.clearance,
            vec2(*centre(start)),
            mode,
            vain or ffi.new("frontier_vain_t *"),
            vec2(*last),
        )
        while planner.status == lib.PATHFINDER_SEARCHING:
            lib.pathfinder_extend(planner, self.clearance, self.grid, slices)
        return planner

    def waves(self, start: Cell) -> dict[Cell, int]:
        return oracles.waves(blocked_bits(self.clearance) | ~self.known, start)

    def gains(self, start: Cell) -> dict[Cell, int]:
        """The gain of each reachable frontier."""
        return {
            (x, y): self.gain((x, y))
            for (x, y), waves in self.waves(start).items()
            if waves > 0
            and any(
                0 <= a < SIDE and 0 <= b < SIDE and not self.known[b, a]
                for a, b in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1))
            )
        }


def end_of(planner: CData) -> Cell:
    x, y = path_of(planner)[-1]
    return math.floor(x), math.floor(y)


def block(x0: int, y0: int, x1: int, y1: int) -> set[Cell]:
    return set(product(range(x0, x1), range(y0, y1)))


def test_before_a_wide_unseen_space_a_frontier_is_worth_half_a_disc() -> None:
    place = Place(block(64, 0, SIDE, SIDE))
    assert place.gain((63, 64)) == pytest.approx(HALF_DISC, rel=0.15)
    assert place.gain((20, 64)) == 0


def test_what_is_behind_a_wall_is_worth_nothing() -> None:
    wall = {(66, y) for y in range(SIDE)}
    assert Place(block(67, 0, SIDE, SIDE), wall).gain((60, 64)) == 0


def test_near_unseen_cells_are_counted_as_they_are() -> None:
    hole = block(61, 61, 68, 68)
    gain = Place(hole - {(64, 64)}).gain((64, 64))
    assert gain == pytest.approx(len(hole), rel=0.4)


@given(st.sets(in_room, max_size=200), in_room, holes, st.integers(1, 200))
def test_a_frontier_that_is_worth_it_is_found_if_there_is_one(
    walls: set[Cell], start: Cell, where: list[tuple[Cell, int, int]], slices: int
) -> None:
    outline = block(39, 39, 82, 82) - set(product(ROOM, ROOM))
    unseen = set().union(*(block(x, y, x + w, y + h) for (x, y), w, h in where), set())
    unseen &= block(0, 0, SIDE, SIDE)
    place = Place(unseen - {start}, (walls - {start}) | outline)
    gains = place.gains(start)
    for mode in (lib.FRONTIER_NEAREST, lib.FRONTIER_GAIN):
        planner = place.search(start, mode, slices=slices)
        if planner.status == lib.PATHFINDER_FOUND:
            assert gains[end_of(planner)] >= lib.FRONTIER_GAIN_MIN
            assert end_of(place.search(start, mode)) == end_of(planner)
        else:  # of eight cells beside each other one is looked at
            assert planner.status == lib.PATHFINDER_NO_WAY
            assert max(gains.values(), default=0) < 3 * lib.FRONTIER_GAIN_MIN


def test_much_far_away_is_better_than_little_nearby() -> None:
    place = Place(block(60, 60, 68, 68) | block(100, 30, SIDE, 98))
    assert end_of(place.search((50, 64), lib.FRONTIER_NEAREST))[0] < 70
    assert end_of(place.search((50, 64)))[0] == 99


def test_of_two_that_are_alike_it_goes_on_to_the_one_it_had() -> None:
    place = Place(block(0, 0, 34, SIDE) | block(94, 0, SIDE, SIDE))
    assert end_of(place.search((62, 64)))[0] == 34
    assert end_of(place.search((62, 64), last=(93, 64)))[0] == 93
    assert end_of(place.search((45, 64), last=(93, 64)))[0] == 34


def test_where_looking_was_in_vain_it_does_not_go_again() -> None:
    place = Place(block(60, 60, 70, 70))
    vain = ffi.new("frontier_vain_t *")
    seen = []
    while (planner := place.search((40, 64), vain=vain)).status == lib.PATHFINDER_FOUND:
        cell = end_of(planner)
        assert all(max(abs(cell[0] - x), abs(cell[1] - y)) >= 8 for x, y in seen)
        seen.append(cell)
        lib.frontier_vain_add(vain, c_cell(cell))
    assert 1 < len(seen) <= lib.FRONTIER_VAIN


def test_only_the_last_vain_places_are_remembered() -> None:
    vain = ffi.new("frontier_vain_t *")
    for i in range(3 * lib.FRONTIER_VAIN):
        lib.frontier_vain_add(vain, c_cell((i, 2 * i)))
    kept = {(vain.ix[i], vain.iy[i]) for i in range(vain.count)}
    assert kept == {(i, 2 * i) for i in range(2 * lib.FRONTIER_VAIN, 3 * lib.FRONTIER_VAIN)}


def test_where_all_is_seen_none_is_left() -> None:
    assert Place(set()).search((64, 64)).status == lib.PATHFINDER_NO_WAY
