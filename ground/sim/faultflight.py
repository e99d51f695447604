# SPDX-License-Identifier: GPL-3.0-or-later
"""A flight to a goal and home with a fault in one phase, and how the drone reacted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from ground.core import EventCode, MissionCmd, MissionReason, MissionState
from ground.errors import NoAnswer
from ground.model import Point
from ground.sim.pilot import Pilot

PHASES: Final = ("ground", "takeoff", "scan", "follow", "hover", "return", "land")
"""Phases in which the fault begins: mission states, and `ground` before the take-off."""

_STATE_OF: Final = {
    "ground": MissionState.IDLE,
    "takeoff": MissionState.TAKEOFF,
    "scan": MissionState.SCAN,
    "follow": MissionState.FOLLOW,
    "hover": MissionState.HOVER,
    "return": MissionState.RETURN,
    "land": MissionState.LAND,
}
_AFTERWARDS: Final = {
    "hover": MissionCmd.HOLD,
    "return": MissionCmd.HOME,
    "land": MissionCmd.LAND,
}
"""The command given on the way to the goal to enter the phase."""
_ON_THE_WAY_S: Final = 7.0
_BEGUN_S: Final = 3.0
_PHASE_S: Final = 150.0
_REST_S: Final = 6.0
_WATCHED_S: Final = 300.0
_LANDING_S: Final = 20.0
_RESTING: Final = (MissionState.IDLE, MissionState.HOVER, MissionState.FAULT)


@dataclass(frozen=True, slots=True)
class FaultFlight:
    """What followed a fault; `reasons` are those that the drone gave for refusing or ending."""

    fault: str
    phase: str
    happened: bool
    """Whether the flight got as far as the phase."""
    state: MissionState
    """The state in which the drone came to rest."""
    reasons: tuple[MissionReason, ...]
    hangs: bool
    """Whether it did not come to rest, or did not land when commanded to."""
    alive: bool
    """Whether the app still runs, without a failed assertion."""
    collisions: int
    """Contacts that the drone caused after the fault, if it kept control of its motors."""


def fly_with_fault(
    pilot: Pilot, goal: Point, fault: str, phase: str, delay_s: float = 0.0
) -> FaultFlight:
    """Fly to the goal and home; let the fault happen delay_s after the phase has begun."""
    happened = _reach(pilot, goal, phase)
    begin_s, refused = pilot.time_s, MissionReason.OK
    if happened:
        pilot.rest(delay_s)
        begin_s = pilot.time_s
        pilot.faults.begin(fault)
        if phase == "ground":
            pilot.rest(_BEGUN_S)
            refused = _say(pilot, MissionCmd.GOTO, goal)
            pilot.rest(_BEGUN_S)
    rests = _until(pilot, lambda: _rests(pilot), _WATCHED_S)
    state, reasons = _state(pilot), _reasons(pilot, begin_s, refused)
    lands = True
    if state.airborne:
        pilot.faults.end("ground-silent")
        _say(pilot, MissionCmd.LAND)
        lands = _until(pilot, lambda: not _state(pilot).airborne, _LANDING_S)
    truth = pilot.truth()
    collisions = [c for c in truth["collision_log"] if c["time_s"] > begin_s]
    return FaultFlight(
        fault, phase, happened, state, reasons, not (rests and lands), truth["app_alive"],
        sum(c["by_drone"] for c in collisions) if _controlled(fault) else 0,
    )  # fmt: skip


def _controlled(fault: str) -> bool:
    """Whether the drone keeps control: faults that stop the motors let it fall."""
    return fault not in ("tumbled", "e-stop")


def _reach(pilot: Pilot, goal: Point, phase: str) -> bool:
    """Fly until the phase begins; false if it does not."""
    pilot.rest(_BEGUN_S)
    if phase == "ground":
        return True
    wanted = _STATE_OF[phase]
    _say(pilot, MissionCmd.GOTO, goal)
    if phase in _AFTERWARDS:
        _until(pilot, lambda: _state(pilot) is MissionState.FOLLOW, _PHASE_S)
        pilot.rest(_ON_THE_WAY_S)
        _say(pilot, MissionCmd.HOLD)
        pilot.rest(_BEGUN_S)
        _say(pilot, _AFTERWARDS[phase])
    return _until(pilot, lambda: _state(pilot) is wanted, _PHASE_S)


def _until(pilot: Pilot, done: Callable[[], bool], limit_s: float) -> bool:
    end_s = pilot.time_s + limit_s
    while not done():
        if pilot.time_s >= end_s:
            return False
        pilot.rest(0.1)
    return True


def _rests(pilot: Pilot) -> bool:
    """Whether the drone stays in a resting state for _REST_S."""
    end_s = pilot.time_s + _REST_S
    while pilot.time_s < end_s:
        if _state(pilot) not in _RESTING:
            return False
        pilot.rest(0.2)
    return True


def _state(pilot: Pilot) -> MissionState:
    return MissionState(int(pilot.onboard("way.state")))


def _say(pilot: Pilot, cmd: MissionCmd, goal: Point | None = None) -> MissionReason:
    """Give a command, and return the reason for its refusal; no answer counts as OK."""
    try:
        return pilot.command(cmd, goal)
    except NoAnswer:
        return MissionReason.OK


def _reasons(pilot: Pilot, since_s: float, refused: MissionReason) -> tuple[MissionReason, ...]:
    told = [
        event.reason
        for event in pilot.picture.events
        if event.code in (EventCode.FAULT, EventCode.REFUSED) and event.drone_ms > 1000 * since_s
    ]
    last = MissionReason(int(pilot.onboard("way.fault")))
    return tuple(dict.fromkeys(reason for reason in (refused, *told, last) if reason))
