# SPDX-License-Identifier: GPL-3.0-or-later
"""The latest state of one drone, as the ground knows it."""

from __future__ import annotations

from collections import deque

from ground.core import MissionState, Source
from ground.link.logstream import near
from ground.link.wire import SEQUENCES
from ground.map.groundmap import GroundMap
from ground.model import (
    Beat,
    Console,
    Event,
    Health,
    Hello,
    History,
    Incoming,
    LinkChange,
    LinkState,
    MapPacket,
    Odometry,
    ParameterValue,
    Point,
    Positioned,
    Ranges,
    RoutePiece,
    Telemetry,
)
from ground.station.trail import Trail

EVENTS_KEPT = 100
CONSOLE_LINES = 100


class Picture:
    """Keeps the newest message of each kind; has no task and no clock of its own."""

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
        self.odometry_trail = Trail()
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self.console: deque[str] = deque([""], maxlen=CONSOLE_LINES)
        self.parameters: dict[str, float] = {}
        self.drone_ms = 0
        self._route_parts: dict[int, Point] = {}
        self._route_revision: int | None = None

    @property
    def state(self) -> MissionState:
        """The drone's last known mission state; IDLE before any."""
        return self.telemetry.state if self.telemetry else MissionState.IDLE

    @property
    def begun(self) -> bool:
        """Whether each measurement that a rerun needs has come."""
        return None not in (self.telemetry, self.health, self.odometry, self.ranges)

    def take(self, message: Incoming, now_s: float) -> None:
        """Take in one message."""
        match message:
            case Telemetry():
                self.telemetry = message
                self._leave_trail(self.trail, message)
            case MapPacket():
                self.map.take_packet(message, now_s)
            case Health():
                self.health = message
            case Ranges():
                self.ranges = message
            case Odometry():
                self.odometry = message
                self._leave_trail(self.odometry_trail, message)
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
            case Beat():  # the same clock with more bits
                self.drone_ms = near(message.drone_ms, self.drone_ms or message.drone_ms)

    def take_history(self, history: History, first_missing: int) -> None:
        """Add records of the path; records after a missing one wait for it."""
        self.trail.take_history(history, first_missing, self.drone_ms)

    def _leave_trail(self, trail: Trail, at: Telemetry | Odometry) -> None:
        if self.state.airborne:
            trail.put(at.drone_ms, Point(at.pose.x_m, at.pose.y_m))

    def _take_event(self, event: Event) -> None:
        """Insert an event in the order of sequence numbers, whenever it comes."""
        later = []
        while (
            self.events and (self.events[-1].sequence - event.sequence) % SEQUENCES < SEQUENCES // 2
        ):
            later.append(self.events.pop())
        self.events.extend((event, *reversed(later)))

    @property
    def route_known(self) -> tuple[int, int] | None:
        """Revision and number of points of the route, once it is complete."""
        if self._route_revision is None or not self.route_complete:
            return None
        return self._route_revision, len(self.route)

    def _take_route(self, piece: RoutePiece) -> None:
        """Replace the route once all its pieces have come."""
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
