# SPDX-License-Identifier: GPL-3.0-or-later
"""Record what comes over a link into an MCAP file, with a JSON channel for each kind of message."""

from __future__ import annotations

import json
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import BinaryIO

from mcap.writer import Writer

from ground import __version__
from ground.codec import KINDS, to_json
from ground.errors import GroundError
from ground.link import Link
from ground.model import Incoming, LinkStats, Outgoing

SCHEMA = b'{"type": "object"}'
CHUNK_BYTES = 1 << 16  # what a crash may cost


class RecordedLink:
    """A link that writes down everything it hears. Nothing that is sent is recorded."""

    def __init__(self, link: Link, path: Path) -> None:
        self._link = link
        self._path = path
        self._file: BinaryIO | None = None
        self._writer: Writer | None = None
        self._channels: dict[type[Incoming], int] = {}

    @property
    def stats(self) -> LinkStats:
        """Those of the link that is recorded."""
        return self._link.stats

    async def open(self) -> None:
        """Connect, then begin the file: a link that does not open leaves none."""
        await self._link.open()
        try:
            self._file = self._path.open("wb")
        except OSError as error:
            await self._link.close()
            raise GroundError(f"cannot record to {self._path}: {error.strerror}") from error
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES)
        self._writer.start(profile="", library=f"wayflie {__version__}")
        for name, kind in KINDS.items():
            schema = self._writer.register_schema(f"wayflie.{name}", "jsonschema", SCHEMA)
            self._channels[kind] = self._writer.register_channel(f"/{name}", "json", schema)

    async def close(self) -> None:
        """Let go and complete the file."""
        await self._link.close()
        if self._writer and self._file:
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()
            self._writer = self._file = None

    def send(self, message: Outgoing) -> None:
        """Hand over."""
        self._link.send(message)

    async def messages(self) -> AsyncIterator[Incoming]:
        """What comes in, after it was written down."""
        async for message in self._link.messages():
            if self._writer:
                now_ns = time.time_ns()
                data = json.dumps(to_json(message)).encode()
                self._writer.add_message(self._channels[type(message)], now_ns, data, now_ns)
            yield message
