# SPDX-License-Identifier: GPL-3.0-or-later
"""The UDP sockets in front of the simulated radios."""

import select
import socket
import time
from collections.abc import Sequence
from types import TracebackType

from ground.errors import SimulatorFailed
from ground.sim.backlog import Backlog
from ground.sim.radio import Radio

HOST = "127.0.0.1"
_RECEIVE_BUFFER_BYTES = 1 << 20
_MAX_DATAGRAM_BYTES = 2048
_LOOK_EVERY_S = 0.002


def serve_until(servers: Sequence["Server"], due_s: float) -> None:
    """Answer packets until due_s, and at least those that wait already."""
    while True:
        for server in servers:
            server.answer()
        rest_s = due_s - time.monotonic()
        if rest_s <= 0:
            return
        select.select(servers, (), (), rest_s)


def serve_until_read(servers: Sequence["Server"]) -> None:
    """Keep answering while a client lags behind; return at once if none does."""
    while any(server.clogged or server.outrun for server in servers):
        serve_until(servers, time.monotonic() + _LOOK_EVERY_S)


class Server:
    """One drone's socket; for one thread, on the clock of time.monotonic()."""

    def __init__(self, radio: Radio, port: int) -> None:
        self._radio = radio
        self._backlog = Backlog()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)
        self._socket.setblocking(False)
        try:
            self._socket.bind((HOST, port))
        except OSError as error:
            self._socket.close()
            raise SimulatorFailed(
                f"cannot listen at udp://{HOST}:{port}: {error.strerror}",
                "end the other simulator, or name another --port",
            ) from error

    def __enter__(self) -> "Server":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._socket.close()

    @property
    def port(self) -> int:
        """The port that clients use."""
        port: int = self._socket.getsockname()[1]
        return port

    @property
    def sees_clients(self) -> bool:
        """Whether the system shows how much its clients have not read yet."""
        return self._backlog.all_seen

    @property
    def clogged(self) -> bool:
        """Whether a client has too much left to read."""
        return self._backlog.clogged(time.monotonic())

    @property
    def outrun(self) -> bool:
        """Whether a ground station lags behind the drone's time."""
        return self._radio.outruns(time.monotonic())

    def fileno(self) -> int:
        """The socket's file descriptor, for select."""
        return self._socket.fileno()

    def answer(self) -> None:
        """Take the datagrams that have arrived and send those that wait."""
        self._receive_waiting()
        self.flush()

    def flush(self) -> int:
        """Send the datagrams that wait and return their number."""
        count = 0
        for address, datagram in self._radio.outgoing():
            count += 1
            try:
                self._socket.sendto(datagram, address)
                self._backlog.sent(address[1], time.monotonic())
            except OSError:
                # The client is gone or the kernel's buffer is full: lost, as over the air.
                self._radio.counters.unsent += 1
        return count

    def _receive_waiting(self) -> None:
        while True:
            try:
                datagram, address = self._socket.recvfrom(_MAX_DATAGRAM_BYTES)
            except BlockingIOError:
                return
            except ConnectionError:
                continue
            self._radio.receive(address, datagram, time.monotonic())
