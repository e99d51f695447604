# SPDX-License-Identifier: GPL-3.0-or-later
"""Flies one mission of a campaign, given only its numbers, and judges it by the truth."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from ground.model import Point
from ground.sim.campaign.rows import Row
from ground.sim.footprints import Array
from ground.sim.pilot import TIME_IS_UP, Pilot
from ground.sim.runtime import Options
from ground.sim.trouble import TroubleSpec
from ground.sim.world import World
from ground.sim.worldspec import WorldSpec
from ground.station.flight import Outcome

LOSS: Final = 0.02
_IN_THE_AIR_M: Final = 0.05


@dataclass(frozen=True, slots=True)
class Mission:
    """A mission of a campaign; the same values always give the same flight."""

    kind: str
    seed: int
    number: int
    profile: str = "real"
    loss: float = LOSS
    settings: tuple[tuple[str, float], ...] = ()
    """Parameters that differ from their defaults."""
    baseline: tuple[tuple[str, float], ...] = ()
    """Other parameters, with which the same world is explored again for comparison."""

    @property
    def conditions(self) -> str:
        """Everything that its number does not determine, as text."""
        others = [f"{name}={value:g}" for name, value in self.settings]
        against = [f"against {name}={value:g}" for name, value in self.baseline]
        return " ".join([self.profile, f"loss={self.loss:g}", *others, *against])

    def rng(self) -> np.random.Generator:
        """A generator for everything that is drawn for this mission."""
        return np.random.default_rng([self.seed, self.number])

    def world(self, spec: WorldSpec) -> World:
        """A world in which the drone has this mission's settings."""
        return World(replace(spec, eeprom={**spec.eeprom, **dict(self.settings)}))

    def options(self) -> Options:
        """The simulator's options for this mission."""
        state = np.random.SeedSequence([self.seed, self.number, 1]).generate_state(1)
        return Options(
            seed=int(state[0]),
            profile=self.profile,
            trouble=TroubleSpec(loss=self.loss),
            keep_trail=True,
        )


@dataclass(frozen=True, slots=True)
class Flight:
    """A flown mission with everything needed to draw it; world frame."""

    row: Row
    spec: WorldSpec
    trail: Array
    """True poses: time [s], x, y, z [m], yaw [rad]."""
    contacts_m: Array
    """Where the drone was when it touched something ..."""
    contacts: tuple[str, ...]
    """... and what that was, with the speeds of both."""
    believed_m: Array
    """Where the drone estimated to be."""
    drawn_m: Array
    """The obstacles in the drone's map."""
    goal_m: tuple[float, float] | None = None
    way_m: tuple[tuple[float, float], ...] = ()


class Judge:
    """The truth about a flight of a Pilot."""

    def __init__(self, pilot: Pilot, world: World) -> None:
        truth = pilot.truth()
        self._pilot, self._world = pilot, world
        self.sim_s = float(truth["sim_s"])
        self.trail: Array = np.array(truth["trail"], float).reshape(-1, 5)
        self.contacts: list[dict[str, Any]] = truth["collision_log"]

    @property
    def collisions(self) -> int:
        """Contacts that the drone caused by moving into something."""
        return sum(contact["by_drone"] for contact in self.contacts)

    def flown_m(self, end_s: float) -> float:
        """Horizontal length of the true path in the air until then."""
        flying = self.trail[(self.trail[:, 0] <= end_s) & (self.trail[:, 3] > _IN_THE_AIR_M)]
        return float(np.hypot(*np.diff(flying[:, 1:3], axis=0).T).sum())

    def flight(self, row: Row) -> Flight:
        """The whole flight, to draw it."""
        contacts = [self.place_m(contact["time_s"]) for contact in self.contacts]
        believed = np.array(self._pilot.believed).reshape(-1, 3)[:, 1:]
        return Flight(
            row,
            self._world.spec,
            self.trail,
            contacts_m=np.array(contacts).reshape(-1, 2),
            contacts=tuple(_sentence(contact) for contact in self.contacts),
            believed_m=self._in_world(believed),
            drawn_m=self._in_world(self._pilot.picture.map.obstacles_m()),
        )

    def _in_world(self, places_m: Array) -> Array:
        return np.column_stack(self._world.to_world(places_m[:, 0], places_m[:, 1]))

    def miss_m(self, end_s: float, goal: Point) -> float:
        """True distance at that time to a goal in the map frame."""
        return math.dist(self.place_m(end_s), self._world.to_world(goal.x_m, goal.y_m))

    def place_m(self, time_s: float) -> tuple[float, float]:
        """True position of the drone at that time, world frame."""
        x_m, y_m = (np.interp(time_s, self.trail[:, 0], self.trail[:, i]) for i in (1, 2))
        return float(x_m), float(y_m)


def _sentence(contact: dict[str, Any]) -> str:
    return (
        f"{contact['time_s']:.2f} s: {contact['obstacle']}, the drone came with "
        f"{contact['drone_mps']:.2f} m/s, it with {contact['obstacle_mps']:.2f} m/s"
    )


def word_for(outcome: Outcome) -> str:
    """The outcome as one word."""
    if outcome.reached:
        return "done"
    return "timeout" if outcome.sentence == TIME_IS_UP else "refused"


def kinds() -> Mapping[str, Callable[[Mission], Flight]]:
    """The function that flies each kind of mission."""
    from ground.sim.campaign.explore import fly_explore
    from ground.sim.campaign.fault import fly_fault
    from ground.sim.campaign.goto import fly_goto
    from ground.sim.campaign.moving import fly_moving

    return MappingProxyType(
        {"goto": fly_goto, "moving": fly_moving, "explore": fly_explore, "fault": fly_fault}
    )


def fly(mission: Mission) -> Flight:
    """Fly a mission, and time it."""
    begin_s = time.perf_counter()
    flight = kinds()[mission.kind](mission)
    return replace(flight, row=replace(flight.row, wall_s=round(time.perf_counter() - begin_s, 3)))


def row_of(mission: Mission) -> Row:
    """Fly a mission and keep only its row; an internal error counts as a failed mission."""
    try:
        return fly(mission).row
    except Exception as error:
        sentence = f"{type(error).__name__}: {error}"
        return Row(
            mission.kind,
            mission.seed,
            mission.number,
            mission.conditions,
            outcome="error",
            reason=sentence,
            cause="error",
        )
