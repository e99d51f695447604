# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared words between the drone and the ground.

SI units and radians; the map frame unless a name says otherwise (x forward and y left of the
take-off heading, z up, yaw counter-clockwise). `drone_ms` is the drone's clock.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from ground.core import (
    Capability,
    EventCode,
    MissionCmd,
    MissionReason,
    MissionState,
    SelfTest,
    Source,
)
from ground.missing import AskAny, History, MapPacket
from ground.stick import Steer


@dataclass(frozen=True, slots=True)
class Point:
    """A place in the plane."""

    x_m: float
    y_m: float


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the drone is and where it looks."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float


# --- drone to ground -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Telemetry:
    """The drone's own picture, several times a second."""

    drone_ms: int
    pose: Pose
    goal: Point
    state: MissionState
    fault: MissionReason
    confidence_percent: int


@dataclass(frozen=True, slots=True)
class Health:
    """What changes slowly. `supervisor` holds the bits of supervisor.info."""

    drone_ms: int
    battery_v: float
    path_m: float
    plan_us: int
    plan_nodes: int
    known_cells: int
    tick_us: int
    drops: int
    supervisor: int
    self_test: SelfTest

    @property
    def can_fly(self) -> bool:
        """The supervisor lets the motors turn."""
        return bool(self.supervisor & 1 << 3)

    @property
    def tumbled(self) -> bool:
        """It lies on its side or back."""
        return bool(self.supervisor & 1 << 5)

    @property
    def locked(self) -> bool:
        """The supervisor has cut the motors until the drone is restarted."""
        return bool(self.supervisor & 1 << 6)


@dataclass(frozen=True, slots=True)
class Ranges:
    """The five distances as published; None where the sensor saw nothing."""

    drone_ms: int
    front_m: float | None
    back_m: float | None
    left_m: float | None
    right_m: float | None
    up_m: float | None


@dataclass(frozen=True, slots=True)
class Odometry:
    """The firmware's own estimate, which drifts: odometry frame, velocity too."""

    drone_ms: int
    pose: Pose
    roll_rad: float
    pitch_rad: float
    vx_mps: float
    vy_mps: float
    yaw_rate_rps: float


@dataclass(frozen=True, slots=True)
class Positioned:
    """What the pose comes from just now."""

    drone_ms: int
    source: Source


@dataclass(frozen=True, slots=True)
class MapPiece:
    """One tile: a CellState a cell, row-major from its south-west corner, and some of its points.

    A point is (cell, eighths): index into states, place in the cell (x in bits 0-2, y in bits 3-5).
    """

    tile: int
    epoch: int
    states: bytes
    points: tuple[tuple[int, int], ...]
    whole: bool = False


@dataclass(frozen=True, slots=True)
class Hello:
    """What must be known before the map can be read."""

    capabilities: Capability
    epoch: int
    cell_m: float
    side_cells: int
    origin: Point


@dataclass(frozen=True, slots=True)
class Ack:
    """Answer to the command of that sequence."""

    sequence: int
    cmd: int
    reason: MissionReason


@dataclass(frozen=True, slots=True)
class RoutePiece:
    """Some points of the route; `total` 0 means that there is none."""

    revision: int
    first: int
    total: int
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Event:
    """Something happened on board; the meaning of argument and place depends on the code."""

    sequence: int
    drone_ms: int
    code: EventCode
    argument: int
    place: Point

    @property
    def reason(self) -> MissionReason:
        """Argument of REFUSED, FAULT and SKIPPED."""
        return MissionReason(self.argument)


@dataclass(frozen=True, slots=True)
class Beat:
    """The drone's answer to a heartbeat."""

    sequence: int
    drone_ms: int
    state: MissionState
    path_revision: int = 0
    path_total: int = 0
    next_event: int = 0
    next_record: int = 0


@dataclass(frozen=True, slots=True)
class Console:
    """Text that the firmware printed."""

    text: str


@dataclass(frozen=True, slots=True)
class ParameterValue:
    """A parameter as it stands on the drone now."""

    name: str
    value: float


class LinkState(Enum):
    """How the link is doing."""

    CLOSED = "closed"
    CONNECTED = "connected"
    SILENT = "silent"
    LOST = "lost"
    RECONNECTING = "reconnecting"
    RESTARTED = "restarted"  # the drone: what was known of its flight and map is void


@dataclass(frozen=True, slots=True)
class LinkChange:
    """The link changed its state; `detail` is a sentence."""

    state: LinkState
    detail: str


# --- ground to drone -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Command:
    """A goal for the mission; a repeated sequence acts once."""

    sequence: int
    cmd: MissionCmd
    goal: Point = Point(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Some of a list of `total` points to be flown along, from number `first` on."""

    sequence: int
    list: int
    first: int
    total: int
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class HelloRequest:
    """Ask who is there."""


@dataclass(frozen=True, slots=True)
class SnapshotRequest:
    """Ask for hello, route and the whole map again."""


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The ground is alive, and has heard what the drone said until then; 0: nothing yet."""

    sequence: int
    drone_ms: int = 0


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """Cut the motors through the supervisor, whatever the app does; the drone falls."""


@dataclass(frozen=True, slots=True)
class SetParameter:
    """Write a parameter, by its full name."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class LinkStats:
    """Counted since the link was opened; what is lost by gaps in the times of log packets."""

    log_packets: int = 0
    lost_packets: int = 0
    bad_packets: int = 0
    dropped_messages: int = 0


LogMessage = Telemetry | Health | Ranges | Odometry | Positioned | MapPacket
AppMessage = Hello | Ack | RoutePiece | Event | Beat | History
Incoming = LogMessage | AppMessage | Console | ParameterValue | LinkChange
AppRequest = (
    Command | Waypoints | Steer | HelloRequest | SnapshotRequest | Heartbeat | MapPiece | AskAny
)
Outgoing = AppRequest | EmergencyStop | SetParameter
