# SPDX-License-Identifier: GPL-3.0-or-later
"""CRTP over UDP: a datagram is one packet, a header byte followed by 0 to 30 bytes of data."""

import struct
from enum import IntEnum
from typing import Any, Final, NamedTuple

MAX_DATA_BYTES = 30
LARGEST = 1e6
PROTOCOL_VERSION = 12
_RESERVED_BITS = 0x0C


class Port(IntEnum):
    """CRTP ports of the Crazyflie firmware."""

    CONSOLE = 0
    PARAM = 2
    SETPOINT = 3
    MEMORY = 4
    LOG = 5
    LOCALIZATION = 6
    SETPOINT_GENERIC = 7
    SETPOINT_HIGH_LEVEL = 8
    SUPERVISOR = 9
    PLATFORM = 13
    LINK = 15


APP: Final = (Port.PLATFORM, 2)
"""Port and channel of packets between the app and the ground."""


class Errno(IntEnum):
    """Error numbers that the firmware puts into its answers."""

    OK = 0
    ENOENT = 2
    EIO = 5
    E2BIG = 7
    ENOEXEC = 8
    ENOMEM = 12
    EACCES = 13
    EBUSY = 16
    EEXIST = 17
    EINVAL = 22


class BadPacket(Exception):
    """A packet that no service understands; it is dropped and counted."""


class Packet(NamedTuple):
    """A received packet, without the reserved bits of its header."""

    port: int
    channel: int
    data: bytes


def decode(datagram: bytes) -> Packet:
    """Split a datagram; raise BadPacket if it cannot be a packet."""
    if not 1 <= len(datagram) <= 1 + MAX_DATA_BYTES:
        raise BadPacket("length of a datagram")
    return Packet(datagram[0] >> 4, datagram[0] & 3, datagram[1:])


def encode(port: int, channel: int, data: bytes = b"") -> bytes:
    """Make the datagram of a packet to send."""
    return bytes((port << 4 | _RESERVED_BITS | channel,)) + data


def unpack(layout: struct.Struct, data: bytes) -> tuple[Any, ...]:
    """Unpack a body of exactly this layout; numbers beyond LARGEST are refused as nonsense."""
    if len(data) != layout.size:
        raise BadPacket("length of a body")
    values = layout.unpack(data)
    if not all(isinstance(value, int) or abs(value) <= LARGEST for value in values):
        raise BadPacket("number out of range")
    return values
