# SPDX-License-Identifier: GPL-3.0-or-later
"""What clients on this host have not read yet, so that simulated time can wait for them.

A radio holds back what the other end does not fetch; a UDP socket throws it away when it is full.
Linux shows how full each socket is. Reading that takes a tenth of a millisecond, so it happens only
when as many datagrams have gone out as fit for certain.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

SOCKETS: Final = Path("/proc/net/udp")
PATIENCE_S: Final = 2.0
"""Who has read nothing for so long is not waited for until he reads again."""
ROOM_BYTES: Final = 128 << 10
"""Of a receive buffer of 208 KiB, which a socket has that asks for nothing else."""
DATAGRAM_BYTES: Final = 1 << 10
"""What the kernel counts for a datagram of one packet, rounded up."""
_BURST: Final = ROOM_BYTES // DATAGRAM_BYTES


@dataclass(slots=True)
class _Reader:
    """One client's socket: datagrams that fit, bytes not read, when it last read enough."""

    moved_s: float
    room: int = _BURST
    unread_bytes: int = 0
    seen: bool = True


class Backlog:
    """Clients by their UDP port; used by one thread, times are its clock's."""

    def __init__(self, sockets: Path = SOCKETS) -> None:
        self._sockets = sockets
        self._readers: dict[int, _Reader] = {}

    @property
    def all_seen(self) -> bool:
        """The system shows the sockets of all who have been sent so much that it matters."""
        return all(reader.seen for reader in self._readers.values())

    def sent(self, port: int, now_s: float) -> None:
        """A datagram has gone to this port."""
        reader = self._readers.get(port) or self._readers.setdefault(port, _Reader(now_s))
        reader.room -= 1

    def clogged(self, now_s: float) -> bool:
        """Somebody should read first."""
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
    """Receive queues by local port; empty where the system does not tell."""
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
