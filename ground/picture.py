# SPDX-License-Identifier: GPL-3.0-or-later
"""The latest of everything: what the ground knows of one drone."""

from __future__ import annotations

from collections import deque

from ground.core import MissionState, Source
from ground.map import GroundMap
from ground.model import (
    Beat,
    Console,
    Event,
    Health,
    Hello,
    Incoming,
    LinkChange,
    LinkState,
    MapPiece,
    Odometry,
    ParameterValue,
    Point,
    Positioned,
    Ranges,
    RoutePiece,
    Telemetry,
)

TRAIL_POINTS = 4000
TRAIL_STEP_M = 0.05
EVENTS_KEPT = 100
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
        self.trail: deque[Point] = deque(maxlen=TRAIL_POINTS)
        self.trail_count = 0
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
                self._extend_trail(message)
            case MapPiece():
                self.map.take_piece(message, now_s)
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
                self.events.append(message)
            case LinkChange():
                self.link = message
            case Console(text):
                self._take_console(text)
            case ParameterValue(name, value):
                self.parameters[name] = value
        if isinstance(message, Telemetry | Health | Ranges | Odometry | Positioned | Beat):
            self.drone_ms = message.drone_ms

    def _extend_trail(self, telemetry: Telemetry) -> None:
        if not telemetry.state.airborne:
            return
        here = Point(telemetry.pose.x_m, telemetry.pose.y_m)
        if self.trail:
            last = self.trail[-1]
            if max(abs(here.x_m - last.x_m), abs(here.y_m - last.y_m)) < TRAIL_STEP_M:
                return
        self.trail.append(here)
        self.trail_count += 1

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
