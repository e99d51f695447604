# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface between the station and what carries its messages: radio, recording or test."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Protocol

from ground.model import Incoming, LinkStats
from ground.requests import Outgoing


class Link(Protocol):
    """The link to one drone; all methods belong to the asyncio loop that opened it."""

    @property
    def stats(self) -> LinkStats:
        """Counters since open()."""

    async def open(self) -> None:
        """Connect; return when messages can flow. Raises LinkUnavailable or ProtocolMismatch."""

    async def close(self) -> None:
        """Close; a second call does nothing."""

    def send(self, message: Outgoing) -> None:
        """Send without waiting. There is no receipt: callers that need one repeat until answered.

        Only SetParameter is repeated by the link itself, in order, until the drone answers.
        """

    def messages(self) -> AsyncIterator[Incoming]:
        """All incoming messages until the link is closed or lost; for one reader."""
