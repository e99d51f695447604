# SPDX-License-Identifier: GPL-3.0-or-later
"""Replay recorded calls on the C code as it is compiled now."""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache

from ground.sim.calls import OFFERED, RecordedFirmware, Sink
from ground.sim.firmware import BlockReader
from ground.sim.model import Setpoint


class _Calls:
    """A reader for the bytes of recorded calls."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    @property
    def any(self) -> bool:
        return self._at < len(self._data)

    def take(self, size: int) -> bytes:
        end = self._at + size
        if end > len(self._data):
            raise ValueError("a call is cut off")
        taken, self._at = self._data[self._at : end], end
        return taken

    def number(self, size: int) -> int:
        return int.from_bytes(self.take(size), "little")

    def sized(self) -> bytes:
        return self.take(self.number(1))


class Caller:
    """One drone on which recorded calls are made again; `sink` gets each call and its outcome."""

    def __init__(self, sink: Sink) -> None:
        self._firmware = RecordedFirmware(sink)
        self._reader = cache(self._new_reader)
        self._table = self._handlers()

    @property
    def firmware(self) -> RecordedFirmware:
        """The app on which the calls are made."""
        return self._firmware

    def make(self, data: bytes) -> None:
        """Make the calls of one message. Raises ValueError if the bytes are not calls."""
        calls = _Calls(data)
        while calls.any:
            letter = calls.take(1)
            if letter not in self._table:
                raise ValueError(f"no call is named {letter!r}")
            self._table[letter](calls)

    def _handlers(self) -> dict[bytes, Callable[[_Calls], object]]:
        to = self._firmware
        return {
            b"b": lambda c: to.boot(),
            b"r": lambda c: to.run(c.number(4)),
            b"z": lambda c: to.stall(c.number(4)),
            b"s": lambda c: to.set_raw_sensors(c.take(to.sensor_bytes)),
            b"c": lambda c: to.set_connected(bool(c.number(1))),
            b"f": lambda c: to.set_tx_free(c.number(1)),
            b"w": lambda c: to.param_write(c.number(2), c.sized()),
            b"e": lambda c: to.param_force(c.number(2), c.sized()),
            b"a": lambda c: to.appchannel_push(c.sized()),
            b"p": self._put_setpoint,
            b"x": lambda c: to.relax_priority(),
            b"V": lambda c: to.alive(),
            b"S": lambda c: to.get_setpoint(),
            b"I": lambda c: to.active_priority(),
            b"R": lambda c: to.take_arming_request(),
            b"M": lambda c: to.take_measurement(),
            b"L": self._read_block,
            b"P": lambda c: to.param_read(c.number(2)),
            b"U": lambda c: to.take_param_update(),
            b"A": lambda c: to.appchannel_take(),
            b"C": lambda c: to.console_take(),
            b"T": lambda c: to.log_crc(),
        }

    def _put_setpoint(self, calls: _Calls) -> None:
        values = OFFERED.unpack(calls.take(OFFERED.size))
        self._firmware.put_setpoint(Setpoint(*values), calls.number(1))

    def _read_block(self, calls: _Calls) -> None:
        time_ms, count = calls.number(4), calls.number(1)
        ids = struct.unpack(f"<{count}H", calls.take(2 * count))
        self._reader(ids, calls.take(count)).read(time_ms)

    def _new_reader(self, ids: tuple[int, ...], types: bytes) -> BlockReader:
        return self._firmware.block_reader(ids, list(types))
