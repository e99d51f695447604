# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages to the drone; units and frames as in model.py."""

from __future__ import annotations

from dataclasses import dataclass

from ground.core import MissionCmd, WireType
from ground.model import MapPiece, Point

_NO_GOAL = Point(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Command:
    """A command to the mission; the drone acts once on a repeated sequence number."""

    sequence: int
    cmd: MissionCmd
    goal: Point = _NO_GOAL


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Part of a list of `total` waypoints, from index `first` on."""

    sequence: int
    list: int
    first: int
    total: int
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class HelloRequest:
    """Ask the drone for its hello."""


@dataclass(frozen=True, slots=True)
class SnapshotRequest:
    """Ask for hello, route and the whole map again."""


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The ground is alive and has heard the drone up to drone_ms; 0 before anything was heard."""

    sequence: int
    drone_ms: int = 0


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """Stop the motors by the supervisor, whatever the app does; the drone falls."""


@dataclass(frozen=True, slots=True)
class SetParameter:
    """Write a parameter, given by its full name."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Stick:
    """What the pilot's stick commands: horizontal velocity and yaw rate (body frame), climb rate.

    Together no more than 4 in m/s and rad/s, else the drone refuses it.
    """

    ahead_mps: float = 0.0
    left_mps: float = 0.0
    yaw_rate_rps: float = 0.0
    climb_mps: float = 0.0


REST = Stick()


@dataclass(frozen=True, slots=True)
class Steer:
    """Send a stick to the drone; only a refusal is acknowledged, with the sequence number."""

    sequence: int
    stick: Stick


@dataclass(frozen=True, slots=True)
class Ask:
    """Ask for what was lost: the route, or events or records from number `first` on."""

    what: WireType
    first: int = 0
    count: int = 0


@dataclass(frozen=True, slots=True)
class AskTiles:
    """Ask for tiles of the map."""

    tiles: tuple[int, ...]


AppRequest = (
    Command
    | Waypoints
    | Steer
    | HelloRequest
    | SnapshotRequest
    | Heartbeat
    | MapPiece
    | Ask
    | AskTiles
)
Outgoing = AppRequest | EmergencyStop | SetParameter
