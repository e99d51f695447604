# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes an MCAP file during a flight, so that a crash loses little of it."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mcap.well_known import MessageEncoding
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema

from ground import __version__
from ground.errors import GroundError
from ground.record.codec import to_json
from ground.record.folder import hold

CHUNK_NS = 2_000_000_000
"""Greatest age of a chunk before it is written to disk: what a crash of the PC may lose."""
CHUNK_BYTES = 1 << 17
"""Greatest size of a chunk. Its index, about 2 kB, stays in memory until the file is complete."""
ANY_OBJECT = b'{"type": "object"}'


class RecordFile:
    """Messages by topic: messages of model.py as JSON, others as protobuf or raw bytes."""

    def __init__(self, path: Path, about: Mapping[str, str]) -> None:
        """Create a file, which must not exist yet; `about` becomes its metadata."""
        try:
            self._file = path.open("xb")
        except FileExistsError:
            raise GroundError(f"{path} exists already", "record to another file") from None
        except OSError as error:
            raise GroundError(f"cannot record to {path}: {error.strerror}") from error
        with contextlib.suppress(OSError):  # no locks here: prune() spares the newest file anyway
            hold(self._file.fileno())
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES)
        self._writer.start(profile="", library=f"wayflie {__version__}")
        self._writer.add_metadata("wayflie", {"version": __version__, **about})
        self._channels: dict[str, int] = {}
        self._chunk_ns: int | None = None  # when the present chunk began

    def note(self, topic: str, word: object, time_ns: int) -> None:
        """Write a dataclass of model.py or requests.py as JSON."""
        if topic not in self._channels:
            name = f"wayflie.{type(word).__name__}"
            schema = self._writer.register_schema(name, "jsonschema", ANY_OBJECT)
            self._open(topic, MessageEncoding.JSON, schema)
        self._write(topic, json.dumps(to_json(word)).encode(), time_ns)

    def show(self, topic: str, message: Any, time_ns: int) -> None:  # noqa: ANN401
        """Write a protobuf message, which viewers understand."""
        if topic not in self._channels:
            schema = register_schema(self._writer, type(message))
            self._open(topic, MessageEncoding.Protobuf, schema)
        self._write(topic, message.SerializeToString(), time_ns)

    def put(self, topic: str, data: bytes, time_ns: int) -> None:
        """Write bytes that only Wayflie understands."""
        if topic not in self._channels:
            self._open(topic, "wayflie", 0)
        self._write(topic, data, time_ns)

    def close(self) -> None:
        """Complete the file."""
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._file.close()

    def abandon(self) -> None:
        """Close the file as it is; it can be read up to what was written."""
        with contextlib.suppress(OSError):
            self._file.close()

    def _open(self, topic: str, encoding: str, schema: int) -> None:
        self._channels[topic] = self._writer.register_channel(topic, encoding, schema)

    def _write(self, topic: str, data: bytes, time_ns: int) -> None:
        self._writer.add_message(self._channels[topic], time_ns, data, time_ns)
        if self._chunk_ns is None or time_ns < self._chunk_ns:
            self._chunk_ns = time_ns
        if time_ns - self._chunk_ns >= CHUNK_NS:
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._chunk_ns = None
        else:
            self._file.flush()  # a full chunk must survive the end of this program
