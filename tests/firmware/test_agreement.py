# SPDX-License-Identifier: GPL-3.0-or-later
"""The chip decides the same as this machine, bit for bit, in whole flights and outside them."""

import pytest

from ground.core import MissionState
from tests.firmware.build import FLAG_SETS, SCENARIO, build
from tests.firmware.chip import Chip
from tests.firmware.flights import ALL, FEW, Flight, arrived, record
from tests.firmware.replay import RUNS, on_this_machine, part_name, replay


@pytest.mark.parametrize(("flight", "flags"), RUNS, ids=part_name)
def test_a_whole_flight_is_the_same_on_the_chip(flight: Flight, flags: str) -> None:
    done = replay(flight, flags)
    assert arrived(done.recording)
    assert MissionState.LAND in done.recording.states
    assert len(done.run.elapsed) == done.recording.ticks > 500
    assert done.difference is None


def test_the_flights_of_the_bench_are_twenty_one_and_cover_every_room() -> None:
    assert len({flight.name for flight in ALL}) == len(ALL) == 21
    worlds = {"flat", "hall", "clutter", "door", "person", "empty"}
    assert {flight.world for flight in ALL} == worlds


def test_a_recorded_flight_can_be_flown_again() -> None:
    flight = FEW[-1]
    assert bytes(record.__wrapped__(flight).records) == bytes(record(flight).records)


@pytest.mark.parametrize("flags", FLAG_SETS)
def test_what_flights_meet_rarely_is_the_same_on_the_chip(flags: str) -> None:
    here = on_this_machine(SCENARIO, b"").decode()
    there = Chip(build(SCENARIO, flags)).run(b"").output.decode()
    parts = [line.rpartition(" ")[0] for line in here.splitlines()]
    assert parts == [
        "rng", "angles", "vectors", "wire", "grid", "wavefront", "planner", "absurd input",
    ]  # fmt: skip
    assert there.splitlines() == here.splitlines()
