# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a recording: messages heard and sent, with times; of a damaged file, what is intact."""

from __future__ import annotations

import json
import logging
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from ground.errors import LinkUnavailable
from ground.model import Incoming, Odometry, Ranges, Telemetry
from ground.record.codec import KINDS, SENT_KINDS, from_json
from ground.record.recorder import SENT
from ground.requests import Outgoing

log = logging.getLogger(__name__)

# What mcap and zstandard raise on a truncated or damaged file.
DAMAGE = (
    McapError, ValueError, LookupError, EOFError, OverflowError, MemoryError,
    struct.error, ZstdError,
)  # fmt: skip
RECORD_BYTES_MAX = 1 << 24  # our chunks are far smaller
_NAME_A_FLIGHT = "name the .mcap of a flight, or no file for your newest"
RESTART_MS = 10_000  # a larger jump of the drone's clock means that it was restarted


@dataclass(frozen=True, slots=True)
class Entry:
    """One message of a file: bytes written under a topic; `time_s` is wall time."""

    time_s: float
    topic: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Heard:
    """A message from the drone; the time is in seconds of the session, by the drone's clock."""

    time_s: float
    message: Incoming


@dataclass(frozen=True, slots=True)
class Sent:
    """A message to the drone; the time is that of Heard."""

    time_s: float
    message: Outgoing


Spoken = Heard | Sent


def read_entries(path: Path) -> Iterator[Entry]:
    """All messages of an MCAP file, up to its end or to where it is damaged."""
    topics: dict[int, str] = {}
    with path.open("rb") as file:
        try:
            for record in StreamReader(
                file, validate_crcs=True, record_size_limit=RECORD_BYTES_MAX
            ).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message) and record.channel_id in topics:
                    yield Entry(record.log_time / 1e9, topics[record.channel_id], record.data)
        except DAMAGE as error:
            level = logging.WARNING if topics else logging.INFO  # the caller reports an empty file
            log.log(level, "%s: the recording ends early or is damaged: %s", path, error)


def read_recording(path: Path) -> Iterator[tuple[float, Incoming]]:
    """Messages from the drone, with their wall time in seconds."""
    for word in _read_words(path):
        if isinstance(word, Heard):
            yield word.time_s, word.message


def read_session(path: Path) -> list[Spoken]:
    """The whole session, by the drone's clock. Raises LinkUnavailable if the file holds none."""
    try:
        words = list(_read_words(path))
    except OSError as error:
        raise LinkUnavailable(f"cannot read {path}: {error.strerror}", _NAME_A_FLIGHT) from error
    if not words:
        raise LinkUnavailable(f"{path} is not a Wayflie recording", _NAME_A_FLIGHT)
    clock = _Clock()
    return [replace(word, time_s=clock.at(word)) for word in words]


class _Clock:
    """Session time in seconds, which follows the drone's clock where messages carry it.

    A simulator may be faster than the wall clock, so wall time counts only across a restart.
    """

    def __init__(self) -> None:
        self._drone: tuple[int, float] | None = None  # latest drone time [ms] and session time [s]
        self._wall_s: float | None = None
        self._now_s = 0.0

    def at(self, word: Spoken) -> float:
        """Session time of a word whose time is still the wall clock's."""
        wall_s = word.time_s
        if self._wall_s is None:
            self._wall_s = wall_s
        if not isinstance(word.message, Telemetry | Odometry | Ranges):
            return self._now_s
        drone_ms = word.message.drone_ms
        step_ms = drone_ms - self._drone[0] if self._drone else None
        if step_ms is not None and self._drone and -RESTART_MS < step_ms < RESTART_MS:
            self._now_s = max(self._now_s, self._drone[1] + step_ms / 1000)
        else:
            self._now_s += wall_s - self._wall_s
        if step_ms is None or step_ms >= 0 or step_ms <= -RESTART_MS:
            self._drone = drone_ms, self._now_s
        self._wall_s = wall_s
        return self._now_s


def _read_words(path: Path) -> Iterator[Spoken]:
    """All messages by wall time, except those of unknown kinds or other versions."""
    bad = 0
    for entry in read_entries(path):
        try:
            if (name := entry.topic.removeprefix(SENT)) != entry.topic:
                if kind := SENT_KINDS.get(name):
                    yield Sent(entry.time_s, from_json(kind, json.loads(entry.data)))
            elif heard := KINDS.get(entry.topic.removeprefix("/")):
                yield Heard(entry.time_s, from_json(heard, json.loads(entry.data)))
        except ValueError:
            bad += 1
    if bad:
        log.warning("%s: %d messages are of another version", path, bad)
