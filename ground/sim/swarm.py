# SPDX-License-Identifier: GPL-3.0-or-later
"""Several Crazyflies in one process and one loop, each on a UDP port of its own.

Each has its own copy of the world, in which the other drones are discs of a drone's size that
follow their true positions. Beams see them, a drone can stand on them or collide with them. Not
modelled: the downwash of other drones.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ground.errors import SimulatorFailed
from ground.sim.contacts import BODY_HEIGHT_M, BODY_RADIUS_M
from ground.sim.firmware import Firmware
from ground.sim.footprints import Footprints
from ground.sim.pace import Pace
from ground.sim.plant import PLANT_STEP_S
from ground.sim.runtime import START_S, Options, Simulator
from ground.sim.server import Server, serve_until, serve_until_read
from ground.sim.world import World
from ground.sim.worldspec import Obstacle, Point, WorldSpec

DRONES_MAX = 10
"""As many drones as cflib's scan finds."""
APART_M = 0.6
ROOM_M = 0.3
_REFLECTIVITY = 0.3
_NEVER_S = 1e9
_RINGS = 12
_BEARINGS = 16


def start_places(spec: WorldSpec, count: int) -> list[Point]:
    """The world's start, then free places near it, apart from each other and in sight of it."""
    footprints = Footprints(spec.obstacles)
    places = [spec.start_m]
    for ring in range(1, _RINGS + 1):
        for step in range(_BEARINGS):
            bearing_rad = spec.start_yaw_rad + math.tau * step / _BEARINGS
            place = (
                spec.start_m[0] + ring * APART_M * math.cos(bearing_rad),
                spec.start_m[1] + ring * APART_M * math.sin(bearing_rad),
            )
            if len(places) < count and _is_free(footprints, spec.start_m, place, places):
                places.append(place)
    if len(places) < count:
        raise SimulatorFailed(
            f"the world {spec.name} has room for {len(places)} drones at its start"
        )
    return places


def _is_free(footprints: Footprints, start: Point, place: Point, taken: list[Point]) -> bool:
    way = np.linspace(start, place, 40)
    clear_m = footprints.gap_m(way, 0.0, 1.0)
    apart = all(math.dist(place, other) > 0.99 * APART_M for other in taken)
    return apart and clear_m[-1] > ROOM_M and bool((clear_m[1:] > BODY_RADIUS_M).all())


@dataclass(slots=True)
class Clock:
    """Simulated and wall time, with the time in which a client was served counted separately."""

    wall_s: float = 0.0
    served_sim_s: float = 0.0
    served_wall_s: float = 0.0

    def figures(self) -> dict[str, object]:
        """The figures for status(); realtime_factor is over the time with a client."""
        factor = self.served_sim_s / self.served_wall_s if self.served_wall_s else 0.0
        return {
            "wall_s": round(self.wall_s, 3),
            "served_sim_s": round(self.served_sim_s, 3),
            "served_wall_s": round(self.served_wall_s, 3),
            "realtime_factor": round(factor, 2),
        }


@dataclass(slots=True)
class Swarm:
    """All drones of one process; a single drone is a swarm of one."""

    drones: list[Simulator]
    worlds: list[World]
    others_from: int
    """Index of the first other drone among a world's obstacles."""
    clock: Clock = field(default_factory=Clock)

    def step(self) -> None:
        """Advance simulated time by PLANT_STEP_S for all drones."""
        self._meet()
        for drone in self.drones:
            drone.step()

    def warm_up(self) -> None:
        """Run the first second, in which the firmware starts and refuses to fly."""
        while self.drones[0].time_s < START_S:
            self.step()

    def run(self, servers: Sequence[Server], speed: float, stopped: Callable[[], bool]) -> None:
        """Serve clients until stopped() is true; it is asked once per step."""
        begin_s = before_s = time.monotonic()
        pace = Pace(speed, PLANT_STEP_S, begin_s)
        while not stopped():
            hurry = any(drone.radio.connected() for drone in self.drones)
            hurry &= not any(drone.radio.handshaking(before_s) for drone in self.drones)
            serve_until(servers, pace.next_due_s(hurry, before_s))
            if pace.waits:
                serve_until_read(servers)
            # Expire clients only now, after taking what they sent while this process did not run.
            for drone in self.drones:
                drone.radio.expire(before_s)
            self.step()
            sent = sum(server.flush() for server in servers)
            now_s = time.monotonic()
            if pace.waits:
                pace.sent(sent, now_s, all(server.sees_clients for server in servers))
            if hurry:
                self.clock.served_sim_s += PLANT_STEP_S
                self.clock.served_wall_s += now_s - before_s
            before_s = now_s
        self.clock.wall_s += time.monotonic() - begin_s

    def status(self) -> dict[str, object]:
        """The figures of the only drone, or those of all drones as a list `drones`."""
        each = [drone.status() | self.clock.figures() for drone in self.drones]
        return each[0] if len(each) == 1 else {"drones": each, **self.clock.figures()}

    def places_m(self) -> list[Point]:
        """Position of each drone, in the map frame of the first."""
        here = (drone.truth.position_m for drone in self.drones)
        return [self.worlds[0].to_map(x_m, y_m) for x_m, y_m, _ in here]

    def _meet(self) -> None:
        """Move the other drones' discs, and share triggered motions between the worlds."""
        for mine, world in enumerate(self.worlds):
            others = [drone.truth for drone in self.drones if drone is not self.drones[mine]]
            for row, truth in enumerate(others, self.others_from):
                vx_mps, vy_mps, _ = truth.velocity_mps
                world.footprints.carry(row, truth.position_m, (vx_mps, vy_mps))
            for other in self.worlds if others else ():
                world.footprints.triggered_by(other.footprints)


def make_swarm(
    spec: WorldSpec, options: Options, count: int, firmware: Sequence[Firmware] = ()
) -> Swarm:
    """Make a swarm; seeds count up from the first drone's, which flies as if it were alone."""
    places = start_places(spec, count)
    worlds, drones = [], []
    for mine, place in enumerate(places):
        world = World(replace(spec, start_m=place))
        if count > 1:
            world.put(tuple(_disc(n, at) for n, at in enumerate(places) if n != mine))
        file = options.eeprom_file
        own = replace(
            options,
            seed=options.seed + mine,
            eeprom_file=file.with_stem(f"{file.stem}-{mine + 1}") if file and mine else file,
        )
        worlds.append(world)
        drones.append(Simulator(world, own, firmware[mine] if firmware else None))
    return Swarm(drones, worlds, len(spec.obstacles))


def _disc(number: int, at: Point) -> Obstacle:
    """Another drone as an obstacle; one that vanishes some time counts as one that can move."""
    name, size = f"drone {number + 1}", (BODY_RADIUS_M, BODY_RADIUS_M)
    return Obstacle(
        name, at, size, 0.0, BODY_RADIUS_M, 0.0, BODY_HEIGHT_M, _REFLECTIVITY, vanishes_s=_NEVER_S
    )
