# SPDX-License-Identifier: GPL-3.0-or-later
"""Record a session: all that comes over a link and all that is sent, and views for Foxglove."""

from __future__ import annotations

import contextlib
import itertools
import logging
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path

from rich.console import Console as Rich

from ground.errors import GroundError
from ground.foxview import FoxgloveView
from ground.link import Link
from ground.model import Incoming, LinkStats, Outgoing
from ground.recordfile import RecordFile
from ground.recordfolder import Deleted, new_recording, prune

log = logging.getLogger(__name__)

SENT = "/sent/"
"""What the topics of sent messages begin with; the name of the message follows."""
OFF = Path("off")
"""In place of a file: nothing is recorded."""


def recorded(link: Link, where: Path | None) -> Link:
    """The link, recorded into that file; None: into a new one among the recordings; or OFF."""
    return link if where == OFF else RecordedLink(link, where)


def not_taken(file: Path) -> Path:
    """The file, or as many as there are already: FILE, FILE-2, FILE-3."""
    if file == OFF or not file.exists():
        return file
    numbered = (file.with_stem(f"{file.stem}-{number}") for number in itertools.count(2))
    return next(name for name in numbered if not name.exists())


@contextlib.asynccontextmanager
async def where_told(link: Link, out: Rich) -> AsyncIterator[None]:
    """Say what was deleted for it, and at the end where the session is kept."""
    if isinstance(link, RecordedLink) and link.deleted:
        out.print(f"[dim]{link.deleted}[/]", soft_wrap=True)
    try:
        yield
    finally:
        if isinstance(link, RecordedLink):
            out.print(f"[dim]recorded: {link.path}   (wayflie replay shows it)[/]", soft_wrap=True)


class RecordedLink:
    """A link that writes down everything that it hears and sends."""

    def __init__(self, link: Link, where: Path | None) -> None:
        self._link = link
        self._where = where
        self.path = where or OFF
        self.deleted: Deleted | None = None
        """Older recordings that had to go."""
        self._file: RecordFile | None = None
        self._view: FoxgloveView | None = None

    @property
    def stats(self) -> LinkStats:
        """Those of the link that is recorded."""
        return self._link.stats

    async def open(self) -> None:
        """Connect, then begin the file: a link that does not open leaves none."""
        await self._link.open()
        try:
            self.deleted = None if self._where else prune()
            self.path = self._where or new_recording()
            self._file = RecordFile(self.path, {})
        except GroundError:
            await self._link.close()
            raise
        self._view = FoxgloveView(self._file)

    async def close(self) -> None:
        """Let go and complete the file."""
        await self._link.close()
        file, self._file = self._file, None
        if file:
            self._try(file.close)

    def send(self, message: Outgoing) -> None:
        """Hand over, and write down what was handed over."""
        self._link.send(message)
        file = self._file
        if file:
            topic = SENT + type(message).__name__
            self._try(lambda: file.note(topic, message, time.time_ns()))

    async def messages(self) -> AsyncIterator[Incoming]:
        """What comes in, after it was written down."""
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
        """Whatever is wrong with the recording, a full disk before all, the flight goes on."""
        try:
            write()
        except Exception as error:
            if self._file:
                self._file.abandon()
            self._file = None
            log.warning("recording to %s ended: %s", self.path, error)
