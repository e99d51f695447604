# SPDX-License-Identifier: GPL-3.0-or-later
"""One running log block: its packets get full time stamps, and losses are counted."""

from __future__ import annotations

import time
from collections.abc import Callable

from ground.link.logblocks import LogBlock, Values
from ground.model import LogMessage

CLOCK_MS = 1 << 24  # period of the 24-bit millisecond stamps in log packets
OVERTAKEN_MS = 2000  # a packet up to this much older than the last was overtaken or duplicated
LONGEST_GAP_MS = 60_000  # a longer gap means a restart, not lost packets
OVERDUE_MS = 600
ANSWER_S = 0.1  # time for the drone to answer before it is asked again
RESTART_MS = 1000  # the clock goes back by more than this only after a restart
SPEED_MAX = 1000  # greatest speed of a simulator, as a multiple of real time


def restarted(before_ms: int, now_ms: int, elapsed_s: float) -> bool:
    """Whether the clock cannot have gone from before_ms to now_ms in the elapsed time."""
    forward_ms = (now_ms - before_ms) % CLOCK_MS
    if forward_ms > CLOCK_MS // 2:
        return CLOCK_MS - forward_ms > RESTART_MS
    return forward_ms > LONGEST_GAP_MS + SPEED_MAX * 1000 * elapsed_s


def near(clock_ms: int, reference_ms: int) -> int:
    """The time nearest to the reference with the same 24 bits."""
    return reference_ms + (clock_ms - reference_ms + CLOCK_MS // 2) % CLOCK_MS - CLOCK_MS // 2


class LogStream:
    """Turns log packets into messages; take() belongs to one foreign thread. Other threads read the
    counters, which is safe for plain integers."""

    def __init__(self, block: LogBlock, deliver: Callable[[LogMessage], None]) -> None:
        self._block = block
        self._deliver = deliver
        self._last_ms: int | None = None
        self._awaited_since_s = float("-inf")
        self._awaited_since_ms = 0
        self.received = 0
        self.lost = 0
        self.bad = 0

    def take(self, clock_ms: int, values: Values) -> None:
        """Take one packet with its 24-bit time stamp."""
        self.received += 1
        self._awaited_since_s = time.monotonic()
        drone_ms = self._unwrap(clock_ms)
        self._awaited_since_ms = self.drone_ms
        message = self._block.decode(drone_ms, values)
        if message is None:
            self.bad += 1
        else:
            self._deliver(message)

    @property
    def drone_ms(self) -> int:
        """The drone's clock at the latest packet; 0 before the first."""
        return self._last_ms or 0

    def overdue(self, now_s: float, drone_ms: int) -> bool:
        """Whether packets are overdue, by our clock or the drone's; not true twice in a row."""
        waited_s = now_s - self._awaited_since_s
        waited_ms = max(1000 * waited_s, drone_ms - self._awaited_since_ms)
        if waited_s < ANSWER_S or waited_ms < max(OVERDUE_MS, 3 * self._block.period_ms):
            return False
        self._awaited_since_s, self._awaited_since_ms = now_s, drone_ms
        return True

    def _unwrap(self, clock_ms: int) -> int:
        """Extend the 24-bit stamp to a clock that does not wrap; count gaps as lost packets."""
        if self._last_ms is None:
            self._last_ms = clock_ms
            return clock_ms
        step_ms = (clock_ms - self._last_ms) % CLOCK_MS
        if step_ms == 0:
            return self._last_ms
        back_ms = CLOCK_MS - step_ms
        if back_ms < OVERTAKEN_MS:
            self.lost = max(0, self.lost - 1)
            return self._last_ms - back_ms
        if step_ms > CLOCK_MS // 2:  # the drone restarted
            self._last_ms = clock_ms
            return clock_ms
        if step_ms < LONGEST_GAP_MS:
            self.lost += max(0, round(step_ms / self._block.period_ms) - 1)
        self._last_ms += step_ms
        return self._last_ms
