# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a recording: what was heard and sent, dated; a torn file gives what is whole of it."""

from __future__ import annotations

import json
import logging
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from ground.codec import KINDS, SENT_KINDS, from_json
from ground.errors import LinkUnavailable
from ground.model import Incoming, Odometry, Outgoing, Ranges, Telemetry
from ground.record import SENT

log = logging.getLogger(__name__)

# What mcap and zstandard raise on a file that was cut off or changed.
DAMAGE = (
    McapError, ValueError, LookupError, EOFError, OverflowError, MemoryError,
    struct.error, ZstdError,
)  # fmt: skip
RECORD_BYTES_MAX = 1 << 24  # a chunk of ours is far smaller
RESTART_MS = 10_000  # the drone's clock jumps by more: it is another one


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of a file: bytes that were written under a topic. `time_s` is of the wall clock."""

    time_s: float
    topic: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Spoken:
    """A message that was heard or sent, seconds after the first by the drone's clock."""

    time_s: float
    message: Incoming | Outgoing
    sent: bool


def read_entries(path: Path) -> Iterator[Entry]:
    """Everything in an MCAP file up to where it ends or is damaged; its metadata as a topic ""."""
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
                elif isinstance(record, Metadata) and record.name == "wayflie":
                    yield Entry(0.0, "", json.dumps(record.metadata).encode())
        except DAMAGE as error:
            log.warning("%s: the recording ends early or is damaged: %s", path, error)


def read_recording(path: Path) -> Iterator[tuple[float, Incoming]]:
    """Seconds by the wall clock, and what was heard."""
    for time_s, message, sent in _read_words(path):
        if not sent:
            yield time_s, message  # type: ignore[misc]


def read_session(path: Path) -> list[Spoken]:
    """The whole session, by the drone's clock. Raises LinkUnavailable where there is none."""
    try:
        words = list(_read_words(path))
    except OSError as error:
        raise LinkUnavailable(f"cannot read {path}: {error.strerror}") from error
    if not words:
        raise LinkUnavailable(f"{path} is no recording of Wayflie", "name an MCAP file of a flight")
    spoken, clock = [], _Clock()
    for time_s, message, sent in words:
        spoken.append(Spoken(clock.at(time_s, message), message, sent))
    return spoken


class _Clock:
    """Seconds of the session: they go as the drone's clock does where that is told.

    A simulator may be faster than the wall clock; between two times it tells, that one goes on.
    """

    def __init__(self) -> None:
        self._drone: tuple[int, float] | None = None  # last told [ms], and when in the session
        self._wall_s: float | None = None
        self._now_s = 0.0

    def at(self, wall_s: float, message: Incoming | Outgoing) -> float:
        if self._wall_s is None:
            self._wall_s = wall_s
        if not isinstance(message, Telemetry | Odometry | Ranges):
            return self._now_s
        drone_ms = message.drone_ms
        step_ms = drone_ms - self._drone[0] if self._drone else None
        if step_ms is not None and self._drone and -RESTART_MS < step_ms < RESTART_MS:
            self._now_s = max(self._now_s, self._drone[1] + step_ms / 1000)
        else:
            self._now_s += wall_s - self._wall_s
        if step_ms is None or step_ms >= 0 or step_ms <= -RESTART_MS:
            self._drone = drone_ms, self._now_s
        self._wall_s = wall_s
        return self._now_s


def _read_words(path: Path) -> Iterator[tuple[float, Incoming | Outgoing, bool]]:
    """What was heard and sent; entries of other kinds, and of other versions, are left out."""
    bad = 0
    for entry in read_entries(path):
        sent = entry.topic.startswith(SENT)
        name = entry.topic.removeprefix(SENT if sent else "/")
        kind = (SENT_KINDS if sent else KINDS).get(name)
        if kind is None:
            continue
        try:
            message = from_json(kind, json.loads(entry.data))
        except ValueError:
            bad += 1
            continue
        yield entry.time_s, message, sent
    if bad:
        log.warning("%s: %d messages are of another version", path, bad)
