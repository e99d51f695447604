# SPDX-License-Identifier: GPL-3.0-or-later
"""Give one command and wait for its outcome."""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import dataclass

from ground.core import EventCode, MissionCmd, MissionReason, MissionState
from ground.errors import CommandRefused, GroundError, LinkLost
from ground.link.logstream import CLOCK_MS
from ground.model import Event, Incoming, LinkChange, LinkState, Point, Telemetry
from ground.station.listener import Listener
from ground.station.station import Station
from ground.words import EXPLORED_PARTLY, REASON_WORDS, STATE_WORDS

SILENCE_S = 10.0  # after so long without a message, the link counts as lost
SEARCH_S = 60.0  # the same while the link looks for the drone
SETTLED_MS = 5000  # a resting state that lasts this long is final
NEAR_M = 0.25
REFUSAL_EVENT_S = 0.3
LANDING_S = 60.0

# The state in which each command ends.
_END_STATES = {
    MissionCmd.TAKE_OFF: MissionState.HOVER,
    MissionCmd.GOTO: MissionState.HOVER,
    MissionCmd.EXPLORE: MissionState.IDLE,
    MissionCmd.HOME: MissionState.IDLE,
    MissionCmd.LAND: MissionState.IDLE,
    MissionCmd.HOLD: MissionState.HOVER,
    MissionCmd.SCAN: MissionState.HOVER,
    MissionCmd.RELOCALISE: MissionState.HOVER,
    MissionCmd.SPIN: MissionState.HOVER,
    MissionCmd.FLY: MissionState.HOVER,
    MissionCmd.PATROL: MissionState.HOVER,  # only after HOLD: a patrol has no end of its own
}
# Never given in their end state already, so seeing that state once is enough.
_FROM_ELSEWHERE = (MissionCmd.TAKE_OFF, MissionCmd.HOME, MissionCmd.LAND, MissionCmd.HOLD)
# Commands that end the flight: after a fault on board, still wait for the landing.
_DESCENDING = (MissionCmd.HOME, MissionCmd.LAND)
# Faults after which the drone relocalises and continues, or else lands.
_TRANSIENT = (MissionReason.LOST,)
_RESTING = (MissionState.IDLE, MissionState.HOVER, MissionState.FAULT)


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a command ended; `place` is where the drone arrived, or the nearest reachable point."""

    reached: bool
    sentence: str
    reason: MissionReason = MissionReason.OK
    place: Point | None = None

    @property
    def told(self) -> str:
        """The outcome in one line."""
        if self.reached or self.place is None:
            return self.sentence
        nearest = f"({self.place.x_m:.2f}, {self.place.y_m:.2f})"
        return f"{self.sentence}; the nearest point that can be reached is {nearest}"


class Watch:
    """Judges messages one by one; `since_ms` is the drone's clock when the command was given."""

    def __init__(self, cmd: MissionCmd, goal: Point | None, since_ms: int) -> None:
        self._cmd = cmd
        self._goal = goal
        self._since_ms = since_ms
        self.acknowledged_ms = since_ms
        self._explored = False
        self._partly = False
        self._resting: MissionState | None = None
        self._resting_since_ms = 0

    def judge(self, message: Incoming) -> Outcome | None:
        """The outcome, as soon as it is known. Raises LinkLost."""
        match message:
            case Event() if not _earlier(message.drone_ms, self._since_ms):
                return self._judge_event(message)
            case Telemetry():
                return self._judge_telemetry(message)
            case LinkChange(LinkState.LOST, detail):
                raise LinkLost(f"the link to the drone is gone: {detail}")
            case LinkChange(LinkState.RESTARTED, detail):
                raise LinkLost(detail)
        return None

    def _judge_event(self, event: Event) -> Outcome | None:
        match event.code:
            case EventCode.REFUSED:
                return Outcome(False, REASON_WORDS[event.reason], event.reason, event.place)
            case EventCode.FAULT if self._cmd not in _DESCENDING and event.reason not in _TRANSIENT:
                return Outcome(False, REASON_WORDS[event.reason], event.reason)
            case EventCode.ARRIVED if self._cmd is MissionCmd.GOTO:
                return Outcome(True, "arrived", place=event.place)
            case EventCode.EXPLORED:
                self._explored = event.argument == 0
                self._partly = not self._explored
            case EventCode.STATE:
                return self._judge_state(MissionState(event.argument))
        return None

    def _judge_state(self, state: MissionState) -> Outcome | None:
        """Judge the state that was entered."""
        if state is MissionState.FAULT:
            return Outcome(False, STATE_WORDS[state])
        if state is not _END_STATES[self._cmd] or self._cmd is MissionCmd.GOTO:
            return None
        if self._cmd is MissionCmd.EXPLORE and not self._explored:
            return None  # the event EXPLORED may have been lost, and be repeated later
        return Outcome(True, "done")

    def _judge_telemetry(self, telemetry: Telemetry) -> Outcome | None:
        """Decide by a state that lasts, in case events were lost.

        Telemetry from before the acknowledgement may precede the command, so it is ignored.
        """
        if _earlier(telemetry.drone_ms, self.acknowledged_ms):
            return None
        state, ended = telemetry.state, telemetry.state is _END_STATES[self._cmd]
        if ended and self._cmd in _FROM_ELSEWHERE and telemetry.drone_ms > self._since_ms:
            return Outcome(True, "done")
        if state not in _RESTING or state is not self._resting:
            self._resting = state if state in _RESTING else None
            self._resting_since_ms = telemetry.drone_ms
            return None
        if telemetry.drone_ms - self._resting_since_ms < SETTLED_MS:
            return None
        if ended and self._is_there(telemetry):
            return Outcome(True, "done", place=Point(telemetry.pose.x_m, telemetry.pose.y_m))
        reason = telemetry.fault
        return Outcome(False, REASON_WORDS[reason] if reason else self._unknown, reason)

    @property
    def _unknown(self) -> str:
        """What to say of an end that nothing explains."""
        if self._partly:
            return EXPLORED_PARTLY
        if self._cmd is MissionCmd.EXPLORE:
            return "it landed before everything was explored"
        return "it stopped on the way without giving a reason"

    def _is_there(self, telemetry: Telemetry) -> bool:
        if self._cmd is MissionCmd.EXPLORE:
            return self._explored
        if self._cmd is not MissionCmd.GOTO or self._goal is None:
            return True
        dx_m = telemetry.pose.x_m - self._goal.x_m
        dy_m = telemetry.pose.y_m - self._goal.y_m
        return dx_m * dx_m + dy_m * dy_m < NEAR_M * NEAR_M


