# SPDX-License-Identifier: GPL-3.0-or-later
"""Flights of minutes on the drone's own pose estimate: goal after goal, through all rooms.

The simulated Crazyflie runs the app; commands and logs pass as packets of its radio; truth is only
looked at afterwards. With `way.slam` 0 the same goals are flown by odometry alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ground.cli.demo import map_error_m
from ground.core import MissionCmd, MissionReason
from ground.map.groundmap import GroundMap
from ground.model import Point
from ground.sim.footprints import Array
from ground.sim.pilot import Pilot
from ground.sim.runtime import Options
from ground.sim.world import load_world
from tests.bench.slam.goals import goals

THERE_M: Final = 0.3
"""A goal is truly reached when the drone is so near to it."""
LOST_M: Final = 0.5
_PAUSE_S: Final = 2.0
_GROUNDED: Final = (MissionReason.CANNOT_FLY, MissionReason.TUMBLED, MissionReason.BATTERY_LOW)


@dataclass(frozen=True, slots=True)
class Plan:
    """What to fly."""

    profile: str
    slam: int
    seed: int
    minutes: float = 10.0
    world: str = "flat"


@dataclass(frozen=True, slots=True)
class Leg:
    """One goal: what the drone reported about it, and when [s]."""

    goal: Point
    arrived: bool
    sentence: str
    end_s: float


@dataclass(frozen=True, slots=True)
class Flown:
    """One flight and its truth; poses are (s, x, y) in the map frame."""

    plan: Plan
    legs: tuple[Leg, ...]
    leg_errors_m: Array
    believed: Array
    true: Array
    grid: GroundMap
    touches: tuple[dict[str, Any], ...]
    map_m: float

    @property
    def errors_m(self) -> Array:
        """Error of the estimated pose over time."""
        return np.asarray(np.hypot(*(self.believed - self.true)[:, 1:].T))

    @property
    def aligned_errors_m(self) -> Array:
        """The error after the best rigid fit, which removes a rotation of the whole map."""
        believed, true = (
            poses[:, 1:] - poses[:, 1:].mean(axis=0) for poses in (self.believed, self.true)
        )
        sine = float(np.sum(believed[:, 0] * true[:, 1] - believed[:, 1] * true[:, 0]))
        cosine = float(np.sum(believed * true))
        turn = np.array([[cosine, sine], [-sine, cosine]]) / np.hypot(sine, cosine)
        return np.asarray(np.hypot(*(believed @ turn - true).T))

    @property
    def lost(self) -> bool:
        """Whether the drone was elsewhere in its own map for at least a twentieth of the time."""
        return bool(np.percentile(self.aligned_errors_m, 95) > LOST_M)

    @property
    def arrived(self) -> int:
        """Goals that the drone reported as reached."""
        return sum(leg.arrived for leg in self.legs)

    @property
    def truly_there(self) -> int:
        """Those goals at which it truly was."""
        near = self.leg_errors_m <= THERE_M
        return sum(leg.arrived and bool(there) for leg, there in zip(self.legs, near, strict=True))


def fly_closed(plan: Plan) -> Flown:
    """Fly in closed loop and compare with the truth."""
    endurance_s = 90 * plan.minutes + 120  # more than a real cell has
    options = Options(plan.seed, plan.profile, endurance_s, keep_trail=True)
    pilot = Pilot(load_world(plan.world), options)
    pilot.set_parameter("way.slam", plan.slam)
    legs: list[Leg] = []
    wanted = goals(load_world(plan.world), plan.seed)
    reason = pilot.fly(MissionCmd.TAKE_OFF).reason
    end_s = pilot.time_s + 60 * plan.minutes
    while pilot.time_s < end_s and reason not in _GROUNDED:
        goal = next(wanted)
        outcome = pilot.fly(MissionCmd.GOTO, goal)
        reason = outcome.reason
        legs.append(Leg(goal, outcome.reached, outcome.sentence, pilot.time_s))
        if not outcome.reached:
            pilot.rest(_PAUSE_S)
    pilot.land()
    pilot.fetch_map()
    return _judge(plan, tuple(legs), pilot)


def _judge(plan: Plan, legs: tuple[Leg, ...], pilot: Pilot) -> Flown:
    truth = pilot.truth()
    world = load_world(plan.world)
    trail = np.array(truth["trail"])
    x_m, y_m = world.to_map(trail[:, 1], trail[:, 2])

    def true_at(times_s: Array) -> Array:
        return np.column_stack([np.interp(times_s, trail[:, 0], part) for part in (x_m, y_m)])

    believed = np.array(pilot.believed).reshape(-1, 3)
    there = true_at(np.array([leg.end_s for leg in legs]))
    wanted = np.array([(leg.goal.x_m, leg.goal.y_m) for leg in legs]).reshape(-1, 2)
    grid = pilot.picture.map
    error_m = map_error_m(grid, world)
    return Flown(
        plan,
        legs,
        np.hypot(*(there - wanted).T),
        believed,
        np.column_stack([believed[:, 0], true_at(believed[:, 0])]),
        grid,
        tuple(truth["collision_log"]),
        float("nan") if error_m is None else error_m,
    )
