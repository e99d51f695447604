# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds gaps in a numbered series, and decides what to ask for again."""

from __future__ import annotations

from ground.link.wire import SEQUENCES

ASK_EVERY_MS = 250  # an answer takes some tens of milliseconds
BACKOFF_MAX = 8  # the wait before each further request grows, up to this many times ASK_EVERY_MS


class Gaps:
    """Numbers modulo 2^16, in any order and repeated; the drone can resend the last `kept`."""

    def __init__(self, kept: int) -> None:
        self._kept = kept
        self._next: int | None = None
        self._missing: dict[int, tuple[int, float]] = {}
        self.given_up = 0

    def take(self, number: int) -> bool:
        """Note a number that has come. @return False if it had come before"""
        self.expect(number)
        if self._next == number:
            self._next = (number + 1) % SEQUENCES
            return True
        return self._missing.pop(number, None) is not None

    def expect(self, coming: int) -> None:
        """Note that `coming` is the next number: all before it exist."""
        if self._next is None:
            self._next = max(0, coming - self._kept)
        ahead = (coming - self._next) % SEQUENCES
        if ahead >= SEQUENCES // 2:
            return
        gone = max(0, ahead - self._kept)
        self.given_up += gone
        for number in range(self._next + gone, self._next + ahead):
            self._missing[number % SEQUENCES] = (0, float("-inf"))
        self._next = coming
        self._forget()

    @property
    def first_missing(self) -> int | None:
        """The oldest number that may still come; None before anything was heard."""
        return next(iter(self._missing), self._next)

    def ask(self, now_ms: float) -> tuple[int, int] | None:
        """First number and count to ask for now; None if nothing is due."""
        due = [
            number
            for number, (asked, asked_ms) in self._missing.items()
            if now_ms - asked_ms >= ASK_EVERY_MS * min(asked, BACKOFF_MAX)
        ]
        if not due:
            return None
        first = due[0]
        count = (due[-1] - first) % SEQUENCES + 1
        for number in due:
            self._missing[number] = (self._missing[number][0] + 1, now_ms)
        return first, count

    def _forget(self) -> None:
        """Give up numbers that the drone does not keep any more."""
        assert self._next is not None
        for number in list(self._missing):
            if (self._next - number) % SEQUENCES > self._kept:
                del self._missing[number]
                self.given_up += 1
