# SPDX-License-Identifier: GPL-3.0-or-later
"""The latest of everything: what the ground knows of one drone."""

from __future__ import annotations

from collections import deque

from ground.core import MissionState, Source
from ground.logstream import near
from ground.map import GroundMap
from ground.missing import History, MapPacket
from ground.model import (
    Beat,
    Console,
    Event,
    Health,
    Hello,
    Incoming,
    LinkChange,
    LinkState,
    Odometry,
    ParameterValue,
    Point,
    Positioned,
    Ranges,
    RoutePiece,
    Telemetry,
)
from ground.trail import Trail

EVENTS_KEPT = 100
SEQUENCES = 1 << 16
HALF = SEQUENCES // 2
CONSOLE_LINES = 100


class Picture:
    """Takes messages in, keeps the newest of each kind. Owns no task and no clock."""

    def __init__(self) -> None:
        self.telemetry: Telemetry | None = None
        self.health: Health | None = None
        self.ranges: Ranges | None = None
        self.odometry: Odometry | None = None
        self.source: Source | None = None
        self.hello: Hello | None = None
        self.link = LinkChange(LinkState.CLOSED, "not connected")
        self.map = GroundMap()
        self.route: tuple[Point, ...] = ()
        self.route_complete = True
        self.trail = Trail()
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self.console: deque[str] = deque([""], maxlen=CONSOLE_LINES)
        self.parameters: dict[str, float] = {}
        self.drone_ms = 0
        self._route_parts: dict[int, Point] = {}
        self._route_revision: int | None = None

    @property
    def state(self) -> MissionState:
        """What the drone is doing, as far as is known."""
        return self.telemetry.state if self.telemetry else MissionState.IDLE

    def take(self, message: Incoming, now_s: float) -> None:
        """Put one message into its place."""
        match message:
            case Telemetry():
                self.telemetry = message
                self.trail.take_telemetry(message)
            case MapPacket():
                self.map.take_packet(message, now_s)
            case Health():
                self.health = message
            case Ranges():
                self.ranges = message
            case Odometry():
                self.odometry = message
            case Positioned():
                self.source = message.source
            case Hello():
                self.hello = message
                self.map.take_hello(message)
            case RoutePiece():
                self._take_route(message)
            case Event():
                self._take_event(message)
            case LinkChange():
                self.link = message
            case Console(text):
                self._take_console(text)
            case ParameterValue(name, value):
                self.parameters[name] = value
        match message:
            case Telemetry() | Health() | Ranges() | Odometry() | Positioned():
                self.drone_ms = message.drone_ms
            case Beat():  # more bits of the same clock
                self.drone_ms = near(message.drone_ms, self.drone_ms or message.drone_ms)

    def take_history(self, history: History, first_missing: int) -> None:
        """Records of the way; those behind one that is missing wait for it."""
        self.trail.take_history(history, first_missing, self.drone_ms)

    def _take_event(self, event: Event) -> None:
        """In the order of their numbers, whenever they come."""
        later = []
        while self.events and (self.events[-1].sequence - event.sequence) % SEQUENCES < HALF:
            later.append(self.events.pop())
        self.events.extend((event, *reversed(later)))

    @property
    def route_known(self) -> tuple[int, int] | None:
        """Revision and number of points, once all its pieces have come."""
        if self._route_revision is None or not self.route_complete:
            return None
        return self._route_revision, len(self.route)

    def _take_route(self, piece: RoutePiece) -> None:
        """Show a route once all its pieces have come."""
        if piece.revision != self._route_revision:
            self._route_revision = piece.revision
            self._route_parts = {}
        for offset, point in enumerate(piece.points):
            self._route_parts[piece.first + offset] = point
        self.route_complete = all(i in self._route_parts for i in range(piece.total))
        if self.route_complete:
            self.route = tuple(self._route_parts[i] for i in range(piece.total))

    def _take_console(self, text: str) -> None:
        first, *rest = text.split("\n")
        self.console[-1] += first
        self.console.extend(rest)
