# SPDX-License-Identifier: GPL-3.0-or-later
"""One drone's CRTP services behind the radio: packets in, answers out, without sockets."""

from collections.abc import Callable, Iterator

from ground.sim import logs, params, toc
from ground.sim.crtp import (
    APP,
    MAX_DATA_BYTES,
    PROTOCOL_VERSION,
    BadPacket,
    Errno,
    Port,
    decode,
    encode,
)
from ground.sim.firmware import Firmware
from ground.sim.flightstack import FlightStack
from ground.sim.localization import Localization
from ground.sim.logs import LogBlocks
from ground.sim.model import Readings
from ground.sim.params import Params
from ground.sim.toc import Toc, TocEntry

_LINK_SOURCE = b"Bitcraze Crazyflie".ljust(MAX_DATA_BYTES, b"\0")
_FIRMWARE_VERSION = b"2026.08 wayflie sim"
_DEVICE_TYPES = {True: b"Crazyflie 2.1", False: b"Crazyflie 2.1 Brushless"}
_MEMORY_ADDRESS_BYTES = 5
_USER_NOTIFICATION = 3


class Session:
    """What the drone remembers of one client: its log blocks and the parameters it has read."""

    def __init__(self, firmware: Firmware) -> None:
        self.logs = LogBlocks(firmware)
        self.params_read: set[int] = set()


_Handler = Callable[[Session, bytes], bytes | None]


