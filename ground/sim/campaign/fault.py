# SPDX-License-Identifier: GPL-3.0-or-later
"""Missions with one fault in one phase of the flight, for every pair of fault and phase."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np

from ground.core import MissionReason, MissionState
from ground.model import Point
from ground.sim.campaign.flights import Flight, Judge, Mission
from ground.sim.campaign.goto import Task, reachable_task
from ground.sim.campaign.rows import Row
from ground.sim.campaign.scenes import draw_scene
from ground.sim.campaign.truth import length_m
from ground.sim.faultflight import PHASES, FaultFlight, fly_with_fault
from ground.sim.faulttable import FAULTS
from ground.sim.pilot import Pilot

_TWINS: Final = ("back-", "right-")
"""Faults of these sides are left out: front and left stand for them."""
_STYLES: Final = ("home", "clutter")
_LEAST_WAY_M: Final = 2.5
_LARGEST_M2: Final = 30.0
"""Small enough that a flight which continues ends within the time that it is watched."""
_DELAY_S: Final = 1.5

_ENDING: Final = ("ground", "return", "land")
"""Phases in which every flight ends on the ground."""
_GROUNDED: Final = (MissionState.IDLE, MissionState.FAULT)
_ANYWHERE: Final = (*_GROUNDED, MissionState.HOVER)
_SENSES: Final = (
    MissionReason.RANGES_FROZEN,
    MissionReason.BLIND,
    MissionReason.ESTIMATOR,
    MissionReason.FLOW_LOST,
)
_BATTERY: Final = (MissionReason.BATTERY_LOW, MissionReason.BATTERY_EMPTY)


@dataclass(frozen=True, slots=True)
class Reaction:
    """The required reaction: in words, the states to end in, and reasons of which it gives one."""

    what: str
    ends: tuple[MissionState, ...] = _ANYWHERE
    says: tuple[MissionReason, ...] = ()


_GOES_ON: Final = Reaction("goes on, or says why not")
_LANDS: Final = Reaction("lands", _GROUNDED, _SENSES)
_NO_WAY: Final = Reaction("says so and holds")
_FINDS_ITSELF: Final = Reaction("finds itself again and goes on, or lands")
_REACTIONS: Final = {
    "ranges-frozen": _LANDS,
    "ranges-dead": _LANDS,
    "ranges-short": _LANDS,
    "ranger-gone": _LANDS,
    "flow-gone": _LANDS,
    "flow-lost": _LANDS,
    "estimate-diverges": _LANDS,
    "estimate-jumps": _FINDS_ITSELF,
    "kidnapped": _FINDS_ITSELF,
    "tumbled": Reaction("stops its motors", _GROUNDED),
    "e-stop": Reaction("stops its motors", _GROUNDED),
    "ground-silent": Reaction("comes home and lands", _GROUNDED),
    "battery-low": Reaction("comes home and lands", _GROUNDED, _BATTERY),
    "battery-empty": Reaction("lands", _GROUNDED, _BATTERY),
    "goal-blocked": _NO_WAY,
    "walled-in": _NO_WAY,
}
"""For other faults: the drone continues, or gives up its task with a reason."""


def stated_reaction(fault: str) -> Reaction:
    """The reaction that this fault requires."""
    return _REACTIONS.get(fault, _GOES_ON)


def cells() -> list[tuple[str, str]]:
    """All pairs of fault and phase, in the order of mission numbers."""
    faults = [name for name in FAULTS if not name.startswith(_TWINS)]
    return list(product(faults, PHASES))


def fly_fault(mission: Mission) -> Flight:
    """Fly to a goal; the fault begins at a random moment of the phase."""
    rng = mission.rng()
    fault, phase = cells()[mission.number % len(cells())]
    task = _draw_task(rng)
    world = mission.world(task.scene.spec)
    pilot = Pilot(world, mission.options())
    goal = Point(*world.to_map(*task.goal_m))
    delay_s = rng.uniform(0.0, _DELAY_S)
    followed = fly_with_fault(pilot, goal, fault, phase, delay_s)
    judge = Judge(pilot, world)
    cause = cause_of(followed)
    row = Row(
        mission.kind,
        mission.seed,
        mission.number,
        mission.conditions,
        style=task.scene.style,
        task=f"{fault} / {phase}",
        outcome=followed.state.name.lower() if followed.happened else "not so far",
        reason=", ".join(reason.name for reason in followed.reasons),
        ok=not cause,
        cause=cause,
        collisions=followed.collisions,
        touches=len(judge.contacts),
        sim_s=judge.sim_s,
    )
    return replace(judge.flight(row), goal_m=task.goal_m, way_m=task.way_m)


def _draw_task(rng: np.random.Generator) -> Task:
    while True:
        scene = draw_scene(str(rng.choice(_STYLES)), rng)
        if scene.layout.outline.area_m2 > _LARGEST_M2:
            continue
        task = reachable_task(scene, rng)
        if task is not None and length_m(task.way_m) > _LEAST_WAY_M:
            return task


def cause_of(flight: FaultFlight) -> str:
    """Why the mission failed; empty if it succeeded or never reached the phase."""
    stated = stated_reaction(flight.fault)
    if not flight.alive:
        return "the app stopped"
    if flight.hangs:
        return "hangs"
    if flight.collisions:
        return "collision"
    if not flight.happened or (flight.phase in _ENDING and flight.state in _GROUNDED):
        return ""
    said = not stated.says or any(reason in stated.says for reason in flight.reasons)
    return "" if flight.state in stated.ends and said else "another reaction"
