# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameter service (port 2): reads, writes, defaults, stored values, reports of changes."""

import struct
from collections.abc import Callable, Iterator

from ground.sim.crtp import BadPacket, Errno, Port, encode
from ground.sim.eeprom import Eeprom
from ground.sim.firmware import Entry, Firmware
from ground.sim.toc import Toc, TocEntry

READ, WRITE, MISC = 1, 2, 3
_EXTENDED = 0x10
_READ_ONLY = 0x40
_TYPE_MASK = 0x0F
_TOC_FLAGS = _TYPE_MASK | _EXTENDED | _READ_ONLY
_PERSISTENT = 1
_VALUE_UPDATED = 1

_ID = struct.Struct("<H")
_VALUES = {
    0x0: struct.Struct("<b"),
    0x1: struct.Struct("<h"),
    0x2: struct.Struct("<i"),
    0x6: struct.Struct("<f"),
    0x8: struct.Struct("<B"),
    0x9: struct.Struct("<H"),
    0xA: struct.Struct("<I"),
}


def pack_value(kind: int, value: float) -> bytes:
    """Encode a value for a parameter of this type."""
    layout = _VALUES[kind & _TYPE_MASK]
    return layout.pack(value if layout.format == "<f" else int(value))


class Params:
    """All parameters of one firmware; all clients share them."""

    def __init__(self, firmware: Firmware, eeprom: Eeprom) -> None:
        self._firmware = firmware
        self._eeprom = eeprom
        self._entries = firmware.param_entries()
        self._ids = {_name(entry): identity for identity, entry in enumerate(self._entries)}
        self.toc = Toc(Port.PARAM, [_listed(e) for e in self._entries], firmware.param_crc(), b"")
        self._misc: dict[int, Callable[[int], bytes]] = {
            2: self._extended_type,
            3: self._store,
            4: self._state,
            5: self._clear,
            6: self._default,
            7: self._extended_type_2,
            8: self._default_2,
        }

    def __len__(self) -> int:
        return len(self._entries)

    def restore(self) -> list[str]:
        """Set the EEPROM's values, as the firmware does before apps start; return unknown names."""
        unknown = []
        for name, value in self._eeprom.values().items():
            identity = self._ids.get(name)
            if identity is None or not self._entries[identity].persistent:
                unknown.append(name)
            else:
                self._firmware.param_write(identity, self._packed(identity, value))
        return unknown

    def find(self, name: str) -> int | None:
        """The id of "group.name"."""
        return self._ids.get(name)

    def value(self, identity: int) -> float:
        """The present value of a parameter."""
        layout = _VALUES[self._entries[identity].type & _TYPE_MASK]
        number: float = layout.unpack(self._firmware.param_read(identity))[0]
        return number

    def set_value(self, identity: int, value: float) -> None:
        """Change a parameter from inside the simulated firmware."""
        self._firmware.param_write(identity, self._packed(identity, value))

    def read(self, data: bytes) -> tuple[int, bytes]:
        """Answer a read request; also return the id that was asked for."""
        if len(data) != _ID.size:
            raise BadPacket("parameter read")
        (identity,) = _ID.unpack(data)
        if identity >= len(self._entries):
            return identity, encode(Port.PARAM, READ, data + bytes((Errno.ENOENT,)))
        value = self._firmware.param_read(identity)
        return identity, encode(Port.PARAM, READ, data + bytes((Errno.OK,)) + value)

    def write(self, data: bytes) -> tuple[int | None, bytes | None]:
        """Write a value; return the id if it was written, and the answer if there is one."""
        if len(data) < _ID.size:
            raise BadPacket("parameter write")
        (identity,) = _ID.unpack_from(data)
        match self._firmware.param_write(identity, data[_ID.size :]):
            case Errno.OK:
                return identity, encode(Port.PARAM, WRITE, data)
            case Errno.ENOENT:
                return None, encode(Port.PARAM, WRITE, data[: _ID.size] + bytes((Errno.ENOENT,)))
            case Errno.EACCES:
                return None, None
            case _:
                raise BadPacket("size of a parameter")

    def misc(self, data: bytes) -> tuple[int | None, bytes]:
        """Answer other requests; also return the id of a parameter that was written by name."""
        if data and data[0] == 0:
            return self._set_by_name(data)
        if len(data) != 1 + _ID.size or data[0] not in self._misc:
            raise BadPacket("parameter request")
        (identity,) = _ID.unpack_from(data, 1)
        known = identity < len(self._entries)
        body = self._misc[data[0]](identity) if known else bytes((Errno.ENOENT,))
        return None, encode(Port.PARAM, MISC, data + body)

    def news(self, identity: int) -> bytes:
        """The packet that reports a value to clients that did not set it."""
        body = bytes((_VALUE_UPDATED,)) + _ID.pack(identity)
        return encode(Port.PARAM, MISC, body + self._firmware.param_read(identity))

    def changed_by_firmware(self) -> Iterator[int]:
        """Ids of parameters that the app has set since the last call."""
        while (identity := self._firmware.take_param_update()) >= 0:
            yield identity

    def _set_by_name(self, data: bytes) -> tuple[int | None, bytes]:
        parts = data[1:].split(b"\0", 2)
        if len(parts) != 3 or not parts[2]:
            raise BadPacket("parameter write by name")
        group, name, typed_value = parts
        identity = self._ids.get(f"{group.decode('latin-1')}.{name.decode('latin-1')}")
        if identity is None:
            error = int(Errno.ENOENT)
        elif typed_value[0] != self._entries[identity].type & _TYPE_MASK:
            error = int(Errno.EINVAL)
        else:
            error = self._firmware.param_write(identity, typed_value[1:])
        answer = encode(Port.PARAM, MISC, data[: len(data) - len(typed_value)] + bytes((error,)))
        return (None if error else identity), answer

    def _extended_type(self, identity: int) -> bytes:
        entry = self._entries[identity]
        if not entry.extended:
            return bytes((Errno.ENOENT,))
        return bytes((_PERSISTENT if entry.persistent else 0,))

    def _extended_type_2(self, identity: int) -> bytes:
        if not self._entries[identity].extended:
            return bytes((Errno.ENOENT,))
        return bytes((Errno.OK,)) + self._extended_type(identity)

    def _default(self, identity: int) -> bytes:
        if self._entries[identity].type & _READ_ONLY:
            return bytes((Errno.ENOENT,))
        return self._firmware.param_default(identity)

    def _default_2(self, identity: int) -> bytes:
        if self._entries[identity].type & _READ_ONLY:
            return bytes((Errno.ENOENT,))
        return bytes((Errno.OK,)) + self._firmware.param_default(identity)

    def _store(self, identity: int) -> bytes:
        entry = self._entries[identity]
        if not entry.persistent:
            return bytes((Errno.ENOENT,))
        self._eeprom.store(_name(entry), self.value(identity))
        return bytes((Errno.OK,))

    def _clear(self, identity: int) -> bytes:
        found = self._eeprom.clear(_name(self._entries[identity]))
        return bytes((Errno.OK if found else Errno.ENOENT,))

    def _state(self, identity: int) -> bytes:
        default = self._firmware.param_default(identity)
        stored = self._eeprom.values().get(_name(self._entries[identity]))
        if stored is None:
            return b"\0" + default
        return b"\1" + default + self._packed(identity, stored)

    def _packed(self, identity: int, value: float) -> bytes:
        return pack_value(self._entries[identity].type, value)


def _name(entry: Entry) -> str:
    return f"{entry.group}.{entry.name}"


def _listed(entry: Entry) -> TocEntry:
    flags = _EXTENDED if entry.extended else 0
    return TocEntry(entry.type & _TOC_FLAGS | flags, entry.group, entry.name)
