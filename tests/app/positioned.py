# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole simulated Crazyflie without sockets, compared with the truth."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass

from ground.core import MissionCmd
from ground.sim.firmware import Firmware
from ground.sim.runtime import Options, Simulator
from ground.sim.world import World, load_world
from tests.app.drone import FLOAT

START_S = 2.5
SPEED_MPS = 0.4
"""Slower than the default: what is measured is positioning."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Error of the estimate and of the map pose, metres and radians."""

    time_s: float
    estimate_m: float
    estimate_rad: float
    pose_m: float
    pose: complex
    source: int


class Watched(Simulator):
    """A simulated drone with commands and values by name, and the truth."""

    def __init__(self, options: Options, world: str = "flat") -> None:
        self.firmware = Firmware()
        self.world: World = load_world(world)
        super().__init__(self.world, options, self.firmware)
        self._logs = {f"{e.group}.{e.name}": i for i, e in enumerate(self.firmware.log_entries())}
        self.absolute = options.positioning in ("lighthouse", "loco")

    def set(self, name: str, value: float) -> None:
        identity = self._params.find(name)
        assert identity is not None
        self._params.set_value(identity, value)

    def log(self, name: str) -> float:
        data = self.firmware.log_read(self._logs[name], FLOAT, self.firmware.now_ms())
        return float(struct.unpack("<f", data)[0])

    def fly(self, slam: int, cmd: MissionCmd = MissionCmd.EXPLORE) -> None:
        """Take off, without a ground station whose silence could matter."""
        self.set("way.slam", slam)
        self.set("way.speed", SPEED_MPS)
        self.set("way.lost", 0)
        while self.time_s < START_S:
            self.step()
        self.set("way.cmd", int(cmd))

    def until(self, end_s: float) -> Iterator[Sample]:
        """Take a sample every 50 ms until a condition holds."""
        while self.time_s < end_s:
            for _ in range(5):
                self.step()
            yield self._sample()

    @property
    def collisions(self) -> int:
        return self._plant.collisions

    def _sample(self) -> Sample:
        truth, seen = self._plant.truth, self._plant.readings
        true_m = self._to_map(truth.position_m[0], truth.position_m[1])
        true_rad = truth.yaw_rad - self.world.spec.start_yaw_rad
        estimate_m, estimate_rad = complex(seen.x_m, seen.y_m), math.radians(seen.yaw_deg)
        if self.absolute:
            estimate_m = self._to_map(seen.x_m, seen.y_m)
            estimate_rad -= self.world.spec.start_yaw_rad
        pose = complex(self.log("way.x"), self.log("way.y"))
        return Sample(
            self.time_s,
            abs(estimate_m - true_m),
            abs(math.remainder(estimate_rad - true_rad, math.tau)),
            abs(pose - true_m),
            pose,
            int(self.log("way.source")),
        )

    def _to_map(self, x_m: float, y_m: float) -> complex:
        return complex(*self.world.to_map(x_m, y_m))
