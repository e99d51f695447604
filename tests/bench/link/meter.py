# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures a link: map packets and bytes, and when the ground's map equalled the drone's."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ground.link.protocol import Link
from ground.map.groundmap import GroundMap
from ground.model import Incoming, LinkChange, LinkState, LinkStats, MapPacket
from ground.requests import Outgoing
from ground.station.station import Station

Cells = NDArray[np.uint8]
PACKET_BYTES: Final = 1 + 4 + 26
"""CRTP header, block and time, the piece."""
_LIMIT_S: Final = 120.0


class Metered:
    """A link that notes the drone time of every map packet and our time of every change."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self.pieces_ms: list[int] = []
        self.changes: list[tuple[float, LinkState]] = []

    @property
    def stats(self) -> LinkStats:
        """Counters of the link."""
        return self._link.stats

    async def open(self) -> None:
        """Connect."""
        await self._link.open()

    async def close(self) -> None:
        """Let go."""
        await self._link.close()

    def send(self, message: Outgoing) -> None:
        """Hand over."""
        self._link.send(message)

    async def messages(self) -> AsyncIterator[Incoming]:
        """What comes in."""
        async for message in self._link.messages():
            if isinstance(message, MapPacket):
                self.pieces_ms.append(message.drone_ms)
            elif isinstance(message, LinkChange):
                self.changes.append((time.monotonic(), message.state))
            yield message

    def since(self, begin_s: float, state: LinkState) -> float | None:
        """Seconds from a time until the link entered a state."""
        return next(
            (at - begin_s for at, now in self.changes if at >= begin_s and now is state), None
        )


class Snapshots:
    """The ground's map after each change, by the drone's clock."""

    def __init__(self, station: Station) -> None:
        self._station = station
        self._revision = -1
        self.taken: list[tuple[int, Cells]] = []

    async def run(self) -> None:
        """Note snapshots until cancelled."""
        while True:
            grid = self._station.picture.map
            if grid.revision != self._revision:
                self._revision = grid.revision
                self.taken.append((self._station.picture.drone_ms, grid.states.copy()))
            await asyncio.sleep(0.02)

    def equal_from(self, truth: Cells) -> int | None:
        """The drone time from which the ground's map equalled this one."""
        since = None
        for at_ms, states in self.taken:
            if not np.array_equal(states, truth):
                since = None
            elif since is None:
                since = at_ms
        return since


async def until(condition: Callable[[], bool], limit_s: float = _LIMIT_S) -> bool:
    """Wait for a condition. @return False if it never held"""
    end_s = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end_s:
            return False
        await asyncio.sleep(0.005)
    return True


def noise_map(like: GroundMap, seed: int) -> GroundMap:
    """A map that does not compress: every cell is random, on the same grid."""
    grid = GroundMap()
    grid.cell_m, grid.origin = like.cell_m, like.origin
    grid.states[:] = np.random.default_rng(seed).integers(0, 3, grid.states.shape)
    return grid
