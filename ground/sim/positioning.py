# SPDX-License-Identifier: GPL-3.0-or-later
"""Systems that measure the position in the room: Lighthouse and Loco.

Only what reaches the estimator is modelled, not light or radio: a position and, for Lighthouse, a
heading, with noise and a slow calibration error. Motion capture is not here: a client sends it
(localization.py).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ground.sim.controller import CONTROL_STEP_S
from ground.sim.estimator import Estimator
from ground.sim.model import PositionMeasured, Readings, YawMeasured
from ground.sim.noise import Noise, Wander
from ground.sim.vehicle import Vehicle

STATUS_PERIOD_S: Final = 0.2
STATUS_MEASURES: Final = 2
MODE_TDOA3: Final = 3


@dataclass(frozen=True, slots=True)
class System:
    """Rate and quality of a system; told_sd_m is the standard deviation that it reports."""

    deck: str
    period_s: float
    noise_m: float
    wander_m: float
    told_sd_m: float
    yaw_sd_rad: float | None


SYSTEMS: Final = {
    "lighthouse": System("bcLighthouse4", 0.03, 0.004, 0.008, 0.01, math.radians(1.0)),
    "loco": System("bcLoco", 0.05, 0.08, 0.05, 0.12, None),
}
POSITIONINGS: Final = ("flow", *SYSTEMS, "mocap")
"""Values of --positioning; flow and mocap need no deck."""


@dataclass(frozen=True, slots=True)
class Shadow:
    """Nothing is measured between start_s and end_s of simulated time."""

    start_s: float
    end_s: float


class Positioning:
    """The positioning system of one drone, stepped every CONTROL_STEP_S."""

    def __init__(self, kind: str, shadows: tuple[Shadow, ...], rng: np.random.Generator) -> None:
        if kind not in POSITIONINGS:
            raise ValueError(f"positioning {kind!r} is none of {', '.join(POSITIONINGS)}")
        self.deck_holds_yaw = kind == "lighthouse"
        self._system = SYSTEMS.get(kind)
        self._shadows = shadows
        self._noise = Noise(rng)
        wander_m = self._system.wander_m if self._system else 0.0
        self._off = tuple(Wander(self._noise, wander_m, 20.0, CONTROL_STEP_S) for _ in range(3))
        self._time_s = self._due_s = self._status_due_s = 0.0
        self._measured = False

    def step(self, body: Vehicle, estimator: Estimator, readings: Readings, lost: bool) -> None:
        """Send due measurements to the estimator and update the deck's log variables."""
        self._time_s += CONTROL_STEP_S
        if self._system is None:
            return
        shadowed = lost or any(s.start_s <= self._time_s < s.end_s for s in self._shadows)
        off_m = [wander.step() for wander in self._off]
        if self._time_s >= self._due_s:
            self._due_s += self._system.period_s
            if not shadowed:
                self._tell(self._system, body, estimator, off_m)
        if self._time_s >= self._status_due_s:
            self._status_due_s += STATUS_PERIOD_S
            self._write_status(readings)

    def _tell(
        self, system: System, body: Vehicle, estimator: Estimator, off_m: list[float]
    ) -> None:
        normal, noise_m = self._noise.normal, system.noise_m
        place = (body.x_m, body.y_m, body.z_m)
        x, y, z = (p + o + noise_m * normal() for p, o in zip(place, off_m, strict=True))
        estimator.take(PositionMeasured(x, y, z, system.told_sd_m))
        if system.yaw_sd_rad is not None:
            yaw_rad = body.yaw_rad + 0.5 * system.yaw_sd_rad * normal()
            error_rad = math.remainder(estimator.yaw_rad - yaw_rad, math.tau)
            estimator.take(YawMeasured(error_rad, system.yaw_sd_rad))
        self._measured = True

    def _write_status(self, readings: Readings) -> None:
        """As the decks' drivers do: report what came in since the last update."""
        if self.deck_holds_yaw:
            readings.lighthouse_status = STATUS_MEASURES if self._measured else 0
            readings.lighthouse_active = 0b11 if self._measured else 0
        else:
            readings.loco_mode = MODE_TDOA3
        self._measured = False
