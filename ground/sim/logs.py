# SPDX-License-Identifier: GPL-3.0-or-later
"""The log blocks (port 5) of one client."""

import struct
from collections.abc import Iterator

from ground.sim.crtp import BadPacket, Errno, Port, encode
from ground.sim.firmware import BlockReader, Firmware

TOC, CONTROL, DATA = 0, 1, 2
MAX_BLOCKS, MAX_VARIABLES, MAX_BYTES = 16, 128, 26
_TYPE_MASK = 0x0F
_SIZES = (0, 1, 2, 4, 1, 2, 4, 4, 2)
_VARIABLE = struct.Struct("<BH")
_DELETE, _START, _STOP, _RESET, _CREATE, _APPEND, _START_MS = 2, 3, 4, 5, 6, 7, 8


class Block:
    """Log variables that are sampled together; times are of the firmware's clock."""

    def __init__(self, identity: int) -> None:
        self.identity = identity
        self.ids: list[int] = []
        self.types: list[int] = []
        self.reader: BlockReader | None = None
        self.period_ms = 0
        self.due_ms: int | None = None

    def size(self) -> int:
        """Bytes of one sample."""
        return sum(_SIZES[kind] for kind in self.types)


class LogBlocks:
    """The log blocks of one client."""

    def __init__(self, firmware: Firmware) -> None:
        self._firmware = firmware
        self._blocks: dict[int, Block] = {}
        self._limit = firmware.log_count()

    @property
    def running(self) -> bool:
        """Whether any block is being sampled."""
        return any(block.due_ms is not None for block in self._blocks.values())

    def control(self, data: bytes) -> bytes:
        """Answer a request on the control channel."""
        if not data or (len(data) < 2 and data[0] != _RESET):
            raise BadPacket("log control")
        command, block = data[0], data[1] if len(data) > 1 else 0
        error = self._command(command, block, data[2:])
        return encode(Port.LOG, CONTROL, bytes((command, block, error)))

    def samples(self, now_ms: int) -> Iterator[bytes]:
        """Packets of all samples due by now, each stamped with the time at which it was due."""
        for block in list(self._blocks.values()):
            while block.due_ms is not None and block.due_ms <= now_ms:
                due_ms = block.due_ms
                block.due_ms = due_ms + block.period_ms if block.period_ms else None
                yield self._sample(block, due_ms)

    def _sample(self, block: Block, time_ms: int) -> bytes:
        if block.reader is None:
            block.reader = self._firmware.block_reader(block.ids, block.types)
        stamp = (time_ms & 0xFFFFFF).to_bytes(3, "little")
        values = block.reader.read(time_ms)
        return encode(Port.LOG, DATA, bytes((block.identity,)) + stamp + values)

    def _command(self, command: int, identity: int, rest: bytes) -> int:
        if command == _RESET:
            self._blocks.clear()
            return Errno.OK
        if command == _CREATE:
            return self._create(identity, rest)
        if command not in (_DELETE, _START, _STOP, _APPEND, _START_MS):
            return Errno.ENOEXEC
        block = self._blocks.get(identity)
        if block is None:
            return Errno.ENOENT
        if command == _APPEND:
            return self._append(block, rest)
        if command == _DELETE:
            del self._blocks[identity]
        elif command == _STOP:
            block.due_ms = None
        else:
            self._start(block, _period_ms(command, rest))
        return Errno.OK

    def _create(self, identity: int, rest: bytes) -> int:
        if identity in self._blocks:
            return Errno.EEXIST
        if len(self._blocks) >= MAX_BLOCKS:
            return Errno.ENOMEM
        block = self._blocks[identity] = Block(identity)
        return self._append(block, rest)

    def _append(self, block: Block, rest: bytes) -> int:
        """Add variables; an incomplete last one is ignored, since cflib sends it again."""
        whole = len(rest) - len(rest) % _VARIABLE.size
        for kind, identity in _VARIABLE.iter_unpack(rest[:whole]):
            error = self._add(block, kind & _TYPE_MASK, identity)
            if error:
                return error
        return Errno.OK

    def _add(self, block: Block, kind: int, identity: int) -> int:
        if not 0 < kind < len(_SIZES) or identity >= self._limit:
            return Errno.ENOENT
        if block.size() + _SIZES[kind] > MAX_BYTES:
            return Errno.E2BIG
        if sum(len(other.ids) for other in self._blocks.values()) >= MAX_VARIABLES:
            return Errno.ENOMEM
        block.ids.append(identity)
        block.types.append(kind)
        block.reader = None
        return Errno.OK

    def _start(self, block: Block, period_ms: int) -> None:
        """Sample regularly, or just once if the period is zero."""
        block.period_ms = period_ms
        block.due_ms = self._firmware.now_ms() + period_ms


def _period_ms(command: int, rest: bytes) -> int:
    if command == _START and len(rest) == 1:
        return rest[0] * 10
    if command == _START_MS and len(rest) == 2:
        return int.from_bytes(rest, "little")
    raise BadPacket("log start")
