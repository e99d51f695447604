# SPDX-License-Identifier: GPL-3.0-or-later
"""Words for what the drone tells piece by piece, and for asking for what was lost of it."""

from __future__ import annotations

from dataclasses import dataclass

from ground.core import RecordKind, WireType


@dataclass(frozen=True, slots=True)
class Record:
    """Where the drone was; or how what it believed was corrected: a turn about the map's origin,
    then a shift."""

    drone_ms: int
    kind: RecordKind
    x_m: float
    y_m: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class History:
    """Records with numbers that follow one another, modulo 2^16."""

    first: int
    records: tuple[Record, ...]


@dataclass(frozen=True, slots=True)
class Ask:
    """Ask for what was lost: route, or events or records from a number on."""

    what: WireType
    first: int = 0
    count: int = 0


@dataclass(frozen=True, slots=True)
class AskTiles:
    """Ask for tiles of the map."""

    tiles: tuple[int, ...]


AskAny = Ask | AskTiles


@dataclass(frozen=True, slots=True)
class MapPacket:
    """A piece of the map as it came, of several tiles; GroundMap reads it."""

    drone_ms: int
    data: bytes