async def fly(station: Station, cmd: MissionCmd, goal: Point | None = None) -> Outcome:
    """Give a command and wait for its outcome. Raises LinkLost, NoAnswer."""
    watch = Watch(cmd, goal, station.picture.drone_ms)
    with station.listen(Event, Telemetry) as listener:
        try:
            await station.command(cmd, goal)
        except CommandRefused as refusal:
            place = await _nearest_point(listener)
            return Outcome(False, str(refusal), refusal.reason, place)
        watch.acknowledged_ms = station.acknowledged_ms
        while True:
            searching = station.picture.link.state is LinkState.RECONNECTING
            patience_s = SEARCH_S if searching else SILENCE_S
            message = await listener.next(patience_s)
            if message is None:
                raise LinkLost(f"the drone was not heard for {patience_s:.0f} s")
            if outcome := watch.judge(message):
                return outcome


async def bring_down(station: Station) -> None:
    """Land if the drone flies; errors are ignored, since the drone's failsafe lands it then."""
    if station.picture.state.airborne:
        with contextlib.suppress(GroundError, TimeoutError):
            async with asyncio.timeout(LANDING_S):
                await fly(station, MissionCmd.LAND)


async def _nearest_point(listener: Listener) -> Point | None:
    """The place in the event beside a refusal: the nearest reachable point, if there is one."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(REFUSAL_EVENT_S):
            while True:
                message = await listener.next()
                if isinstance(message, Event) and message.code is EventCode.REFUSED:
                    return message.place
    return None


def _earlier(a_ms: int, b_ms: int) -> bool:
    """Whether a is earlier; compared in 24 bits, since log packets carry no more of the clock."""
    return (a_ms - b_ms) % CLOCK_MS > CLOCK_MS // 2
