# SPDX-License-Identifier: GPL-3.0-or-later
"""One running log block: counts what comes and what is missing, and dates it."""

from __future__ import annotations

import time
from collections.abc import Callable

from ground.logblocks import LogBlock, Values
from ground.model import LogMessage

CLOCK_MS = 1 << 24  # log packets carry 24 bits of milliseconds
OVERTAKEN_MS = 2000  # so far back: another packet overtook this one, or it came twice
LONGEST_GAP_MS = 60_000  # longer than this is a restart, not a loss
OVERDUE_MS = 600
ANSWER_S = 0.1  # the drone gets so long to answer before it is asked again
RESTART_MS = 1000  # its clock goes back by more only when it starts anew
FASTEST = 1000  # a simulator's seconds a second


def restarted(before_ms: int, now_ms: int, elapsed_s: float) -> bool:
    """Whether a drone whose clock stood there before cannot have come to now_ms by waiting."""
    forward_ms = (now_ms - before_ms) % CLOCK_MS
    if forward_ms > CLOCK_MS // 2:
        return CLOCK_MS - forward_ms > RESTART_MS
    return forward_ms > LONGEST_GAP_MS + FASTEST * 1000 * elapsed_s


def near(clock_ms: int, reference_ms: int) -> int:
    """The time next to the reference that has the same 24 bits."""
    return reference_ms + (clock_ms - reference_ms + CLOCK_MS // 2) % CLOCK_MS - CLOCK_MS // 2


class LogStream:
    """Turns log packets into messages. take() belongs to one foreign thread; counters are read
    by others, which is safe for plain integers."""

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
        """One packet, with the 24-bit time stamp that it carried."""
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
        """The drone's clock at the last packet; 0 before."""
        return self._last_ms or 0

    def overdue(self, now_s: float, drone_ms: int) -> bool:
        """True, once a while, if packets should have come and did not, by our clock or its own."""
        waited_s = now_s - self._awaited_since_s
        waited_ms = max(1000 * waited_s, drone_ms - self._awaited_since_ms)
        if waited_s < ANSWER_S or waited_ms < max(OVERDUE_MS, 3 * self._block.period_ms):
            return False
        self._awaited_since_s, self._awaited_since_ms = now_s, drone_ms
        return True

    def _unwrap(self, clock_ms: int) -> int:
        """Milliseconds that go on where 24 bits wrap; a gap counts as lost packets."""
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
