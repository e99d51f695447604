# SPDX-License-Identifier: GPL-3.0-or-later
"""Link over a recording: hears again what was heard then, at its pace. Commands go nowhere."""

from __future__ import annotations

import asyncio
import json
import logging
import struct
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from ground.codec import KINDS, from_json
from ground.errors import LinkUnavailable
from ground.model import Incoming, LinkChange, LinkState, LinkStats, Outgoing

log = logging.getLogger(__name__)

LONGEST_PAUSE_S = 2.0


def read_recording(path: Path) -> Iterator[tuple[float, Incoming]]:
    """Seconds and messages of a file; one that was cut off gives what is whole of it."""
    topics: dict[int, str] = {}
    with path.open("rb") as file:
        try:
            for record in StreamReader(file).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic.removeprefix("/")
                elif isinstance(record, Message) and topics.get(record.channel_id) in KINDS:
                    kind = KINDS[topics[record.channel_id]]
                    yield record.log_time / 1e9, from_json(kind, json.loads(record.data))
        except (McapError, ValueError, struct.error) as error:
            log.warning("%s: the recording ends early or is damaged: %s", path, error)


class ReplayLink:
    """A recorded session."""

    def __init__(self, path: Path, speed: float = 1.0) -> None:
        self._path = path
        self._speed = speed
        self._closed = False

    @property
    def stats(self) -> LinkStats:
        """Nothing is lost here."""
        return LinkStats()

    async def open(self) -> None:
        """See that there is something to hear."""
        try:
            first = next(read_recording(self._path), None)
        except OSError as error:
            raise LinkUnavailable(f"cannot read {self._path}: {error.strerror}") from error
        if first is None:
            raise LinkUnavailable(f"{self._path} is no recording of Wayflie")

    async def close(self) -> None:
        """Stop where it is."""
        self._closed = True

    def send(self, message: Outgoing) -> None:
        """Nobody is there to hear it."""

    async def messages(self) -> AsyncIterator[Incoming]:
        """The recording, then the end of the link."""
        before_s: float | None = None
        for time_s, message in read_recording(self._path):
            pause_s = min(time_s - (before_s or time_s), LONGEST_PAUSE_S) / self._speed
            before_s = time_s
            await asyncio.sleep(max(pause_s, 0.0))
            if self._closed:
                return
            yield message
        yield LinkChange(LinkState.LOST, "the recording has ended")
