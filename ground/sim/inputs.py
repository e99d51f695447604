# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording of all that a simulated drone's app is given: enough to compute its flight again.

Topic /calls has one message for each advance of the firmware's clock: the length of the calls (four
bytes), the calls, then their outcomes, as calls.py encodes them. log_time is the firmware's clock.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from ground.record.writer import RecordFile

CALLS: Final = "/calls"
_LENGTH: Final = struct.Struct("<I")
_RUN: Final = b"r"


class InputFile:
    """A file of recorded calls; a Sink for RecordedFirmware."""

    def __init__(self, path: Path, about: Mapping[str, str]) -> None:
        self._file = RecordFile(path, about)
        self._calls = bytearray()
        self._outcomes = bytearray()
        self._now_ms = 0

    def note(self, letter: bytes, arguments: bytes = b"", outcome: bytes = b"") -> None:
        """Add a call; a call that advances the clock writes all that were collected."""
        self._calls += letter + arguments
        self._outcomes += letter + outcome
        if letter == _RUN:
            self._now_ms += _LENGTH.unpack(arguments)[0]
            self._write()

    def close(self) -> None:
        """Write the rest and complete the file."""
        self._write()
        self._file.close()

    def _write(self) -> None:
        data = _LENGTH.pack(len(self._calls)) + self._calls + self._outcomes
        self._file.put(CALLS, data, self._now_ms * 1_000_000)
        self._calls.clear()
        self._outcomes.clear()


def split(data: bytes) -> tuple[bytes, bytes]:
    """Split a message into calls and outcomes. Raises ValueError if it is cut off."""
    if len(data) < _LENGTH.size:
        raise ValueError("a message of calls is cut off")
    end = _LENGTH.size + _LENGTH.unpack_from(data)[0]
    if end > len(data):
        raise ValueError("a message of calls is cut off")
    return data[_LENGTH.size : end], data[end:]
