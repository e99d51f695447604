# SPDX-License-Identifier: GPL-3.0-or-later
"""How much data local clients have not read yet, so that simulated time can wait for them.

A real radio holds packets back until the other end fetches them; a full UDP socket drops them.
Linux shows in /proc/net/udp how full each socket is. Reading that file takes about 0.1 ms, so it is
read only after as many datagrams were sent as certainly fit into a receive buffer.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

SOCKETS: Final = Path("/proc/net/udp")
PATIENCE_S: Final = 2.0
"""A client that has read nothing for this long is no longer waited for, until it reads again."""
ROOM_BYTES: Final = 128 << 10
"""Used of a client's receive buffer; Linux gives a socket 208 KiB by default."""
DATAGRAM_BYTES: Final = 1 << 10
"""What the kernel charges for a datagram with one packet, rounded up."""
_BURST: Final = ROOM_BYTES // DATAGRAM_BYTES


@dataclass(slots=True)
class _Reader:
    """A client's socket: datagrams that still fit, unread bytes, when it last read enough."""

    moved_s: float
    room: int = _BURST
    unread_bytes: int = 0
    seen: bool = True


class Backlog:
    """Local clients by their UDP port; for one thread, times are of the caller's clock."""

    def __init__(self, sockets: Path = SOCKETS) -> None:
        self._sockets = sockets
        self._readers: dict[int, _Reader] = {}

    @property
    def all_seen(self) -> bool:
        """Whether the system shows the sockets of all clients that were sent a full burst."""
        return all(reader.seen for reader in self._readers.values())

    def sent(self, port: int, now_s: float) -> None:
        """Note that a datagram was sent to this port."""
        reader = self._readers.get(port) or self._readers.setdefault(port, _Reader(now_s))
        reader.room -= 1

    def clogged(self, now_s: float) -> bool:
        """Whether some client must read before more is sent to it."""
        if not self._somebody_full():
            return False
        unread_bytes = _unread_bytes(self._sockets)
        for port, reader in list(self._readers.items()):
            if port in unread_bytes:
                _note(reader, unread_bytes[port], now_s)
            elif reader.room > 0:
                del self._readers[port]
            else:
                reader.room, reader.seen = _BURST, False
        return self._somebody_full()

    def _somebody_full(self) -> bool:
        return any(reader.room <= 0 for reader in self._readers.values())


def _note(reader: _Reader, unread_bytes: int, now_s: float) -> None:
    room = (ROOM_BYTES - unread_bytes) // DATAGRAM_BYTES
    if room > 0 or unread_bytes < reader.unread_bytes:
        reader.moved_s = now_s
    waited_for = now_s - reader.moved_s <= PATIENCE_S
    reader.room = room if waited_for else _BURST
    reader.unread_bytes, reader.seen = unread_bytes, True


def _unread_bytes(sockets: Path) -> dict[int, int]:
    """Bytes in the receive queues by local port; empty where the system does not show them."""
    try:
        lines = sockets.read_text().splitlines()[1:]
    except OSError:
        return {}
    unread: dict[int, int] = {}
    for line in lines:
        _, local, _, _, queues, *_ = line.split()
        port, queued = int(local.split(":")[1], 16), int(queues.split(":")[1], 16)
        unread[port] = max(queued, unread.get(port, 0))
    return unread
