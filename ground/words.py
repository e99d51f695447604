# SPDX-License-Identifier: GPL-3.0-or-later
"""States, reasons and commands in the words that a user reads."""

from __future__ import annotations

from ground.core import MissionCmd, MissionReason, MissionState, SelfTest, Source
from ground.errors import CommandRefused

STATE_WORDS: dict[MissionState, str] = {
    MissionState.IDLE: "on the ground",
    MissionState.TAKEOFF: "taking off",
    MissionState.SCAN: "looking around",
    MissionState.PLAN: "planning a way",
    MissionState.FOLLOW: "flying",
    MissionState.AVOID: "backing away from something near",
    MissionState.HOVER: "holding its place",
    MissionState.RETURN: "flying home",
    MissionState.LAND: "landing",
    MissionState.FAULT: "stopped by a fault",
    MissionState.RELOCALISE: "finding out where it is in its map",
    MissionState.SPIN: "turning in place",
}

EXPLORED = "everything that can be reached is explored"
EXPLORED_PARTLY = "explored, but for places that looking did not show"
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
    MissionReason.GOAL_UNREACHABLE: "no way leads to the goal, as far as the map knows",
    MissionReason.NOT_FLYING: "it is not flying",
    MissionReason.UNKNOWN_COMMAND: "the drone does not know this command",
    MissionReason.BAD_AREA: "the permitted area is empty or larger than the grid",
    MissionReason.FLYING: "this is only possible on the ground",
    MissionReason.LINK_LOST: "the ground was silent for too long",
    MissionReason.STUCK: "too many attempts brought no progress",
    MissionReason.RANGES_FROZEN: "the distance sensors have stopped changing",
    MissionReason.TUMBLED: "it tumbled",
    MissionReason.SELF_TEST: "its self-test is running",
    MissionReason.LOST: "it could not find out where it is in its map",
    MissionReason.NO_MAP: "it has no map to find itself in",
    MissionReason.NO_WAYPOINTS: "it has no way points",
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
    MissionCmd.FLY: "fly along the way points",
    MissionCmd.PATROL: "patrol along the way points",
}


def refusal(reason: MissionReason) -> CommandRefused:
    """To raise, or to hand on."""
    return CommandRefused(REASON_WORDS[reason], reason)
