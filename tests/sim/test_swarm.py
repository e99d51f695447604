# SPDX-License-Identifier: GPL-3.0-or-later
"""Several drones in one world and process: own places, seen and touched by each other."""

import asyncio
import math
from itertools import pairwise

import numpy as np
import pytest

from ground.errors import SimulatorFailed
from ground.link.radio import RadioLink
from ground.sim.console import obey_one
from ground.sim.process import SimulatorProcess
from ground.sim.runtime import Options
from ground.sim.swarm import APART_M, DRONES_MAX, ROOM_M, Swarm, make_swarm, start_places
from ground.sim.world import World
from ground.sim.worldfile import read_world
from ground.station.station import station_on
from tests.ground.stations import take_off

WORLDS = ("flat", "clutter", "hall", "empty", "person", "door")


@pytest.mark.parametrize("name", WORLDS)
def test_start_places_are_free_and_apart(name: str) -> None:
    spec = read_world(name)
    places = start_places(spec, 4)
    assert places[0] == spec.start_m
    for n, place in enumerate(places):
        assert all(math.dist(place, other) > 0.99 * APART_M for other in places[:n])
    free = World(spec).footprints.gap_m(np.array(places[1:]), 0.0, 1.0)
    assert (free > ROOM_M).all()


def test_a_world_without_room_is_told() -> None:
    spec = read_world("empty")
    assert len(start_places(spec, DRONES_MAX)) == DRONES_MAX
    with pytest.raises(SimulatorFailed, match="room for"):
        start_places(spec, 1000)


def two() -> Swarm:
    swarm = make_swarm(read_world("empty"), Options(profile="perfect"), 2)
    swarm.step()
    return swarm


def distance_m(swarm: Swarm, z_m: float) -> float:
    """The range from the first drone towards the second, as a beam of the first measures it."""
    (x0, y0, _), (x1, y1, _) = (drone.truth.position_m for drone in swarm.drones)
    way = np.array([[x1 - x0, y1 - y0, 0.0]]) / math.dist((x0, y0), (x1, y1))
    return float(swarm.worlds[0].cast((x0, y0, z_m), way, 4.0).distance_m[0])


def test_drones_see_each_other_at_their_height() -> None:
    swarm = two()
    assert distance_m(swarm, 0.015) == pytest.approx(APART_M - 0.07, abs=0.01)
    assert distance_m(swarm, 0.3) > 0.8, "over it, to the wall"
    x_m, y_m, _ = swarm.drones[1].truth.position_m
    swarm.drones[1].faults.bench.plant.carry(x_m, y_m, 0.29)
    for _ in range(2):
        swarm.step()
    assert distance_m(swarm, 0.3) == pytest.approx(APART_M - 0.07, abs=0.01)
    assert distance_m(swarm, 0.015) > 0.8


def test_drones_touch_each_other() -> None:
    swarm = two()
    x_m, y_m, _ = swarm.drones[0].truth.position_m
    swarm.drones[1].faults.bench.plant.carry(x_m + 0.1, y_m, 0.0)
    for _ in range(3):
        swarm.step()
    (collision,) = swarm.drones[1].faults.bench.plant.collision_log
    assert collision.obstacle == "drone 1"
    assert swarm.drones[1].truth.position_m[0] == pytest.approx(x_m + 0.14, abs=0.005)


def test_what_one_sets_off_moves_for_all() -> None:
    swarm = make_swarm(read_world("door"), Options(profile="perfect"), 2)
    rows = [
        row for row, o in enumerate(swarm.worlds[0].spec.obstacles) if o.motion and o.motion.trigger
    ]
    trigger = swarm.worlds[0].spec.obstacles[rows[0]].motion
    assert trigger and trigger.trigger
    swarm.drones[1].faults.bench.plant.carry(*trigger.trigger.center_m, 0.3)
    for _ in range(300):
        swarm.step()
    first, second = (world.footprints.center_m[rows] for world in swarm.worlds)
    assert not np.allclose(first, [swarm.worlds[0].spec.obstacles[row].center_m for row in rows])
    assert np.allclose(first, second, atol=0.02)


def test_one_drone_flies_as_ever() -> None:
    spec, options = read_world("flat"), Options(seed=3)
    alone, among = make_swarm(spec, options, 1), make_swarm(spec, options, 3)
    for swarm in (alone, among):
        swarm.warm_up()
    assert alone.drones[0].truth == among.drones[0].truth
    readings = [swarm.drones[0].faults.bench.plant.readings.battery_v for swarm in (alone, among)]
    assert readings[0] == readings[1]


def test_lines_reach_the_drone_that_they_name() -> None:
    faults = [drone.faults for drone in two().drones]
    assert obey_one("2 fault tumbled", faults) == "tumbled: begun"
    assert [len(each.log) for each in faults] == [0, 1]
    assert obey_one("fault e-stop", faults) == "e-stop: begun"
    assert [len(each.log) for each in faults] == [1, 1]
    assert "1 to 2" in obey_one("3 faults", faults)


def test_each_answers_at_its_port_and_does_what_it_is_told() -> None:
    async def up(uri: str) -> None:
        async with station_on(RadioLink(uri)) as station:
            await take_off(station)

    with SimulatorProcess("--world", "empty", "--speed", "4", port=19840, drones=3) as simulator:
        ports = [int(uri.rpartition(":")[2]) for uri in simulator.uris]
        assert ports == [19840, 19841, 19842]
        asyncio.run(up(simulator.uris[1]))
        drones = simulator.stop()["drones"]
    heights = [drone["max_height_m"] for drone in drones]
    assert heights[1] > 0.2 > heights[0] and heights[2] < 0.01
    assert all(a["sim_s"] == b["sim_s"] for a, b in pairwise(drones))
