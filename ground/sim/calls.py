# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls between the simulator and the app, recorded as bytes.

A recorded call is a letter and its arguments; its outcome is the same letter and what was returned.
tests/firmware/calls.c reads the same format.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Protocol

from ground.sim.firmware import BlockReader, Firmware
from ground.sim.model import Measured, PositionMeasured, Readings, Setpoint, YawMeasured

SETPOINT = struct.Struct("<6B?11fIB")
MEASURED = struct.Struct("<2?5f")
OFFERED = struct.Struct("<6B?11f")


def _sized(data: bytes) -> bytes:
    return bytes((len(data),)) + data


def _values(setpoint: Setpoint) -> list[float]:
    return [getattr(setpoint, name) for name in Setpoint.__dataclass_fields__]


def _measured(measured: Measured) -> bytes:
    match measured:
        case PositionMeasured(x_m, y_m, z_m, sd_m):
            return MEASURED.pack(True, False, x_m, y_m, z_m, 0.0, sd_m)
        case YawMeasured(error_rad, sd_rad):
            return MEASURED.pack(True, True, 0.0, 0.0, 0.0, error_rad, sd_rad)


class Sink(Protocol):
    """Receives each call as it is made."""

    def note(self, letter: bytes, arguments: bytes = b"", outcome: bytes = b"") -> None:
        """Take one call and its outcome, both without the letter."""


class Recording:
    """The calls of a flight and their outcomes, in memory."""

    def __init__(self) -> None:
        self.calls = bytearray()
        self.outcomes: list[bytes] = []

    def note(self, letter: bytes, arguments: bytes = b"", outcome: bytes = b"") -> None:
        """Add a call."""
        self.calls += letter + arguments
        self.outcomes.append(letter + outcome)

    @property
    def outcome(self) -> bytes:
        """All outcomes in order: what tests/firmware/calls.c must write too."""
        return b"".join(self.outcomes)

    def first_difference(self, there: bytes) -> str | None:
        """Describe the first outcome that differs from `there`; None if all are equal."""
        at = 0
        for number, outcome in enumerate(self.outcomes):
            found = there[at : at + len(outcome)]
            if found != outcome:
                said = f"{outcome.hex()} here, {found.hex()} there"
                return f"call {number} ({chr(outcome[0])}): {said}"
            at += len(outcome)
        return None if at == len(there) else f"{len(there) - at} bytes more there"


class RecordedFirmware(Firmware):
    """A Firmware that records every call that changes the app's state or shows it."""

    def __init__(self, sink: Sink | None = None) -> None:
        super().__init__()
        self.recording = Recording()
        self.note = (sink or self.recording).note

    def boot(self) -> None:
        super().boot()
        self.note(b"b")

    def run(self, ms: int) -> None:
        super().run(ms)
        self.note(b"r", struct.pack("<I", ms))

    def stall(self, ms: int) -> None:
        super().stall(ms)
        self.note(b"z", struct.pack("<I", ms))

    def alive(self) -> bool:
        alive = super().alive()
        self.note(b"V", b"", bytes((alive,)))
        return alive

    def set_sensors(self, readings: Readings) -> None:
        super().set_sensors(readings)
        self.note(b"s", bytes(self._ffi.buffer(self._sensors)))

    def set_connected(self, connected: bool) -> None:
        super().set_connected(connected)
        self.note(b"c", bytes((connected,)))

    def set_tx_free(self, packets: int) -> None:
        super().set_tx_free(packets)
        self.note(b"f", bytes((packets,)))

    def get_setpoint(self) -> Setpoint:
        setpoint = super().get_setpoint()
        self.note(b"S", b"", SETPOINT.pack(*_values(setpoint)))
        return setpoint

    def put_setpoint(self, setpoint: Setpoint, priority: int) -> bool:
        taken = super().put_setpoint(setpoint, priority)
        offered = OFFERED.pack(*_values(setpoint)[:-2])
        self.note(b"p", offered + bytes((priority,)), bytes((taken,)))
        return taken

    def relax_priority(self) -> None:
        super().relax_priority()
        self.note(b"x")

    def active_priority(self) -> int:
        priority = super().active_priority()
        self.note(b"I", b"", bytes((priority,)))
        return priority

    def take_arming_request(self) -> int:
        request = super().take_arming_request()
        self.note(b"R", b"", bytes((request,)))
        return request

    def take_measurements(self) -> Iterator[Measured]:
        while (measured := self.take_measurement()) is not None:
            yield measured

    def take_measurement(self) -> Measured | None:
        """Take the oldest measurement that waits."""
        measured = next(super().take_measurements(), None)
        none = MEASURED.pack(False, False, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.note(b"M", b"", none if measured is None else _measured(measured))
        return measured

    def log_crc(self) -> int:
        """Return the log table's CRC; the recorded outcome holds the parameter table's CRC too."""
        crc = super().log_crc()
        self.note(b"T", b"", struct.pack("<2I", crc, self.param_crc()))
        return crc

    def log_read(self, identity: int, fetch_type: int, time_ms: int) -> bytes:
        return self.block_reader([identity], [fetch_type]).read(time_ms)

    def block_reader(self, ids: Sequence[int], types: Sequence[int]) -> BlockReader:
        return _RecordedReader(self, ids, types)

    def param_read(self, identity: int) -> bytes:
        value = super().param_read(identity)
        self.note(b"P", struct.pack("<H", identity), _sized(value))
        return value

    def param_write(self, identity: int, value: bytes) -> int:
        error = super().param_write(identity, value)
        self.note(b"w", struct.pack("<H", identity) + _sized(value), bytes((error,)))
        return error

    def param_force(self, identity: int, value: bytes) -> int:
        error = super().param_force(identity, value)
        self.note(b"e", struct.pack("<H", identity) + _sized(value), bytes((error,)))
        return error

    def take_param_update(self) -> int:
        identity = super().take_param_update()
        self.note(b"U", b"", struct.pack("<i", identity))
        return identity

    def appchannel_push(self, data: bytes) -> bool:
        pushed = super().appchannel_push(data)
        self.note(b"a", _sized(data), bytes((pushed,)))
        return pushed

    def appchannel_take(self) -> bytes:
        packet = super().appchannel_take()
        self.note(b"A", b"", _sized(packet))
        return packet

    def console_take(self) -> bytes:
        text = super().console_take()
        self.note(b"C", b"", _sized(text))
        return text

    def set_raw_sensors(self, data: bytes) -> None:
        """Set the sensors from the bytes that set_sensors() has recorded."""
        self._ffi.memmove(self._sensors, data, len(data))
        self._lib.sim_port_set_sensors(self._sensors)
        self.note(b"s", data)

    @property
    def sensor_bytes(self) -> int:
        """Number of bytes that set_raw_sensors() takes."""
        return int(self._ffi.sizeof(self._sensors[0]))


class _RecordedReader(BlockReader):
    """A recorded BlockReader: sampling the map's log variables advances them to the next piece."""

    def __init__(self, of: RecordedFirmware, ids: Sequence[int], types: Sequence[int]) -> None:
        super().__init__(of._ffi, of._lib, ids, types)
        self._note = of.note
        self._variables = bytes((len(ids),)) + struct.pack(f"<{len(ids)}H", *ids) + bytes(types)

    def read(self, time_ms: int) -> bytes:
        values = super().read(time_ms)
        self._note(b"L", struct.pack("<I", time_ms) + self._variables, _sized(values))
        return values
