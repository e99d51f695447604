# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds what the ground has missed, by sequence numbers and the ages of tiles."""

from __future__ import annotations

from collections.abc import Iterator

from ground.core import EVENTS_KEPT, RECORDS_KEPT, TILES_A_PACKET, WireType
from ground.link.wire import SEQUENCES
from ground.map.groundmap import GroundMap
from ground.model import Beat, Event, History, Incoming
from ground.requests import AppRequest, Ask, AskTiles
from ground.station.gaps import Gaps

RESTART_MS = 1000  # the drone's clock goes back by more than this only after a restart
ROUTE_EVERY_MS = 300
TILES_EVERY_MS = 250
TILE_OLD_MS = 3000
SHARE_ASKED = 0.5  # greatest share of map packets to ask for: the rest are the drone's choice


class Recovery:
    """Sees every message first, and requests what is missing at intervals."""

    def __init__(self) -> None:
        self._beat_ms: int | None = None
        self._route: tuple[int, int] | None = None
        self._route_asked_ms = float("-inf")
        self._tiles_asked_ms = float("-inf")
        self.restarts = 0
        self._begin()

    def _begin(self) -> None:
        self.events = Gaps(EVENTS_KEPT)
        self.records = Gaps(RECORDS_KEPT)
        self._past: int | None = None

    def take(self, message: Incoming) -> bool:
        """Note a message. @return False for an event that had come before"""
        match message:
            case Beat():
                self._take_beat(message)
            case Event(sequence):
                self._past = sequence if self._past is None else self._past
                return self.events.take(sequence)
            case History(first, records):
                for number in range(first, first + len(records)):
                    self.records.take(number % SEQUENCES)
        return True

    def is_news(self, event: Event) -> bool:
        """Whether an event is newer than this link; older ones are recovered too."""
        return self._past is None or (event.sequence - self._past) % SEQUENCES < SEQUENCES // 2

    def requests(
        self, grid: GroundMap, route: tuple[int, int] | None, now_ms: float
    ) -> Iterator[AppRequest]:
        """What to request now; `route` is revision and number of points of the known route."""
        if asked := self.events.ask(now_ms):
            yield Ask(WireType.EVENT, *asked)
        if asked := self.records.ask(now_ms):
            yield Ask(WireType.HISTORY, *asked)
        if self._route not in (None, route) and self._due(self._route_asked_ms, now_ms):
            self._route_asked_ms = now_ms
            yield Ask(WireType.PATH)
        if self._due(self._tiles_asked_ms, now_ms, TILES_EVERY_MS):
            self._tiles_asked_ms = now_ms
            limit = min(TILES_A_PACKET, int(SHARE_ASKED * grid.rate_hz * TILES_EVERY_MS / 1000) + 1)
            if old := grid.oldest_tiles(TILE_OLD_MS, limit):
                yield AskTiles(old)

    def _due(self, asked_ms: float, now_ms: float, every_ms: float = ROUTE_EVERY_MS) -> bool:
        return not 0 <= now_ms - asked_ms < every_ms

    def _take_beat(self, beat: Beat) -> None:
        if self._beat_ms is not None and beat.drone_ms < self._beat_ms - RESTART_MS:
            self.restarts += 1
            self._beat_ms = None
            self._begin()
            self._past = 0  # all events from now on are of the new run
        if self._past is None:
            self._past = beat.next_event
        if self._beat_ms is None or beat.drone_ms >= self._beat_ms:
            self._beat_ms = beat.drone_ms
            self._route = (beat.path_revision, beat.path_total)
        self.events.expect(beat.next_event)
        self.records.expect(beat.next_record)
