# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user can do next after each kind of error."""

from __future__ import annotations

from ground.core import MissionReason
from ground.errors import (
    BadWaypoints,
    CommandRefused,
    GroundError,
    LinkLost,
    NoAnswer,
    ProtocolMismatch,
    StopLatched,
)

FLASH = "`make firmware` and `make flash` of this checkout"
PUT_ON = "switch off, put it on with the pins straight, switch on"
_NEARER = "name another place: the page, or `wayflie map save map.png`, shows what is free"
_RESTART = "set it upright on the floor, switch it off and on"
_AREA = "name a place inside, or widen way.areaX0, way.areaY0, way.areaX1, way.areaY1"
_CHARGE = "charge it; way.lowBat is the limit"

_REACHING = {
    "udp": "start a simulator: `wayflie sim`, in another terminal",
    "radio": "switch the drone on; its channel, rate and address: `wayflie scan`",
    "usb": "plug the cable in and switch the drone on",
    "serial": "the other end must speak CPX: the deck's UART, at 576000 baud",
}

_BY_KIND: dict[type[GroundError], str] = {
    LinkLost: "`wayflie ground` connects again; meanwhile the drone does what way.lost says",
    NoAnswer: "`wayflie doctor` looks at the link and at the drone",
    ProtocolMismatch: FLASH,
    StopLatched: "release it on the page",
    BadWaypoints: "`wayflie fly --help` says what they are",
}

_BY_REASON: dict[MissionReason, str] = {
    MissionReason.NO_FLOW_DECK: PUT_ON,
    MissionReason.NO_RANGER_DECK: PUT_ON,
    MissionReason.BATTERY_LOW: _CHARGE,
    MissionReason.BATTERY_EMPTY: _CHARGE,
    MissionReason.ESTIMATOR: "set it on a floor with texture, in the light, and try again",
    MissionReason.CANNOT_FLY: "arm a Brushless; after a stop or a crash: " + _RESTART,
    MissionReason.OUTSIDE_GRID: "name a nearer place, or set a larger way.cell before it maps",
    MissionReason.OUTSIDE_AREA: _AREA,
    MissionReason.BAD_AREA: "set way.areaX0 to way.areaY1 anew, or a larger way.cell",
    MissionReason.GOAL_OCCUPIED: _NEARER,
    MissionReason.GOAL_UNREACHABLE: "`wayflie explore` looks for ways; or a smaller way.clearance",
    MissionReason.FLYING: "land first",
    MissionReason.STUCK: "look at the page of `wayflie ground`: what is around it?",
    MissionReason.RANGES_FROZEN: "switch it off and on; then `wayflie doctor`",
    MissionReason.TUMBLED: _RESTART,
    MissionReason.SELF_TEST: "wait until way.selfState is 2 or 3",
    MissionReason.LOST: "carry it to where it has been; switched off and on it begins a new map",
    MissionReason.NO_MAP: "`wayflie explore` makes one, `wayflie map load FILE` brings one",
    MissionReason.NO_WAYPOINTS: "`wayflie fly X,Y ...` names them",
    MissionReason.FLOW_LOST: "give it a floor with texture and light; fly no higher than 2 m",
    MissionReason.BLIND: "clean the sensors; then `wayflie doctor`",
    MissionReason.LINK_LOST: "come nearer; `wayflie doctor` measures the link",
}


def reaching(uri: str, reason: str = "") -> str:
    """What to do if nobody answers at this URI; `reason` is what cflib says about it."""
    if "dongle" in reason:
        return "plug a Crazyradio in; `wayflie doctor` looks for it and for leave to use it"
    return _REACHING.get(uri.partition("://")[0], "`wayflie scan` lists who answers")


def after(reason: MissionReason) -> str:
    """What to do about a reason that the drone gives; empty if nothing is known."""
    return _BY_REASON.get(reason, "")


def next_step(error: GroundError) -> str:
    """The next step that the error itself carries, or that its kind suggests; else empty."""
    if error.step:
        return error.step
    if isinstance(error, CommandRefused):
        return after(error.reason)
    return _BY_KIND.get(type(error), "")
