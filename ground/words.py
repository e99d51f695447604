# SPDX-License-Identifier: GPL-3.0-or-later
"""The words for states, reasons, commands and events that a user reads."""

from __future__ import annotations

from typing import Literal

from ground.core import EventCode, MissionCmd, MissionReason, MissionState, SelfTest, Source
from ground.errors import CommandRefused
from ground.model import Event

Level = Literal["info", "good", "warning", "error"]

STATE_WORDS: dict[MissionState, str] = {
    MissionState.IDLE: "on the ground",
    MissionState.TAKEOFF: "taking off",
    MissionState.SCAN: "looking around",
    MissionState.PLAN: "planning a route",
    MissionState.FOLLOW: "flying",
    MissionState.AVOID: "backing away from something near",
    MissionState.HOVER: "holding its place",
    MissionState.RETURN: "flying home",
    MissionState.LAND: "landing",
    MissionState.FAULT: "stopped by a fault",
    MissionState.RELOCALISE: "finding its place in the map",
    MissionState.SPIN: "turning in place",
}

EXPLORED = "everything that can be reached is explored"
EXPLORED_PARTLY = "explored, except for places that could not be observed"
REASON_WORDS: dict[MissionReason, str] = {
    MissionReason.OK: "all is well",
    MissionReason.NO_FLOW_DECK: "no Flow deck is fitted",
    MissionReason.NO_RANGER_DECK: "no Multi-ranger deck is fitted",
    MissionReason.BATTERY_LOW: "the battery is low",
    MissionReason.BATTERY_EMPTY: "the battery is empty",
    MissionReason.ESTIMATOR: "the position estimate has not settled, or it jumped",
    MissionReason.CANNOT_FLY: "the supervisor does not let it fly (not armed, locked or crashed)",
    MissionReason.BAD_VALUE: "a value is not a number, or out of range",
    MissionReason.OUTSIDE_GRID: "the goal is outside the map's grid",
    MissionReason.OUTSIDE_AREA: "the goal is outside the permitted area",
    MissionReason.GOAL_OCCUPIED: "the goal is too near to an obstacle",
    MissionReason.GOAL_UNREACHABLE: "no route to the goal is known",
    MissionReason.NOT_FLYING: "it is not flying",
    MissionReason.UNKNOWN_COMMAND: "the drone does not know this command",
    MissionReason.BAD_AREA: "the permitted area is empty or larger than the grid",
    MissionReason.FLYING: "this is only possible on the ground",
    MissionReason.LINK_LOST: "the ground was silent for too long",
    MissionReason.STUCK: "too many attempts brought no progress",
    MissionReason.RANGES_FROZEN: "the distance sensors have stopped changing",
    MissionReason.TUMBLED: "it tumbled",
    MissionReason.SELF_TEST: "its self-test is running",
    MissionReason.LOST: "it could not find its place in the map",
    MissionReason.NO_MAP: "it has no map to find its place in",
    MissionReason.NO_WAYPOINTS: "it has no waypoints",
    MissionReason.FLOW_LOST: "the flow sensor sees nothing of the floor",
    MissionReason.BLIND: "one of its distance sensors is stuck or dead",
    MissionReason.BUSY: "it is busy: let it hold its place first",
}

SELF_TEST_WORDS: dict[SelfTest, str] = {
    SelfTest.NOT_RUN: "not run",
    SelfTest.RUNNING: "running",
    SelfTest.AGREES: "agrees with a PC",
    SelfTest.DIFFERS: "differs from a PC",
}

SOURCE_WORDS: dict[Source, str] = {
    Source.ODOMETRY: "odometry alone",
    Source.SLAM: "SLAM",
    Source.SLAM_ESTIMATOR: "SLAM, also for the estimator",
    Source.LIGHTHOUSE: "Lighthouse",
    Source.LOCO: "Loco",
    Source.EXTERNAL: "positions from the ground",
}

COMMAND_WORDS: dict[MissionCmd, str] = {
    MissionCmd.NONE: "nothing",
    MissionCmd.TAKE_OFF: "take off",
    MissionCmd.GOTO: "go to a point",
    MissionCmd.EXPLORE: "explore",
    MissionCmd.HOME: "fly home",
    MissionCmd.LAND: "land",
    MissionCmd.HOLD: "hold",
    MissionCmd.SCAN: "look around",
    MissionCmd.FORGET: "forget the map",
    MissionCmd.RELOCALISE: "find its place in the map",
    MissionCmd.SPIN: "turn in place",
    MissionCmd.FLY: "fly along the waypoints",
    MissionCmd.PATROL: "patrol along the waypoints",
}


def event_words(event: Event) -> tuple[str, Level]:
    """What happened on board, in words, and how serious it is."""
    match event.code:
        case EventCode.STATE:
            return STATE_WORDS[MissionState(event.argument)], "info"
        case EventCode.REFUSED:
            return f"refused: {REASON_WORDS[event.reason]}", "warning"
        case EventCode.FAULT:
            return REASON_WORDS[event.reason], "error"
        case EventCode.ARRIVED:
            return "arrived", "good"
        case EventCode.EXPLORED if event.argument:
            return EXPLORED_PARTLY, "warning"
        case EventCode.EXPLORED:
            return EXPLORED, "good"
        case EventCode.FOUND:
            return "it has found its place in the map again", "good"
        case EventCode.WAYPOINT:
            return f"at waypoint {event.argument + 1}", "info"
        case EventCode.SKIPPED:
            place = f"({event.place.x_m:.2f}, {event.place.y_m:.2f})"
            return f"waypoint {place} left out: {REASON_WORDS[event.reason]}", "warning"


def refusal(reason: MissionReason) -> CommandRefused:
    """Make the error for a refused command."""
    return CommandRefused(REASON_WORDS[reason], reason)
