# SPDX-License-Identifier: GPL-3.0-or-later
"""The present rate of packets over the link, and the share that is lost."""

from __future__ import annotations

from collections import deque

from ground.model import LinkStats

WINDOW_S = 4.0
SAMPLE_S = 0.25


class LinkRate:
    """Log packets over the last WINDOW_S: how many arrive per second, and the share lost."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, int, int]] = deque()

    def look(self, stats: LinkStats, now_s: float) -> None:
        """Take a sample; more than one per SAMPLE_S is ignored, as several pages may ask."""
        if not self._samples or now_s - self._samples[-1][0] >= SAMPLE_S:
            self._samples.append((now_s, stats.log_packets, stats.lost_packets))
            while len(self._samples) > 2 and now_s - self._samples[0][0] > WINDOW_S:
                self._samples.popleft()

    @property
    def per_s(self) -> float:
        """Packets received per second."""
        if len(self._samples) < 2:
            return 0.0
        (then_s, came, _), (now_s, comes, _) = self._samples[0], self._samples[-1]
        return max(0, comes - came) / (now_s - then_s)

    @property
    def loss(self) -> float:
        """Share of packets lost, from 0 to 1."""
        if len(self._samples) < 2:
            return 0.0
        (_, came, was), (_, comes, lost) = self._samples[0], self._samples[-1]
        sent = comes - came + lost - was
        return min(1.0, max(0, lost - was) / sent) if sent > 0 else 0.0
