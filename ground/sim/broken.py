# SPDX-License-Identifier: GPL-3.0-or-later
"""What of the body's sensors is broken, and what a broken Multi-ranger publishes."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ground.sim.model import RANGE_NONE_MM, Ranges

BEYOND_MM: Final = 1500
"""A sensor that reports short does so from here on ..."""
SHORT_MM: Final = (300, 1000)
"""... with anything between these."""
SCATTER_MM: Final = (600, 3500)


@dataclass(slots=True)
class Broken:
    """Set from outside at any time; beams by their number."""

    frozen_beams: set[int] = field(default_factory=set)
    dead_beams: set[int] = field(default_factory=set)
    short_beams: set[int] = field(default_factory=set)
    scattered: bool = False
    """What is not near is reported anywhere."""
    flow: bool = False
    height: bool = False
    positioning: bool = False
    step_m: float = 0.0
    """What lies below is so much nearer than the floor, for the ranger that looks down."""
    runaway_mps2: float = 0.0
    """The estimated velocity runs away like this."""


def spoil(measured: Ranges, before: Ranges, broken: Broken, rng: np.random.Generator) -> Ranges:
    """What is published in place of these ranges in millimetres."""

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
