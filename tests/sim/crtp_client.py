# SPDX-License-Identifier: GPL-3.0-or-later
"""Clients for tests: a raw one that speaks bytes, and helpers around the real cflib."""

import socket
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger

PATIENCE_S = 20.0
PATIENT = ("--silence", "60")
"""For simulators whose clients may be slow: the firmware forgets them after a second."""
PARAM_MISC = (2, 3)


def packet(port: int, channel: int, data: bytes = b"") -> bytes:
    """A datagram: header byte and data."""
    return bytes((port << 4 | 0x0C | channel,)) + data


class RawClient:
    """A UDP socket that knows only the header byte."""

    def __init__(self, uri: str) -> None:
        parts = urlsplit(uri)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((parts.hostname, parts.port))
        self._socket.settimeout(PATIENCE_S)

    def __enter__(self) -> "RawClient":
        return self

    def __exit__(self, *error: object) -> None:
        self._socket.close()

    def send_raw(self, datagram: bytes) -> None:
        self._socket.send(datagram)

    def receive_raw(self) -> bytes:
        return self._socket.recv(100)

    def send(self, port: int, channel: int, data: bytes = b"") -> None:
        self.send_raw(packet(port, channel, data))

    def receive(self, port: int, channel: int) -> bytes:
        """Data of the next packet of this port and channel; others are skipped."""
        while True:
            datagram = self.receive_raw()
            if datagram[0] >> 4 == port and datagram[0] & 3 == channel:
                return datagram[1:]

    def ask(self, port: int, channel: int, data: bytes = b"") -> bytes:
        """Send and return the answer; reports of changed parameters in between are skipped."""
        self.send(port, channel, data)
        while True:
            answer = self.receive(port, channel)
            if (port, channel) != PARAM_MISC or answer[:1] == data[:1]:
                return answer

    def toc(self, port: int) -> dict[str, tuple[int, int]]:
        """Read a table: name to (id, type byte)."""
        (count,) = struct.unpack_from("<H", self.ask(port, 0, b"\3"), 1)
        table = {}
        for identity in range(count):
            item = self.ask(port, 0, struct.pack("<BH", 2, identity))
            group, name = item[4:-1].split(b"\0")
            table[f"{group.decode()}.{name.decode()}"] = (identity, item[3])
        return table

    def fetch_params(self) -> None:
        """Read every parameter once, which ends the handshake."""
        (count,) = struct.unpack_from("<H", self.ask(2, 0, b"\3"), 1)
        for identity in range(count):
            self.ask(2, 1, struct.pack("<H", identity))


@contextmanager
def connect(uri: str, cache: Path) -> Iterator[Crazyflie]:
    """A real cflib client with tables and all parameters read."""
    cflib.crtp.init_drivers()
    with SyncCrazyflie(uri, cf=Crazyflie(rw_cache=str(cache))) as connected:
        connected.wait_for_params()
        yield connected.cf


def samples(
    cf: Crazyflie, period_ms: int, names: list[str], fetch_as: str | None = None
) -> Iterator[tuple[int, dict[str, float]]]:
    """An endless series of log samples: time [ms] and values."""
    block = LogConfig("test", period_ms)
    for name in names:
        block.add_variable(name, fetch_as)
    with SyncLogger(cf, block) as logger:
        for time_ms, values, _ in logger:
            yield time_ms, values


def wait_until(condition: Callable[[], bool], what: str) -> None:
    """Poll; the limit only keeps a broken test from hanging."""
    end_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end_s, f"waited in vain until {what}"
        time.sleep(0.02)
