# SPDX-License-Identifier: GPL-3.0-or-later
"""The station: messages of a link become a picture, wishes become commands that were acknowledged.

Knows no radio and no web. Everything happens on one asyncio loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import time
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from typing import TypeVar

from ground.core import (
    GRID_SIDE_CELLS,
    WAYPOINTS_A_PACKET,
    WAYPOINTS_MAX,
    MissionCmd,
    MissionReason,
)
from ground.errors import BadWaypoints, LinkLost, NoAnswer, ProtocolMismatch
from ground.link import Link
from ground.listener import Listener
from ground.missing import History
from ground.model import (
    Ack,
    AppRequest,
    Beat,
    Command,
    EmergencyStop,
    Event,
    Heartbeat,
    Hello,
    HelloRequest,
    Incoming,
    LinkChange,
    LinkState,
    LinkStats,
    Outgoing,
    ParameterValue,
    Point,
    SetParameter,
    SnapshotRequest,
    Waypoints,
)
from ground.picture import Picture
from ground.pulse import Pulse
from ground.recovery import RESTART_MS, Recovery
from ground.stick import Steer, Stick
from ground.wire import SEQUENCES
from ground.words import COMMAND_WORDS, refusal

A = TypeVar("A")

REPEAT_S = 0.2
REPEATS = 25
WAYPOINT_LIMIT_M = 30.0
BEAT_DRONE_MS = 500
BEAT_WALL_S = 0.5
_NEW_AFTER = (LinkState.RECONNECTING, LinkState.RESTARTED)


class Station:
    """One drone on one link. Use station_on(), or run() in a task of its own."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._listeners: set[Listener] = set()
        # A start that differs between programs: the drone takes a repeated sequence once.
        self._sequences = itertools.count(time.time_ns() // 1_000_000 % SEQUENCES)
        self._beats = itertools.count()
        self._beaten_ms = 0
        self._beaten_s = float("-inf")
        self._recovery = Recovery()
        self.pulse = Pulse()
        self._ended = asyncio.Event()
        self.picture = Picture()

    @property
    def stats(self) -> LinkStats:
        """Counters of the link."""
        return self._link.stats

    async def run(self) -> None:
        """Take messages until the link ends; then whoever waits for one gets LinkLost."""
        beater = asyncio.create_task(self._beat_by_wall())
        try:
            async for message in self._link.messages():
                self._take(message)
        finally:
            beater.cancel()
            self._ended.set()
            for listener in self._listeners:
                listener.put(None)

    async def ended(self) -> None:
        """Wait until the link is closed or lost. Raises LinkLost in the second case."""
        await self._ended.wait()
        if self.picture.link.state is LinkState.LOST:
            raise LinkLost(f"the link to the drone is gone: {self.picture.link.detail}")

    @contextlib.contextmanager
    def listen(self, *kinds: type[Incoming]) -> Iterator[Listener]:
        """Hear what comes in meanwhile: messages of these kinds, or all."""
        listener = Listener(*kinds)
        self._listeners.add(listener)
        try:
            yield listener
        finally:
            self._listeners.discard(listener)

    async def greet(self) -> Hello:
        """Ask who is there until it answers. Raises NoAnswer, ProtocolMismatch."""
        with self.listen(Hello) as listener:
            hello = await self._ask(HelloRequest(), _as_hello, listener, "hello")
        if hello.side_cells != GRID_SIDE_CELLS:
            raise ProtocolMismatch(
                f"the drone's map has {hello.side_cells} cells a side, this program draws "
                f"{GRID_SIDE_CELLS}: use the same version on both sides"
            )
        return hello

    async def command(self, cmd: MissionCmd, goal: Point | None = None) -> None:
        """Send and repeat until acknowledged. Raises CommandRefused, NoAnswer, LinkLost."""
        sequence = next(self._sequences) % SEQUENCES
        request = Command(sequence, cmd, goal or Point(0.0, 0.0))
        await self._acknowledged(request, f"`{COMMAND_WORDS[cmd]}`")

    async def _acknowledged(self, request: Command | Waypoints, what: str) -> None:
        def answer(message: Incoming) -> Ack | None:
            mine = isinstance(message, Ack) and message.sequence == request.sequence
            return message if isinstance(message, Ack) and mine else None

        with self.listen(Ack) as listener:
            ack = await self._ask(request, answer, listener, what)
        if ack.reason is not MissionReason.OK:
            raise refusal(ack.reason)

    async def give_waypoints(self, points: Sequence[Point]) -> None:
        """Let the drone hold these, for FLY and PATROL. Raises as command() does."""
        if not 0 < len(points) <= WAYPOINTS_MAX:
            raise BadWaypoints(f"1 to {WAYPOINTS_MAX} way points, not {len(points)}")
        if any(not abs(xy) < WAYPOINT_LIMIT_M for p in points for xy in (p.x_m, p.y_m)):
            raise BadWaypoints(f"way points lie within {WAYPOINT_LIMIT_M:.0f} m of the start")
        number = next(self._sequences) % 256
        for first in range(0, len(points), WAYPOINTS_A_PACKET):
            part = tuple(points[first : first + WAYPOINTS_A_PACKET])
            sequence = next(self._sequences) % SEQUENCES
            await self._acknowledged(
                Waypoints(sequence, number, first, len(points), part), "the way points"
            )

    def send_stick(self, stick: Stick) -> int:
        """Fly by hand for the next half second. @return the sequence that a refusal carries"""
        sequence = next(self._sequences) % SEQUENCES
        self.send(Steer(sequence, stick))
        return sequence

    def send(self, request: AppRequest) -> None:
        """Send once, without an answer."""
        self._link.send(request)

    def ask_snapshot(self) -> None:
        """Let the drone send hello, route and the whole map again."""
        self.send(SnapshotRequest())

    async def emergency_stop(self) -> None:
        """Cut the motors through the supervisor; repeat until it says locked, then give up."""
        for _ in range(REPEATS):
            self._link.send(EmergencyStop())
            await asyncio.sleep(REPEAT_S)
            if self.picture.health and self.picture.health.locked:
                return
        raise NoAnswer("the emergency stop was sent, but the drone did not confirm it")

    async def set_parameter(self, name: str, value: float) -> float:
        """Write a parameter of group way; @return what the drone made of it."""

        def answer(message: Incoming) -> ParameterValue | None:
            if isinstance(message, ParameterValue) and message.name == name:
                return message
            return None

        with self.listen(ParameterValue) as listener:
            self._link.send(SetParameter(name, value))
            found = await _heard(answer, listener, REPEATS * REPEAT_S)
        if found is None:
            raise _no_answer(f"`{name}`")
        return found.value

    # --- inside ----------------------------------------------------------------------------------

    async def _ask(
        self,
        request: Outgoing,
        answer: Callable[[Incoming], A | None],
        listener: Listener,
        what: str,
    ) -> A:
        """Send, and send again, until answer() recognises a message."""
        for _ in range(REPEATS):
            self._link.send(request)
            if (found := await _heard(answer, listener, REPEAT_S)) is not None:
                return found
        raise _no_answer(what)

    def _take(self, message: Incoming) -> None:
        restarts = self._recovery.restarts
        if not self._recovery.take(message):
            return
        epoch = self.picture.map.epoch
        before_ms = self.picture.drone_ms
        now_s = time.monotonic()
        if isinstance(message, LinkChange):
            self._link_changed(message)
        self.picture.take(message, now_s)
        if isinstance(message, History):
            self.picture.take_history(message, self._recovery.records.first_missing or 0)
        if isinstance(message, Beat):
            self.pulse.heard(message.sequence, now_s)
        restarted = self._recovery.restarts != restarts
        restarted |= self.picture.drone_ms < before_ms - RESTART_MS
        if restarted or self.picture.map.epoch != epoch:
            self._link.send(HelloRequest())
        self._ask_for_missing()
        if self.picture.drone_ms - self._beaten_ms >= BEAT_DRONE_MS or before_ms < self._beaten_ms:
            self._beat()
        if not isinstance(message, Event) or self._recovery.is_news(message):
            for listener in self._listeners:
                listener.put(message)

    def _ask_for_missing(self) -> None:
        picture = self.picture
        for request in self._recovery.requests(picture.map, picture.route_known, picture.drone_ms):
            self._link.send(request)

    def _link_changed(self, change: LinkChange) -> None:
        if change.state is LinkState.RESTARTED:
            self.picture, self._recovery = Picture(), Recovery()
        if change.state is LinkState.CONNECTED and self.picture.link.state in _NEW_AFTER:
            self.ask_snapshot()

    def _beat(self) -> None:
        self._beaten_ms = self.picture.drone_ms
        self._beaten_s = time.monotonic()
        number = next(self._beats) % SEQUENCES
        self.pulse.sent(number, self._beaten_s)
        self._link.send(Heartbeat(number, self.picture.drone_ms))

    async def _beat_by_wall(self) -> None:
        """Heartbeats go by the drone's clock; where that is not heard, by ours."""
        while True:
            if time.monotonic() - self._beaten_s >= BEAT_WALL_S:
                self._beat()
            await asyncio.sleep(BEAT_WALL_S / 2)


async def _heard(
    answer: Callable[[Incoming], A | None], listener: Listener, limit_s: float
) -> A | None:
    """What answer() makes of the first message that it recognises."""
    until_s = time.monotonic() + limit_s
    while (left_s := until_s - time.monotonic()) > 0:
        message = await listener.next(left_s)
        if isinstance(message, LinkChange) and message.state is LinkState.RESTARTED:
            raise LinkLost(message.detail)  # what was asked of the drone is forgotten there
        if message is not None and (found := answer(message)) is not None:
            return found
    return None


def _no_answer(what: str) -> NoAnswer:
    return NoAnswer(f"no answer to {what} within {REPEATS * REPEAT_S:.0f} s")


def _as_hello(message: Incoming) -> Hello | None:
    return message if isinstance(message, Hello) else None


@contextlib.asynccontextmanager
async def station_on(link: Link, made: Station | None = None) -> AsyncIterator[Station]:
    """Open the link, run a station on it, make sure that a Wayflie answers; close at the end."""
    await link.open()
    station = made or Station(link)
    running = asyncio.create_task(station.run())
    try:
        await station.greet()
        station.ask_snapshot()
        yield station
    finally:
        await link.close()
        await running
