# SPDX-License-Identifier: GPL-3.0-or-later
"""A simulated serial port: CPX frames on a pty, with the simulator's UDP at the other end.

Frames are those of a Crazyflie's UART: FF, length, CPX, checksum by exclusive or; FF 00 is "go on",
which each side waits for before it sends the next frame.
"""

import contextlib
import os
import select
import socket
import threading
import time
import tty
from collections import deque
from functools import reduce
from operator import xor
from urllib.parse import urlsplit

GO_ON = b"\xff\x00"
SYNC_EVERY_S = 0.05
TO_HOST_CRTP = bytes((1 << 3 | 3, 3))  # from the STM32 to the host; function CRTP
CRTP = 3


class UartBridge:
    """Context: serves the device `path` for a simulator at `uri`."""

    def __init__(self, uri: str) -> None:
        parts = urlsplit(uri)
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._udp.connect((parts.hostname, parts.port))
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self._frames: deque[bytes] = deque()
        self._may_send = self._synced = self._ended = False
        self._synced_s = 0.0
        self._bytes = b""
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "UartBridge":
        self._thread.start()
        return self

    def cut(self) -> None:
        """From now on, neither send nor receive."""
        self._ended = True

    def __exit__(self, *error: object) -> None:
        self._ended = True
        self._thread.join()
        self._udp.close()
        os.close(self._master)
        os.close(self._slave)

    def _run(self) -> None:
        while not self._ended:
            if not self._synced and time.monotonic() - self._synced_s > SYNC_EVERY_S:
                self._synced_s = time.monotonic()
                os.write(self._master, GO_ON)
            ready, _, _ = select.select((self._master, self._udp), (), (), 0.02)
            if self._master in ready:
                self._bytes += os.read(self._master, 4096)
                self._read_frames()
            if self._udp in ready:
                with contextlib.suppress(ConnectionError):
                    self._frames.append(TO_HOST_CRTP + self._udp.recv(100))
            self._write_frame()

    def _read_frames(self) -> None:
        while len(self._bytes) >= 2:
            length = self._bytes[1]
            if self._bytes[:2] == GO_ON:
                self._synced = self._may_send = True
                self._bytes = self._bytes[2:]
                continue
            if len(self._bytes) < length + 3:
                return
            frame, self._bytes = self._bytes[: length + 3], self._bytes[length + 3 :]
            assert frame[0] == 0xFF and reduce(xor, frame) == 0
            os.write(self._master, GO_ON)
            if frame[3] & 0x3F == CRTP:
                with contextlib.suppress(ConnectionError):
                    self._udp.send(frame[4:-1])

    def _write_frame(self) -> None:
        if self._may_send and self._frames:
            frame = bytes((0xFF, len(self._frames[0]))) + self._frames.popleft()
            os.write(self._master, frame + bytes((reduce(xor, frame),)))
            self._may_send = False
