# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of contents (version 2) of the log and parameter services."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from ground.sim.crtp import BadPacket, encode

CHANNEL = 0
_GET_ITEM = 2
_GET_INFO = 3
_ID = struct.Struct("<BH")


@dataclass(frozen=True, slots=True)
class TocEntry:
    """A variable as clients see it; type_byte holds its flags too."""

    type_byte: int
    group: str
    name: str


class Toc:
    """Answers requests for one table on channel 0 of its port; answers are made in advance."""

    def __init__(self, port: int, entries: Sequence[TocEntry], crc: int, limits: bytes) -> None:
        info = struct.pack("<BHI", _GET_INFO, len(entries), crc) + limits
        self._info = encode(port, CHANNEL, info)
        self._items = [
            encode(port, CHANNEL, _ID.pack(_GET_ITEM, identity) + _item(entry))
            for identity, entry in enumerate(entries)
        ]
        self._no_item = encode(port, CHANNEL, bytes((_GET_ITEM,)))

    def answer(self, data: bytes) -> bytes:
        """Answer a request; raise BadPacket if it is none."""
        if len(data) == 1 and data[0] == _GET_INFO:
            return self._info
        if len(data) == _ID.size and data[0] == _GET_ITEM:
            (_, identity) = _ID.unpack(data)
            return self._items[identity] if identity < len(self._items) else self._no_item
        raise BadPacket("TOC request")


def _item(entry: TocEntry) -> bytes:
    names = f"{entry.group}\0{entry.name}\0"
    return bytes((entry.type_byte,)) + names.encode("ascii")
