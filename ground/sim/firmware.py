# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware app, compiled for this machine and loaded: one Firmware is one Crazyflie.

Each instance loads its own copy of the compiled library, so several drones can fly in one process.
Not thread-safe: all calls of an instance come from one thread.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, TypeAlias

from ground.errors import CoreMissing
from ground.sim.model import Measured, PositionMeasured, Readings, Setpoint, YawMeasured

_C: TypeAlias = Any  # a C object; cffi has no types for it
_MODULE = "ground.sim._firmware"
_LIBRARY = Path(__file__).parent / f"_firmware{EXTENSION_SUFFIXES[0]}"
_READINGS = tuple(Readings.__dataclass_fields__)
_SETPOINT = tuple(Setpoint.__dataclass_fields__)
_VALUE_BYTES = 8
_BLOCK_BYTES = 512


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of a table of contents; type is the raw byte with its flags."""

    type: int
    group: str
    name: str
    extended: bool
    persistent: bool


class BlockReader:
    """Samples a fixed set of log variables with one call."""

    def __init__(self, ffi: _C, lib: _C, ids: Sequence[int], types: Sequence[int]) -> None:
        if len(ids) != len(types):
            raise ValueError("there must be as many types as variables")
        self._read = lib.sim_port_log_read_block
        self._ids = ffi.new("uint16_t[]", list(ids))
        self._types = ffi.new("uint8_t[]", list(types))
        self._count = len(ids)
        self._bytes = ffi.new("uint8_t[]", _VALUE_BYTES * max(len(ids), 1))
        self._view = ffi.buffer(self._bytes)

    def read(self, time_ms: int) -> bytes:
        """The values in order, little-endian; empty if a variable or type is unknown."""
        size = self._read(self._ids, self._types, self._count, time_ms, self._bytes)
        return bytes(self._view[:size])


class Firmware:
    """The app and the host version of the firmware around it; its clock advances only in run()."""

    def __init__(self) -> None:
        module = _load()
        self._ffi: _C = module.ffi
        self._lib: _C = module.lib
        self._sensors = self._ffi.new("sim_port_sensors_t *")
        self._setpoint = self._ffi.new("sim_port_setpoint_t *")
        self._measurement = self._ffi.new("sim_port_measurement_t *")
        self._bytes = self._ffi.new("uint8_t[]", _BLOCK_BYTES)
        self._text = self._ffi.new("char[]", self._lib.SIM_PORT_CONSOLE_BYTES)

    def boot(self) -> None:
        """Start the app and run it up to its first delay."""
        self._lib.sim_port_boot()

    def run(self, ms: int) -> None:
        """Advance the firmware's clock and run the tasks that become due."""
        self._lib.sim_port_run(ms)

    def stall(self, ms: int) -> None:
        """Delay the app as if other tasks used the CPU for this long."""
        self._lib.sim_port_stall(ms)

    def now_ms(self) -> int:
        """Milliseconds since the firmware started."""
        return int(self._lib.sim_port_now_ms())

    def alive(self) -> bool:
        """Whether the app was booted and no assertion has failed."""
        return bool(self._lib.sim_port_alive())

    def set_sensors(self, readings: Readings) -> None:
        """Set what sensors and estimator report from now on."""
        for name in _READINGS:
            setattr(self._sensors, name, getattr(readings, name))
        self._lib.sim_port_set_sensors(self._sensors)

    def set_connected(self, connected: bool) -> None:
        """Set whether a client was heard recently."""
        self._lib.sim_port_set_connected(connected)

    def set_tx_free(self, packets: int) -> None:
        """Set the room in the transmit queue, in packets."""
        self._lib.sim_port_set_tx_free(packets)

    def get_setpoint(self) -> Setpoint:
        """The setpoint that the stabilizer would use now."""
        self._lib.sim_port_get_setpoint(self._setpoint)
        return Setpoint(*(getattr(self._setpoint, name) for name in _SETPOINT))

    def put_setpoint(self, setpoint: Setpoint, priority: int) -> bool:
        """Offer a setpoint; false if a setpoint of higher priority is active."""
        for name in _SETPOINT:
            setattr(self._setpoint, name, getattr(setpoint, name))
        return bool(self._lib.sim_port_put_setpoint(self._setpoint, priority))

    def relax_priority(self) -> None:
        """Accept setpoints of any priority again."""
        self._lib.sim_port_relax_priority()

    def active_priority(self) -> int:
        """The priority of the active setpoint; lower ones are refused."""
        return int(self._lib.sim_port_active_priority())

    def take_arming_request(self) -> int:
        """The app's latest request since the last call: 0 none, 1 disarm, 2 arm."""
        return int(self._lib.sim_port_take_arming_request())

    def take_measurements(self) -> Iterator[Measured]:
        """Measurements that the app has sent to the estimator since the last call."""
        found = self._measurement
        while self._lib.sim_port_take_measurement(found):
            if found.of_yaw:
                yield YawMeasured(found.yaw_error_rad, found.sd)
            else:
                yield PositionMeasured(found.x_m, found.y_m, found.z_m, found.sd)

    def log_count(self) -> int:
        """Number of log variables."""
        return int(self._lib.sim_port_log_count())

    def log_entries(self) -> list[Entry]:
        """All log variables; a variable's id is its index."""
        return self._entries(self._lib.sim_port_log_entry, self.log_count())

    def log_crc(self) -> int:
        """Checksum of the log table."""
        return int(self._lib.sim_port_log_crc())

    def log_read(self, identity: int, fetch_type: int, time_ms: int) -> bytes:
        """One sample, fetched as a log type (8 is FP16), little-endian; empty if one is unknown."""
        size = self._lib.sim_port_log_read(identity, fetch_type, time_ms, self._bytes)
        return self._taken(size)

    def block_reader(self, ids: Sequence[int], types: Sequence[int]) -> BlockReader:
        """A reader for these variables, each fetched as the given log type."""
        return BlockReader(self._ffi, self._lib, ids, types)

    def param_entries(self) -> list[Entry]:
        """All parameters; a parameter's id is its index."""
        return self._entries(self._lib.sim_port_param_entry, self._lib.sim_port_param_count())

    def param_crc(self) -> int:
        """Checksum of the parameter table."""
        return int(self._lib.sim_port_param_crc())

    def param_read(self, identity: int) -> bytes:
        """The stored value, little-endian; empty if the id is unknown."""
        return self._taken(self._lib.sim_port_param_read(identity, self._bytes))

    def param_default(self, identity: int) -> bytes:
        """The value that the parameter had when the firmware started."""
        return self._taken(self._lib.sim_port_param_default(identity, self._bytes))

    def param_write(self, identity: int, value: bytes) -> int:
        """Write as a client does: 0 or an errno (2 unknown, 13 read-only, 22 wrong size)."""
        return int(self._lib.sim_port_param_write(identity, value, len(value)))

    def param_force(self, identity: int, value: bytes) -> int:
        """Write as the firmware itself does: without callback, even if read-only."""
        return int(self._lib.sim_port_param_force(identity, value, len(value)))

    def take_param_update(self) -> int:
        """The id of the next parameter that the app has changed, or -1."""
        return int(self._lib.sim_port_take_param_update())

    def appchannel_push(self, data: bytes) -> bool:
        """Send a packet to the app; false if its queue is full."""
        return bool(self._lib.sim_port_appchannel_push(data, len(data)))

    def appchannel_take(self) -> bytes:
        """Take the oldest packet that the app has sent; empty if there is none."""
        return self._taken(self._lib.sim_port_appchannel_take(self._bytes))

    def console_take(self) -> bytes:
        """Take the next packet of console text; empty if there is none."""
        size = self._lib.sim_port_console_take(self._text)
        return bytes(self._ffi.buffer(self._text, size))

    def _taken(self, size: int) -> bytes:
        return bytes(self._ffi.buffer(self._bytes, size))

    def _entries(self, read: Callable[[int, _C], bool], count: int) -> list[Entry]:
        raw = self._ffi.new("sim_port_entry_t *")
        entries = []
        for identity in range(count):
            read(identity, raw)
            group, name = (self._ffi.string(text).decode("ascii") for text in (raw.group, raw.name))
            entries.append(Entry(raw.type, group, name, raw.extended, raw.persistent))
        return entries


def _load() -> ModuleType:
    """Load a fresh copy of the library, so that no two instances share its global variables."""
    if not _LIBRARY.exists():
        raise CoreMissing("the firmware app is not compiled", "`make setup`")
    with tempfile.TemporaryDirectory(prefix="wayflie-fw-") as folder:
        copy = Path(shutil.copy(_LIBRARY, folder))
        loader = ExtensionFileLoader(_MODULE, str(copy))
        spec = spec_from_file_location(_MODULE, copy, loader=loader)
        assert spec is not None
        return module_from_spec(spec)
