# SPDX-License-Identifier: GPL-3.0-or-later
"""Decodes what a drone says without a radio, from its log blocks and its app channel."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, TypeAlias

from ground.link.logblocks import LogBlock, log_blocks
from ground.link.wire import decode_message
from ground.model import Incoming
from ground.sim.firmware import BlockReader, Entry, Firmware

LOG_TYPES: Final = {"uint8_t": (1, "B"), "uint16_t": (2, "H"), "uint32_t": (3, "I"),
                    "float": (7, "f"), "FP16": (8, "e")}  # fmt: skip
"""Numbers of the log types, and their letters for struct."""
Keeper: TypeAlias = Callable[[Incoming, int], None]
"""Takes a message and the drone's time [ms]."""
MAP_PERIOD_MS: Final = 20


class Block:
    """One log block of the ground station, with the ids of a drone's variables."""

    def __init__(self, block: LogBlock, numbers: dict[str, int]) -> None:
        self.period_ms = block.period_ms
        self.ids = tuple(numbers[name] for name, _ in block.variables)
        self.types = bytes(LOG_TYPES[kind][0] for _, kind in block.variables)
        self._block = block
        self._layout = struct.Struct("<" + "".join(LOG_TYPES[k][1] for _, k in block.variables))

    def message(self, time_ms: int, data: bytes) -> Incoming | None:
        """Decode one sample; None if its size is wrong or its values make no sense."""
        if len(data) != self._layout.size:
            return None
        names = (name for name, _ in self._block.variables)
        values = dict(zip(names, self._layout.unpack(data), strict=True))
        return self._block.decode(time_ms, values)

    def reader(self, firmware: Firmware) -> BlockReader:
        """A reader that takes samples of this block."""
        return firmware.block_reader(self.ids, self.types)


def blocks_of(firmware: Firmware, map_period_ms: int = MAP_PERIOD_MS) -> list[Block]:
    """All log blocks of a session."""
    numbers = numbers_of(firmware.log_entries())
    return [Block(block, numbers) for block in log_blocks(map_period_ms)]


def numbers_of(entries: Sequence[Entry]) -> dict[str, int]:
    """The id of each variable by its full name."""
    return {f"{entry.group}.{entry.name}": number for number, entry in enumerate(entries)}


class Ear:
    """Finds the drone's messages in recorded calls (calls.py)."""

    def __init__(self, firmware: Firmware) -> None:
        self._blocks = {(b.ids, b.types): b for b in blocks_of(firmware)}

    def hear(self, outcomes: Iterable[tuple[bytes, bytes, bytes]]) -> Iterator[Incoming]:
        """Messages in a sequence of letter, arguments and outcome."""
        for letter, arguments, outcome in outcomes:
            message = None
            if letter == b"L":
                message = self._log(arguments, outcome[1:])
            elif letter == b"A" and len(outcome) > 1:
                message = decode_message(outcome[1:])
            if message is not None:
                yield message

    def _log(self, arguments: bytes, data: bytes) -> Incoming | None:
        time_ms, count = struct.unpack_from("<IB", arguments)
        ids = struct.unpack_from(f"<{count}H", arguments, 5)
        block = self._blocks.get((ids, arguments[5 + 2 * count :]))
        return block.message(time_ms, data) if block else None
