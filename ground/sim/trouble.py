# SPDX-License-Identifier: GPL-3.0-or-later
"""A bad link between drone and client, which loses, duplicates and reorders datagrams."""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import Final


@dataclass(frozen=True, slots=True)
class TroubleSpec:
    """Probabilities for each datagram, the same in both directions."""

    loss: float = 0.0
    duplication: float = 0.0
    reorder: float = 0.0


NO_TROUBLE: Final = TroubleSpec()


class Trouble:
    """One direction of a client's link."""

    def __init__(self, spec: TroubleSpec, random: Random) -> None:
        self.lost = 0
        self._random = random
        self._held: bytes | None = None
        self.spec = spec

    def carry(self, datagram: bytes) -> Iterator[bytes]:
        """Yield what arrives when this datagram is sent, in order."""
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
