# SPDX-License-Identifier: GPL-3.0-or-later
"""The map over a bad link: once the drone's map stops changing, the ground's equals it."""

from __future__ import annotations

import random
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ground.core import GRID_SIDE_CELLS, NO_POINT, TILES, CData, MissionCmd, ffi, lib
from ground.link.logstream import CLOCK_MS
from ground.map.groundmap import GroundMap
from ground.model import MapPacket
from ground.requests import AskTiles
from ground.sim.pilot import Pilot
from ground.sim.runtime import Options
from ground.sim.trouble import NO_TROUBLE, Trouble, TroubleSpec
from ground.sim.world import load_world
from ground.station.gaps import Gaps
from ground.station.recovery import Recovery

PERIOD_MS = 10
SIDE = GRID_SIDE_CELLS
BAD = TroubleSpec(loss=0.3, duplication=0.2, reorder=0.2)
specs = st.builds(TroubleSpec, st.floats(0, 0.4), st.floats(0, 0.4), st.floats(0, 0.4))


class Way:
    """A drone's grid, its stream, a bad link both ways, and the ground's map."""

    def __init__(self, spec: TroubleSpec, seed: int, begin_ms: int = 0) -> None:
        self.random = random.Random(seed)
        self.ground, self.recovery = GroundMap(), Recovery()
        self.grid = ffi.new("grid_t *")
        self.now_ms = begin_ms
        self._down, self._up = (Trouble(spec, self.random) for _ in range(2))
        self._stream = ffi.new("mapstream_t *")
        self._epoch = 0
        lib.mapstream_init(self._stream)
        self.forget()

    def forget(self) -> None:
        """Restart the drone's map."""
        self._epoch = (self._epoch + 1) % 4
        cfg = ffi.new("grid_config_t *", lib.grid_config_default())
        lib.grid_init(self.grid, cfg, (0.0, 0.0), 0.05)
        self.grid.changed_tiles = [0xFFFFFFFF] * len(self.grid.changed_tiles)

    def change(self) -> None:
        """Let walls, rooms and noise appear and disappear."""
        value = self.random.choice((0, 3, 3, 12))
        x, y = self.random.randrange(SIDE), self.random.randrange(SIDE)
        width, height = self.random.choice(((30, 1), (1, 30), (12, 12), (1, 1)))
        for iy in range(y, min(SIDE, y + height)):
            for ix in range(x, min(SIDE, x + width)):
                lib.grid_set_value(self.grid, ix, iy, value)
                if value > 7:
                    cell = ffi.new("grid_cell_t *", (ix, iy))[0]
                    inside = (ix + self.random.random(), iy + self.random.random())
                    at = lib.grid_to_metres(self.grid, inside)
                    lib.grid_points_add(self.grid, cell, at, False)

    def run(self, pieces: int) -> None:
        """Send so many packets; the ground requests old tiles."""
        data = ffi.new("uint8_t[]", 26)
        for _ in range(pieces):
            self.now_ms += PERIOD_MS
            lib.mapstream_next(self._stream, self.grid, self._epoch, data)
            packet = self.now_ms.to_bytes(8, "little") + bytes(data)
            for arrived in self._down.carry(packet):
                sent_ms = int.from_bytes(arrived[:8], "little")
                self.ground.take_packet(MapPacket(sent_ms, arrived[8:]), sent_ms / 1000)
            for request in self.recovery.requests(self.ground, None, self.now_ms):
                assert isinstance(request, AskTiles)
                for asked in self._up.carry(bytes(request.tiles)):
                    for tile in asked:
                        self.grid.changed_tiles[tile // 32] |= 1 << tile % 32

    def differs(self) -> int:
        """Number of cells whose state, or point if the drone has one, differs on the ground."""
        states, eighths = drone_map(self.grid)
        points = (eighths != NO_POINT) & (eighths != self.ground.eighths)
        return int(np.count_nonzero((states != self.ground.states) | points))


def drone_map(grid: CData) -> tuple[np.ndarray, np.ndarray]:
    """States and points of the drone's map."""
    side = range(SIDE)
    states = [[lib.grid_state(grid, ix, iy) for ix in side] for iy in side]
    eighths = [[lib.grid_point_eighths(grid, ix, iy) & 255 for ix in side] for iy in side]
    return np.array(states), np.array(eighths)


@settings(max_examples=12, deadline=None)
@given(specs, st.integers(0, 99), st.integers(0, 12), st.sampled_from([0, CLOCK_MS - 3000]))
def test_the_ground_has_the_drones_map_once_it_stops_changing(
    spec: TroubleSpec, seed: int, changes: int, begin_ms: int
) -> None:
    way = Way(spec, seed, begin_ms)
    for _ in range(changes):
        way.change()
        way.run(way.random.randrange(60))
        if way.random.random() < 0.05:
            way.forget()
    way.run(1000)
    assert way.differs() == 0
    assert way.ground.completeness == 1


def test_without_asking_a_tile_may_stay_old_for_longer() -> None:
    """Requests are not needed for the map to become complete, but they bound the tiles' ages."""
    way = Way(BAD, 5)
    for _ in range(200):
        way.change()
        way.run(1)
    for _ in range(20):
        way.change()
        way.run(50)
        newest_ms = way.now_ms
        assert newest_ms - int(way.ground.tile_ms.min()) < 6000


def test_a_piece_that_was_overtaken_changes_nothing() -> None:
    way = Way(NO_TROUBLE, 1)
    way.change()
    way.run(50)
    stale = MapPacket(way.now_ms - 400, bytes(26 * [0]))
    before = way.ground.revision
    way.ground.take_packet(stale, 0.0)
    assert way.ground.revision == before
    assert way.differs() == 0


def shuffled(numbers: Iterator[int], spec: TroubleSpec, seed: int) -> Iterator[int]:
    """Numbers in order of arrival."""
    trouble = Trouble(spec, random.Random(seed))
    for number in numbers:
        for data in trouble.carry(number.to_bytes(2, "little")):
            yield int.from_bytes(data, "little")


@given(specs, st.integers(0, 999), st.sampled_from([0, 7, 65_500]), st.integers(1, 200))
def test_each_number_comes_once_over_the_wrap(
    spec: TroubleSpec, seed: int, first: int, count: int
) -> None:
    gaps, got = Gaps(8), []
    gaps.expect(first)
    before = {n % 65536 for n in range(first - 8, first)}
    for number in shuffled((n % 65536 for n in range(first, first + count)), spec, seed):
        if gaps.take(number):
            got.append(number)
    assert len(got) == len(set(got))
    assert set(got) <= {n % 65536 for n in range(first, first + count)} | before


@given(specs, st.integers(0, 999), st.sampled_from([0, 65_530]))
def test_what_is_asked_for_fills_every_gap(spec: TroubleSpec, seed: int, first: int) -> None:
    """One number per second, and an answer to each question that gets through."""
    gaps, dice, got = Gaps(8), random.Random(seed), set()
    for i in range(40):
        number = (first + i) % 65536
        if dice.random() >= spec.loss and gaps.take(number):
            got.add(i)
        gaps.expect((number + 1) % 65536)
        for step in range(4):
            if (asked := gaps.ask(1000 * i + 250 * step)) and dice.random() >= spec.loss:
                for n in range(asked[0], asked[0] + asked[1]):
                    there = (first + i - n) % 65536 < 8
                    if there and dice.random() >= spec.loss and gaps.take(n % 65536):
                        got.add((n - first) % 65536)
    for step in range(40, 80):
        if asked := gaps.ask(1000 * step):
            for n in range(asked[0], asked[0] + asked[1]):
                if gaps.take(n % 65536):
                    got.add((n - first) % 65536)
    assert len({i for i in got if i < 40}) + gaps.given_up >= 40
    assert gaps.given_up <= 2


@pytest.mark.parametrize("seed", [1, 2])
def test_a_flight_over_a_bad_way_is_told_completely(seed: int) -> None:
    pilot = Pilot(load_world("flat"), Options(seed=seed, trouble=BAD))
    pilot.fly(MissionCmd.EXPLORE, limit_s=60.0)
    pilot.land()
    pilot.rest(30.0)  # what moved fades from the drone's map
    ground = pilot.picture.map
    ground.clear(ground.epoch)
    pilot.rest(10.0)
    known, points = ground.states.copy(), ground.eighths.copy()
    numbers = [event.sequence for event in pilot.picture.events]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert pilot.recovery.events.given_up == 0
    assert pilot.recovery.records.given_up <= 1
    assert len(pilot.picture.trail) > 50

    pilot.faults.bench.radio.trouble = NO_TROUBLE
    ground.clear(ground.epoch)
    pilot.fetch_map()
    pilot.rest(8.0)
    assert np.count_nonzero(ground.states) > 2000
    assert np.array_equal(ground.states, known)
    there = ground.eighths != NO_POINT
    both = there & (points != NO_POINT)
    assert np.array_equal(ground.eighths[both], points[both])
    assert np.count_nonzero(both) > 0.95 * np.count_nonzero(there)


def test_every_tile_has_an_age_and_the_rate_is_known() -> None:
    way = Way(NO_TROUBLE, 3)
    for _ in range(30):
        way.change()
    way.run(400)
    assert way.ground.rate_hz == pytest.approx(1000 / PERIOD_MS)
    assert len(way.ground.tile_ages_s(way.now_ms / 1000)) == TILES
    assert 0 <= way.ground.tile_ages_s(way.now_ms / 1000).max() < 4