class Crazyflie:
    """One drone's radio services; single-threaded, as the firmware is simulated."""

    def __init__(
        self,
        firmware: Firmware,
        stack: FlightStack,
        parameters: Params,
        localization: Localization,
        readings: Readings,
        auto_arm: bool,
    ) -> None:
        self.app_packets_lost = 0
        self._firmware = firmware
        self._stack = stack
        self._params = parameters
        self._localization = localization
        self._log_toc = _log_toc(firmware)
        self._device_type = _DEVICE_TYPES[auto_arm]
        self._changed: list[tuple[int, Session | None]] = []
        self._handlers = self._table(readings)

    def open_session(self) -> Session:
        """Start a session for a new client."""
        return Session(self._firmware)

    def settled(self, session: Session) -> bool:
        """Whether the client has read every parameter, so that its handshake is over."""
        return len(session.params_read) >= len(self._params)

    def answer(self, session: Session, datagram: bytes) -> bytes | None:
        """Take one packet and return the answer, if any; raise BadPacket if no service knows it."""
        packet = decode(datagram)
        handler = self._handlers.get((packet.port, packet.channel))
        if handler is None:
            raise BadPacket("port or channel")
        return handler(session, packet.data)

    def news(self) -> Iterator[tuple[bytes, Session | None]]:
        """Packets since the last call, for all clients but the one that is named with each."""
        for line in self._stack.console:
            yield from ((packet, None) for packet in _console(line.encode("ascii") + b"\n"))
        self._stack.console.clear()
        while text := self._firmware.console_take():
            yield from ((packet, None) for packet in _console(text))
        while packet := self._firmware.appchannel_take():
            yield encode(*APP, packet), None
        self._changed += ((identity, None) for identity in self._params.changed_by_firmware())
        for identity, setter in self._changed:
            yield self._params.news(identity), setter
        self._changed.clear()

    def _table(self, readings: Readings) -> dict[tuple[int, int], _Handler]:
        stack = self._stack
        return {
            (Port.PARAM, toc.CHANNEL): lambda session, data: self._params.toc.answer(data),
            (Port.PARAM, params.READ): self._read_param,
            (Port.PARAM, params.WRITE): self._write_param,
            (Port.PARAM, params.MISC): self._misc_param,
            (Port.SETPOINT, 0): lambda session, data: stack.roll_pitch_yaw_thrust(data),
            (Port.MEMORY, 0): self._memory_info,
            (Port.MEMORY, 1): lambda session, data: _memory_failed(1, data),
            (Port.MEMORY, 2): lambda session, data: _memory_failed(2, data),
            (Port.LOG, logs.TOC): lambda session, data: self._log_toc.answer(data),
            (Port.LOG, logs.CONTROL): lambda session, data: session.logs.control(data),
            (Port.LOCALIZATION, 0): lambda session, data: self._localization.position(data),
            (Port.LOCALIZATION, 1): self._localize,
            (Port.LOCALIZATION, 2): lambda session, data: None,
            (Port.SETPOINT_GENERIC, 0): lambda session, data: stack.generic(data),
            (Port.SETPOINT_GENERIC, 1): lambda session, data: stack.notify_stop(readings, data),
            (Port.SETPOINT_HIGH_LEVEL, 0): lambda session, data: stack.high_level(data),
            (Port.SUPERVISOR, 0): lambda session, data: stack.supervisor_info(data),
            (Port.SUPERVISOR, 1): lambda session, data: stack.supervisor_command(data),
            (Port.PLATFORM, 0): self._platform_command,
            (Port.PLATFORM, 1): self._platform_version,
            APP: self._app_packet,
            (Port.LINK, 0): lambda session, data: encode(Port.LINK, 0, data),
            (Port.LINK, 1): lambda session, data: encode(Port.LINK, 1, _LINK_SOURCE),
            (Port.LINK, 2): lambda session, data: None,
            (Port.LINK, 3): lambda session, data: None,
        }

    def _localize(self, session: Session, data: bytes) -> None:
        self._localization.pose(data)
        self._stack.legacy_emergency(data)

    def _read_param(self, session: Session, data: bytes) -> bytes:
        identity, answer = self._params.read(data)
        if identity < len(self._params):
            session.params_read.add(identity)
        return answer

    def _write_param(self, session: Session, data: bytes) -> bytes | None:
        identity, answer = self._params.write(data)
        if identity is not None:
            self._changed.append((identity, session))
        return answer

    def _misc_param(self, session: Session, data: bytes) -> bytes:
        identity, answer = self._params.misc(data)
        if identity is not None:
            self._changed.append((identity, None))
        return answer

    def _memory_info(self, session: Session, data: bytes) -> bytes:
        """Answer that there are no memories: their count is 0, and so no details exist."""
        if data == b"\1":
            return encode(Port.MEMORY, 0, b"\1\0")
        if len(data) == 2 and data[0] == 2:
            return encode(Port.MEMORY, 0, data)
        raise BadPacket("memory request")

    def _platform_command(self, session: Session, data: bytes) -> bytes:
        if not data:
            raise BadPacket("platform command")
        if data[0] == _USER_NOTIFICATION:
            return encode(Port.PLATFORM, 0)
        if data[0] == 0:
            return encode(Port.PLATFORM, 0, data)
        return self._stack.legacy_command(data)

    def _platform_version(self, session: Session, data: bytes) -> bytes:
        answers = {
            b"\0": PROTOCOL_VERSION.to_bytes(4, "little"),
            b"\1": _FIRMWARE_VERSION,
            b"\2": self._device_type,
        }
        if data not in answers:
            raise BadPacket("version request")
        return encode(Port.PLATFORM, 1, data + answers[data])

    def _app_packet(self, session: Session, data: bytes) -> None:
        """Pass a packet to the app; as on the drone, a full queue loses it."""
        if not data:
            raise BadPacket("empty app packet")
        if not self._firmware.appchannel_push(data):
            self.app_packets_lost += 1


def _log_toc(firmware: Firmware) -> Toc:
    """Entries carry the bare type: clients fail if other bits are set."""
    entries = [TocEntry(e.type & 0x0F, e.group, e.name) for e in firmware.log_entries()]
    limits = bytes((logs.MAX_BLOCKS, logs.MAX_VARIABLES))
    return Toc(Port.LOG, entries, firmware.log_crc(), limits)


def _memory_failed(channel: int, data: bytes) -> bytes:
    if len(data) <= _MEMORY_ADDRESS_BYTES:
        raise BadPacket("memory access")
    return encode(Port.MEMORY, channel, data[:_MEMORY_ADDRESS_BYTES] + bytes((Errno.EIO,)))


def _console(text: bytes) -> Iterator[bytes]:
    for start in range(0, len(text), MAX_DATA_BYTES):
        yield encode(Port.CONSOLE, 0, text[start : start + MAX_DATA_BYTES])
