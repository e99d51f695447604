# SPDX-License-Identifier: GPL-3.0-or-later
"""A simulated drone that hovers by setpoints, to observe the effects of faults."""

from ground.sim.crtp import Port, encode
from ground.sim.faults import FaultSpec
from ground.sim.model import Readings
from ground.sim.radio import Radio
from ground.sim.runtime import Options, Simulator
from ground.sim.world import load_world
from tests.sim.plants import hover

CLIENT = ("client", 1)
PING = encode(Port.LINK, 0, b"hello")
CRTP = 2


class Bench:
    """A simulated drone that the test's setpoints hold at a height of 0.4 m."""

    def __init__(self, *faults: FaultSpec, world: str = "empty") -> None:
        self.world = load_world(world)
        self.simulator = Simulator(self.world, Options(seed=5, faults=faults))
        self.simulator.warm_up()

    @property
    def seen(self) -> Readings:
        return self.simulator.faults.bench.plant.readings

    @property
    def truth_m(self) -> tuple[float, float, float]:
        return self.simulator.faults.bench.plant.truth.position_m

    @property
    def radio(self) -> Radio:
        return self.simulator.radio

    def fly(self, seconds: float) -> "Bench":
        end_s = self.simulator.time_s + seconds
        while self.simulator.time_s < end_s:
            self.simulator.faults.bench.firmware.put_setpoint(hover(z_m=0.4), CRTP)
            self.simulator.step()
        return self

    def ranges(self, seconds: float) -> list[tuple[int, ...]]:
        sets = []
        for _ in range(round(seconds * 10)):
            self.fly(0.1)
            sets.append(self.seen.range_mm)
        return sets

    def answers(self, count: int) -> int:
        """How many of so many pings are answered within a second."""
        for _ in range(count):
            self.simulator.deliver(CLIENT, PING)
        self.fly(1.0)
        return sum(datagram == PING for _, datagram in self.simulator.outgoing())
