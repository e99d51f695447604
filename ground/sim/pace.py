# SPDX-License-Identifier: GPL-3.0-or-later
"""When the next step of simulated time is due in wall time."""

_CATCH_UP_S = 0.05
"""A simulator that is late makes up for this much, no more."""
_DATAGRAMS_PER_S = {True: 6000.0, False: 1500.0}
"""Upper limits for what is sent: what a client written in Python digests without falling ever more
behind, and what fills a socket that cannot be seen in no less than a sixth of a second."""
_BURST_S = 0.01


class Pace:
    """Simulated seconds per wall second; inf is as fast as clients can follow.

    Time that is faster than reality waits for whoever listens; real time waits for nobody.
    """

    def __init__(self, speed: float, step_s: float, now_s: float) -> None:
        self._speed = speed
        self._step_s = step_s
        self._due_s = now_s
        self._drained_s = now_s

    @property
    def waits(self) -> bool:
        """It is faster than reality."""
        return self._speed > 1.0

    def next_due_s(self, hurry: bool, now_s: float) -> float:
        """Begin a step; it may run at this wall time. Without hurry time runs as it really does."""
        speed = self._speed if hurry else min(self._speed, 1.0)
        self._due_s = max(self._due_s + self._step_s / speed, now_s - _CATCH_UP_S)
        return max(self._due_s, self._drained_s - _BURST_S)

    def sent(self, datagrams: int, now_s: float, seen: bool) -> None:
        """So many datagrams have gone out, to clients that can be seen to read them or not."""
        self._drained_s = max(self._drained_s, now_s) + datagrams / _DATAGRAMS_PER_S[seen]
