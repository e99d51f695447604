# SPDX-License-Identifier: GPL-3.0-or-later
"""What heartbeats tell about the link: round-trip time, loss, and missing answers."""

from __future__ import annotations

from collections import deque

BEATS = 20


class Pulse:
    """The latest heartbeats and their answers; times in seconds of one ground clock."""

    def __init__(self) -> None:
        self._sent: dict[int, float] = {}
        self._answered: deque[bool] = deque(maxlen=BEATS)
        self.round_trip_ms: float | None = None

    def sent(self, number: int, now_s: float) -> None:
        """Note a heartbeat that is being sent."""
        self._sent[number] = now_s
        while len(self._sent) > BEATS:
            del self._sent[next(iter(self._sent))]

    def heard(self, number: int, now_s: float) -> None:
        """Note an answer; earlier heartbeats without one count as lost."""
        if (sent_s := self._sent.get(number)) is None:
            return
        self.round_trip_ms = round(1000 * (now_s - sent_s), 1)
        for earlier in list(self._sent):
            del self._sent[earlier]
            self._answered.append(earlier == number)
            if earlier == number:
                return

    @property
    def unanswered(self) -> int:
        """Heartbeats since the last answered one; if this grows, the app is silent."""
        return max(0, len(self._sent) - 1)

    @property
    def loss(self) -> float:
        """Share of the latest heartbeats without an answer, from 0 to 1."""
        return 1 - sum(self._answered) / len(self._answered) if self._answered else 0.0
