# SPDX-License-Identifier: GPL-3.0-or-later
"""The seam between the station and whatever carries its messages: a radio, a recording, a test."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Protocol

from ground.model import Incoming, LinkStats, Outgoing


class Link(Protocol):
    """One drone. All methods belong to the asyncio loop that opened it."""

    @property
    def stats(self) -> LinkStats:
        """Counters since open()."""

    async def open(self) -> None:
        """Connect; returns when messages can flow. Raises LinkUnavailable, ProtocolMismatch."""

    async def close(self) -> None:
        """Let go; a second call does nothing."""

    def send(self, message: Outgoing) -> None:
        """Hand over without waiting. Nothing says that it arrived: who needs to know repeats.

        Only SetParameter is repeated by the link itself, in order, until the drone answers.
        """

    def messages(self) -> AsyncIterator[Incoming]:
        """What comes in, until the link is closed or lost. One reader."""
