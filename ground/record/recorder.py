# SPDX-License-Identifier: GPL-3.0-or-later
"""Records a session: all messages over a link in both directions, and views for Foxglove."""

from __future__ import annotations

import contextlib
import itertools
import logging
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path

from rich.console import Console as Rich

from ground.link.protocol import Link
from ground.model import Incoming, LinkStats
from ground.record.folder import Deleted, new_recording, prune
from ground.record.foxview import FoxgloveView
from ground.record.writer import RecordFile
from ground.requests import Outgoing

log = logging.getLogger(__name__)

SENT = "/sent/"
"""Prefix of the topics of sent messages; the name of the message follows."""
OFF = Path("off")
"""As a file name: do not record."""


def recorded(link: Link, where: Path | None) -> Link:
    """Wrap a link to record it into a file; None: a new file in the folder; OFF: no recording."""
    return link if where == OFF else RecordedLink(link, where)


def not_taken(file: Path) -> Path:
    """The file or, if it exists, the first free of FILE-2, FILE-3 and so on."""
    if file == OFF or not file.exists():
        return file
    numbered = (file.with_stem(f"{file.stem}-{number}") for number in itertools.count(2))
    return next(name for name in numbered if not name.exists())


@contextlib.asynccontextmanager
async def where_told(link: Link, out: Rich) -> AsyncIterator[None]:
    """Tell the user what was deleted for the recording and, at the end, where the recording is."""
    if isinstance(link, RecordedLink) and link.deleted:
        out.print(f"[dim]{link.deleted}[/]", soft_wrap=True)
    try:
        yield
    finally:
        if isinstance(link, RecordedLink):
            out.print(f"[dim]recorded: {link.path}   (wayflie replay shows it)[/]", soft_wrap=True)


class RecordedLink:
    """A link that records everything that it hears and sends."""

    def __init__(self, link: Link, where: Path | None) -> None:
        self._link = link
        self._where = where
        self.path = where or OFF
        self.deleted: Deleted | None = None
        """Older recordings that were deleted to make room."""
        self._file: RecordFile | None = None
        self._view: FoxgloveView | None = None

    @property
    def stats(self) -> LinkStats:
        """Counters of the recorded link."""
        return self._link.stats

    async def open(self) -> None:
        """Connect, then create the file, so that a link that fails to open leaves none."""
        await self._link.open()
        try:
            self.deleted = None if self._where else prune()
            self.path = self._where or new_recording()
            self._file = RecordFile(self.path, {})
        except BaseException:
            await self._link.close()
            raise
        self._view = FoxgloveView(self._file)

    async def close(self) -> None:
        """Close the link and complete the file."""
        await self._link.close()
        file, self._file = self._file, None
        view, self._view = self._view, None
        if file and view:
            self._try(lambda: view.end(time.time_ns()))
            self._try(file.close)

    def send(self, message: Outgoing) -> None:
        """Send a message and record it."""
        self._link.send(message)
        file = self._file
        if file:
            topic = SENT + type(message).__name__
            self._try(lambda: file.note(topic, message, time.time_ns()))

    async def messages(self) -> AsyncIterator[Incoming]:
        """Incoming messages, each recorded before it is passed on."""
        async for message in self._link.messages():
            self._take(message)
            yield message

    def _take(self, message: Incoming) -> None:
        file, view, now_ns = self._file, self._view, time.time_ns()
        if file is None or view is None:
            return

        def write() -> None:
            file.note("/" + type(message).__name__, message, now_ns)
            view.take(message, now_ns)

        self._try(write)

    def _try(self, write: Callable[[], None]) -> None:
        """Write; an error (such as a full disk) ends the recording, never the flight."""
        try:
            write()
        except Exception as error:
            if self._file:
                self._file.abandon()
            self._file = None
            log.warning("recording to %s ended: %s", self.path, error)
