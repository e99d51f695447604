# SPDX-License-Identifier: GPL-3.0-or-later
"""What to do next, for everything that goes wrong."""

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
_NEARER = (
    "another place: `wayflie map save map.png` or the page of `wayflie ground` shows what is free"
)
_RESTART = "set it upright on the floor, switch it off and on"
_AREA = "a place inside, or widen way.areaX0, way.areaY0, way.areaX1, way.areaY1"
_CHARGE = "charge it; way.lowBat is the limit"

_REACHING = {
    "udp": "start one: `wayflie sim`, in another terminal",
    "radio": "switch the drone on; its channel, rate and address: `wayflie scan`",
    "usb": "plug the cable in and switch the drone on",
    "serial": "let the other end speak CPX; the deck's UART, at 576000 baud",
}

_BY_KIND: dict[type[GroundError], str] = {
    LinkLost: "`wayflie ground` connects again; by itself it does what way.lost says",
    NoAnswer: "`wayflie doctor` looks at the link and at the drone",
    ProtocolMismatch: FLASH,
    StopLatched: "release it on the page",
    BadWaypoints: "`wayflie fly --help`",
}

_BY_REASON: dict[MissionReason, str] = {
    MissionReason.NO_FLOW_DECK: "switch off, put it on with the pins straight, switch on",
    MissionReason.NO_RANGER_DECK: "switch off, put it on with the pins straight, switch on",
    MissionReason.BATTERY_LOW: _CHARGE,
    MissionReason.BATTERY_EMPTY: _CHARGE,
    MissionReason.ESTIMATOR: "set it on a floor with texture, in the light, and try again",
    MissionReason.CANNOT_FLY: "arm a Brushless; after a stop or a crash: " + _RESTART,
    MissionReason.OUTSIDE_GRID: "a nearer place, or larger cells: way.cell, before the map is made",
    MissionReason.OUTSIDE_AREA: _AREA,
    MissionReason.BAD_AREA: "set way.areaX0 to way.areaY1 anew, or way.cell larger",
    MissionReason.GOAL_OCCUPIED: _NEARER,
    MissionReason.GOAL_UNREACHABLE: "`wayflie explore` looks for ways; a smaller way.clearance",
    MissionReason.FLYING: "`wayflie land` first",
    MissionReason.STUCK: "look at the page of `wayflie ground`: what is around it?",
    MissionReason.RANGES_FROZEN: "switch it off and on; `wayflie doctor`",
    MissionReason.TUMBLED: _RESTART,
    MissionReason.SELF_TEST: "wait until way.selfState is 2 or 3",
    MissionReason.LOST: "carry it to where it has been, or let it forget the map on the page",
    MissionReason.NO_MAP: "`wayflie explore`, or `wayflie map load FILE`",
    MissionReason.NO_WAYPOINTS: "`wayflie fly X,Y ...`",
    MissionReason.FLOW_LOST: "a floor with texture, more light, not higher than 2 m",
    MissionReason.BLIND: "clean the sensors; `wayflie doctor`",
    MissionReason.LINK_LOST: "come nearer; `wayflie doctor` measures the link",
}


def reaching(uri: str) -> str:
    """What to do where nobody answers at this URI."""
    return _REACHING.get(uri.partition("://")[0], "`wayflie scan` lists who answers")


def after(reason: MissionReason) -> str:
    """What to do where the drone gives this reason; nothing is known of some."""
    return _BY_REASON.get(reason, "")


def next_step(error: GroundError) -> str:
    """What the error says itself, or what helps with its kind."""
    if error.step:
        return error.step
    if isinstance(error, CommandRefused):
        return after(error.reason)
    return _BY_KIND.get(type(error), "")
