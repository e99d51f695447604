# SPDX-License-Identifier: GPL-3.0-or-later
"""A bad way between drone and client: datagrams get lost, doubled and overtake each other."""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import Final


@dataclass(frozen=True, slots=True)
class TroubleSpec:
    """Fractions of all datagrams, each way."""

    loss: float = 0.0
    duplication: float = 0.0
    reorder: float = 0.0


NO_TROUBLE: Final = TroubleSpec()


class Trouble:
    """One direction of one client's way."""

    def __init__(self, spec: TroubleSpec, random: Random) -> None:
        self.lost = 0
        self._random = random
        self._held: bytes | None = None
        self.spec = spec

    def carry(self, datagram: bytes) -> Iterator[bytes]:
        """What arrives when this datagram is sent, in order."""
        if self.spec == NO_TROUBLE and self._held is None:
            yield datagram
            return
        if self._random.random() < self.spec.loss:
            self.lost += 1
            return
        if self._held is None and self._random.random() < self.spec.reorder:
            self._held = datagram
            return
        yield datagram
        if self._held is not None:
            held, self._held = self._held, None
            yield held
        if self._random.random() < self.spec.duplication:
            yield datagram
