# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of a numbered series are missing, and which of them to ask for again."""

from __future__ import annotations

NUMBERS = 1 << 16
ASK_EVERY_MS = 250  # an answer takes some tens of milliseconds
SELDOMER_MAX = 8  # each time it waits longer, up to so many times that


class Gaps:
    """Numbers modulo 2^16, in any order and more than once; the drone keeps the last `kept`."""

    def __init__(self, kept: int) -> None:
        self._kept = kept
        self._next: int | None = None
        self._missing: dict[int, tuple[int, float]] = {}
        self.given_up = 0

    def take(self, number: int) -> bool:
        """This one has come. @return False if it had come before."""
        self.expect(number)
        if self._next == number:
            self._next = (number + 1) % NUMBERS
            return True
        return self._missing.pop(number, None) is not None

    def expect(self, coming: int) -> None:
        """The next one to come is this: those before it exist."""
        if self._next is None:
            self._next = max(0, coming - self._kept)
        ahead = (coming - self._next) % NUMBERS
        if ahead >= NUMBERS // 2:
            return
        gone = max(0, ahead - self._kept)
        self.given_up += gone
        for number in range(self._next + gone, self._next + ahead):
            self._missing[number % NUMBERS] = (0, float("-inf"))
        self._next = coming
        self._forget()

    @property
    def first_missing(self) -> int | None:
        """The oldest that may still come, or None before anything was heard."""
        return next(iter(self._missing), self._next)

    def ask(self, now_ms: float) -> tuple[int, int] | None:
        """First number and count of what to ask for now."""
        due = [
            number
            for number, (asked, asked_ms) in self._missing.items()
            if now_ms - asked_ms >= ASK_EVERY_MS * min(asked, SELDOMER_MAX)
        ]
        if not due:
            return None
        first = due[0]
        count = (due[-1] - first) % NUMBERS + 1
        for number in due:
            self._missing[number] = (self._missing[number][0] + 1, now_ms)
        return first, count

    def _forget(self) -> None:
        """What the drone does not keep any more is given up."""
        assert self._next is not None
        for number in list(self._missing):
            if (self._next - number) % NUMBERS > self._kept:
                del self._missing[number]
                self.given_up += 1
