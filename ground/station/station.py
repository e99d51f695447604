# SPDX-License-Identifier: GPL-3.0-or-later
"""The station: turns messages of a link into a picture, and requests into acknowledged commands.

Knows neither radio nor web page. Everything happens on one asyncio loop.
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
from ground.link.protocol import Link
from ground.link.wire import SEQUENCES
from ground.model import (
    Ack,
    Beat,
    Event,
    Hello,
    History,
    Incoming,
    LinkChange,
    LinkState,
    LinkStats,
    ParameterValue,
    Point,
)
from ground.requests import (
    AppRequest,
    Command,
    EmergencyStop,
    Heartbeat,
    HelloRequest,
    Outgoing,
    SetParameter,
    SnapshotRequest,
    Steer,
    Stick,
    Waypoints,
)
from ground.station.listener import Listener
from ground.station.picture import Picture
from ground.station.pulse import Pulse
from ground.station.recovery import RESTART_MS, Recovery
from ground.words import COMMAND_WORDS, refusal

A = TypeVar("A", Hello, Ack, ParameterValue)

REPEAT_S = 0.2
REPEATS = 25
WAYPOINT_LIMIT_M = 30.0
BEAT_DRONE_MS = 500
BEAT_WALL_S = 0.5
_NEW_AFTER = (LinkState.RECONNECTING, LinkState.RESTARTED)


class Station:
    """One drone on one link. Use station_on(), or run() in its own task."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._listeners: set[Listener] = set()
        # Differs between programs, since the drone ignores a sequence number that it has just seen.
        self._sequences = itertools.count(time.time_ns() // 1_000_000 % SEQUENCES)
        self._beats = itertools.count()
        self._beaten_ms = 0
        self._beaten_s = float("-inf")
        self._recovery = Recovery()
        self.pulse = Pulse()
        self._ended = asyncio.Event()
        self.acknowledged_ms = 0
        """The drone's clock when the latest acknowledgement came."""
        self.picture = Picture()

    @property
    def stats(self) -> LinkStats:
        """Counters of the link."""
        return self._link.stats

    async def run(self) -> None:
        """Take messages until the link ends; listeners that still wait get LinkLost."""
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
        """Wait until the link is closed or lost. Raises LinkLost if it was lost."""
        await self._ended.wait()
        if self.picture.link.state is LinkState.LOST:
            raise LinkLost(f"the link to the drone is gone: {self.picture.link.detail}")

    @contextlib.contextmanager
    def listen(self, *kinds: type[Incoming]) -> Iterator[Listener]:
        """Collect messages of these kinds, or of all, while the context is open."""
        listener = Listener(*kinds)
        self._listeners.add(listener)
        try:
            yield listener
        finally:
            self._listeners.discard(listener)

    async def greet(self) -> Hello:
        """Ask for the drone's hello until it answers. Raises NoAnswer, ProtocolMismatch."""
        hello = await self._ask(HelloRequest(), Hello, "hello")
        if hello.side_cells != GRID_SIDE_CELLS:
            raise ProtocolMismatch(
                f"the drone's map has {hello.side_cells} cells a side, this program draws "
                f"{GRID_SIDE_CELLS}: use the same version on both sides"
            )
        return hello

    async def command(self, cmd: MissionCmd, goal: Point | None = None) -> None:
        """Send a command until it is acknowledged. Raises CommandRefused, NoAnswer, LinkLost."""
        sequence = next(self._sequences) % SEQUENCES
        request = Command(sequence, cmd, goal or Point(0.0, 0.0))
        await self._acknowledged(request, f"`{COMMAND_WORDS[cmd]}`")

    async def _acknowledged(self, request: Command | Waypoints, what: str) -> None:
        ack = await self._ask(request, Ack, what, lambda ack: ack.sequence == request.sequence)
        if ack.reason is not MissionReason.OK:
            raise refusal(ack.reason)

    async def give_waypoints(self, points: Sequence[Point]) -> None:
        """Send the drone waypoints for FLY and PATROL. Raises as command() does."""
        if not 0 < len(points) <= WAYPOINTS_MAX:
            raise BadWaypoints(f"1 to {WAYPOINTS_MAX} waypoints, not {len(points)}")
        if any(not abs(xy) < WAYPOINT_LIMIT_M for p in points for xy in (p.x_m, p.y_m)):
            raise BadWaypoints(f"waypoints lie within {WAYPOINT_LIMIT_M:.0f} m of the start")
        number = next(self._sequences) % 256
        for first in range(0, len(points), WAYPOINTS_A_PACKET):
            part = tuple(points[first : first + WAYPOINTS_A_PACKET])
            sequence = next(self._sequences) % SEQUENCES
            await self._acknowledged(
                Waypoints(sequence, number, first, len(points), part), "the waypoints"
            )

    def send_stick(self, stick: Stick) -> int:
        """Fly by hand for the next half second. @return the sequence that a refusal carries"""
        sequence = next(self._sequences) % SEQUENCES
        self.send(Steer(sequence, stick))
        return sequence

    def send(self, request: AppRequest) -> None:
        """Send once, without waiting for an answer."""
        self._link.send(request)

    def ask_snapshot(self) -> None:
        """Ask the drone to send hello, route and the whole map again."""
        self.send(SnapshotRequest())

    async def emergency_stop(self) -> None:
        """Have the supervisor stop the motors; repeat until it reports locked. Raises NoAnswer."""
        for _ in range(REPEATS):
            self._link.send(EmergencyStop())
            await asyncio.sleep(REPEAT_S)
            if self.picture.health and self.picture.health.locked:
                return
        raise NoAnswer("the emergency stop was sent, but the drone did not confirm it")

    async def set_parameter(self, name: str, value: float) -> float:
        """Write a parameter of group way. @return the value that the drone reports afterwards"""
        with self.listen(ParameterValue) as listener:
            self._link.send(SetParameter(name, value))
            limit_s = REPEATS * REPEAT_S
            found = await _heard(listener, ParameterValue, lambda one: one.name == name, limit_s)
        if found is None:
            raise _no_answer(f"`{name}`")
        return found.value

    # --- inside ----------------------------------------------------------------------------------

    async def _ask(
        self,
        request: Outgoing,
        kind: type[A],
        what: str,
        answers: Callable[[A], bool] = lambda message: True,
    ) -> A:
        """Send a request until a message of this kind answers it."""
        with self.listen(kind) as listener:
            for _ in range(REPEATS):
                self._link.send(request)
                if (found := await _heard(listener, kind, answers, REPEAT_S)) is not None:
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
        if isinstance(message, Ack):
            self.acknowledged_ms = self.picture.drone_ms
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
        """Send heartbeats by our clock while the drone's clock is not heard."""
        while True:
            if time.monotonic() - self._beaten_s >= BEAT_WALL_S:
                self._beat()
            await asyncio.sleep(BEAT_WALL_S / 2)


async def _heard(
    listener: Listener, kind: type[A], answers: Callable[[A], bool], limit_s: float
) -> A | None:
    """The first message of this kind that answers, or None after limit_s."""
    until_s = time.monotonic() + limit_s
    while (left_s := until_s - time.monotonic()) > 0:
        message = await listener.next(left_s)
        if isinstance(message, LinkChange) and message.state is LinkState.RESTARTED:
            raise LinkLost(message.detail)  # the restarted drone has forgotten the request
        if isinstance(message, kind) and answers(message):
            return message
    return None


def _no_answer(what: str) -> NoAnswer:
    return NoAnswer(f"no answer to {what} within {REPEATS * REPEAT_S:.0f} s")


@contextlib.asynccontextmanager
async def station_on(link: Link, made: Station | None = None) -> AsyncIterator[Station]:
    """Open the link, run a station on it and greet the drone; close everything at the end."""
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
