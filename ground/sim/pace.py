# SPDX-License-Identifier: GPL-3.0-or-later
"""The wall time at which each step of simulated time is due."""

_CATCH_UP_S = 0.05
"""A simulator that has fallen behind catches up by at most this much."""
_DATAGRAMS_PER_S = {True: 6000.0, False: 1500.0}
"""Most datagrams sent per second, by whether the unread bytes of all clients are known. If so, as
many as a client in Python can process; if not, few enough to take a sixth of a second to fill a
socket's buffer."""
_BURST_S = 0.01


class Pace:
    """The speed of simulated time, in simulated seconds per wall second.

    Faster than real time, simulated time waits for clients that lag; real time waits for nobody.
    """

    def __init__(self, speed: float, step_s: float, now_s: float) -> None:
        self._speed = speed
        self._step_s = step_s
        self._due_s = now_s
        self._drained_s = now_s

    @property
    def waits(self) -> bool:
        """Whether simulated time is faster than real time and so waits for clients."""
        return self._speed > 1.0

    def next_due_s(self, hurry: bool, now_s: float) -> float:
        """The wall time at which the next step may run; real time at most without `hurry`."""
        speed = self._speed if hurry else min(self._speed, 1.0)
        self._due_s = max(self._due_s + self._step_s / speed, now_s - _CATCH_UP_S)
        return max(self._due_s, self._drained_s - _BURST_S)

    def sent(self, datagrams: int, now_s: float, seen: bool) -> None:
        """Note datagrams sent; `seen` tells whether the unread bytes of all clients are known."""
        self._drained_s = max(self._drained_s, now_s) + datagrams / _DATAGRAMS_PER_S[seen]
