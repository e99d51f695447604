# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages from the drone and from the link.

SI units and radians; the map frame unless a name says otherwise (x forward and y left of the
take-off heading, z up, yaw counter-clockwise). `drone_ms` is the drone's clock.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from ground.core import (
    Capability,
    EventCode,
    MissionReason,
    MissionState,
    RecordKind,
    SelfTest,
    Source,
)


@dataclass(frozen=True, slots=True)
class Point:
    """A position in the plane."""

    x_m: float
    y_m: float


@dataclass(frozen=True, slots=True)
class Pose:
    """Position and heading of the drone."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class Telemetry:
    """The drone's pose and mission state, several times a second."""

    drone_ms: int
    pose: Pose
    goal: Point
    state: MissionState
    fault: MissionReason
    confidence_percent: int


@dataclass(frozen=True, slots=True)
class Health:
    """Values that change slowly; `supervisor` holds the bits of supervisor.info."""

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
        """Whether the supervisor permits the motors to run."""
        return bool(self.supervisor & 1 << 3)

    @property
    def tumbled(self) -> bool:
        """Whether the drone lies on its side or back."""
        return bool(self.supervisor & 1 << 5)

    @property
    def locked(self) -> bool:
        """Whether the supervisor has stopped the motors until the drone is restarted."""
        return bool(self.supervisor & 1 << 6)


@dataclass(frozen=True, slots=True)
class Ranges:
    """The five ranges as published; None without return."""

    drone_ms: int
    front_m: float | None
    back_m: float | None
    left_m: float | None
    right_m: float | None
    up_m: float | None


@dataclass(frozen=True, slots=True)
class Odometry:
    """The firmware's own estimate, which drifts: pose and velocity in the odometry frame."""

    drone_ms: int
    pose: Pose
    roll_rad: float
    pitch_rad: float
    vx_mps: float
    vy_mps: float
    yaw_rate_rps: float


@dataclass(frozen=True, slots=True)
class Positioned:
    """Where the pose comes from at present."""

    drone_ms: int
    source: Source


@dataclass(frozen=True, slots=True)
class MapPacket:
    """A map packet as it was received, with several tiles; GroundMap decodes it."""

    drone_ms: int
    data: bytes


@dataclass(frozen=True, slots=True)
class MapPiece:
    """One tile: a CellState per cell, row-major from its south-west corner, and some of its points.

    A point is (cell, eighths): index into states, place in the cell (x in bits 0-2, y in bits 3-5).
    """

    tile: int
    epoch: int
    states: bytes
    points: tuple[tuple[int, int], ...]
    whole: bool = False


@dataclass(frozen=True, slots=True)
class Hello:
    """What the app is and how its map lies; needed before map packets can be used."""

    capabilities: Capability
    epoch: int
    cell_m: float
    side_cells: int
    origin: Point


@dataclass(frozen=True, slots=True)
class Ack:
    """Answer to the command with this sequence number."""

    sequence: int
    cmd: int
    reason: MissionReason


@dataclass(frozen=True, slots=True)
class RoutePiece:
    """Some points of the route; if `total` is 0, there is no route."""

    revision: int
    first: int
    total: int
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened on board; what argument and place mean depends on the code."""

    sequence: int
    drone_ms: int
    code: EventCode
    argument: int
    place: Point

    @property
    def reason(self) -> MissionReason:
        """The argument of REFUSED, FAULT and SKIPPED."""
        return MissionReason(self.argument)


@dataclass(frozen=True, slots=True)
class Record:
    """A past pose of the drone, or a correction of its estimate: a rotation about the map's origin,
    then a shift."""

    drone_ms: int
    kind: RecordKind
    x_m: float
    y_m: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class History:
    """Records with consecutive numbers, modulo 2^16."""

    first: int
    records: tuple[Record, ...]


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
    """Text printed by the firmware."""

    text: str


@dataclass(frozen=True, slots=True)
class ParameterValue:
    """The present value of a parameter on the drone."""

    name: str
    value: float


class LinkState(Enum):
    """State of the link."""

    CLOSED = "closed"
    CONNECTED = "connected"
    SILENT = "silent"
    LOST = "lost"
    RECONNECTING = "reconnecting"
    RESTARTED = "restarted"  # the drone was restarted: its earlier flight and map are gone


@dataclass(frozen=True, slots=True)
class LinkChange:
    """A new state of the link; `detail` is a sentence."""

    state: LinkState
    detail: str


@dataclass(frozen=True, slots=True)
class LinkStats:
    """Counters since the link was opened; losses are found by gaps in the times of log packets."""

    log_packets: int = 0
    lost_packets: int = 0
    bad_packets: int = 0
    dropped_messages: int = 0


LogMessage = Telemetry | Health | Ranges | Odometry | Positioned | MapPacket
AppMessage = Hello | Ack | RoutePiece | Event | Beat | History
Incoming = LogMessage | AppMessage | Console | ParameterValue | LinkChange
