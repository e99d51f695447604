# SPDX-License-Identifier: GPL-3.0-or-later
"""Which sensors of the body are broken, and what a broken Multi-ranger publishes."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ground.sim.model import RANGE_NONE_MM, Ranges

BEYOND_MM: Final = 1500
"""A beam that reports short does so where the true range exceeds this ..."""
SHORT_MM: Final = (300, 1000)
"""... and then reports a random range within these limits."""
SCATTER_MM: Final = (600, 3500)


@dataclass(slots=True)
class Broken:
    """Which sensors fail and how; may be set at any time. Beams are numbered as in ranger.BEAMS."""

    frozen_beams: set[int] = field(default_factory=set)
    dead_beams: set[int] = field(default_factory=set)
    short_beams: set[int] = field(default_factory=set)
    scattered: bool = False
    """Ranges above SCATTER_MM[0] are replaced by random ones within SCATTER_MM."""
    flow: bool = False
    height: bool = False
    positioning: bool = False
    step_m: float = 0.0
    """The downward ranger reads this much less than the true height."""
    runaway_mps2: float = 0.0
    """Acceleration with which the estimated velocity runs away."""


def spoil(measured: Ranges, before: Ranges, broken: Broken, rng: np.random.Generator) -> Ranges:
    """Return what is published instead of the measured ranges; all ranges in millimetres."""

    def published(beam: int) -> int:
        if beam in broken.frozen_beams:
            return before[beam]
        if beam in broken.dead_beams:
            return RANGE_NONE_MM
        if broken.scattered:
            far = measured[beam] > SCATTER_MM[0]
            return int(rng.integers(*SCATTER_MM)) if far else measured[beam]
        if beam in broken.short_beams and measured[beam] > BEYOND_MM:
            return int(rng.integers(*SHORT_MM))
        return measured[beam]

    front, back, left, right, up = map(published, range(len(measured)))
    return front, back, left, right, up
