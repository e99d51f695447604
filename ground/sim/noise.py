# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeded noise as plain floats; NumPy draws blocks, from which a hot loop takes single values."""

import math
from typing import Final

import numpy as np

_BLOCK: Final = 4096


class Noise:
    """Standard normal random numbers from one generator."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._block: list[float] = []

    def normal(self) -> float:
        if not self._block:
            self._block = self._rng.standard_normal(_BLOCK).tolist()
        return self._block.pop()


class Wander:
    """A value that wanders about zero with standard deviation sigma and correlation time tau_s.

    An Ornstein-Uhlenbeck process, exact for the fixed step; it starts in its steady state.
    """

    def __init__(self, noise: Noise, sigma: float, tau_s: float, step_s: float) -> None:
        self._noise = noise
        self._keep = math.exp(-step_s / tau_s)
        self._kick = sigma * math.sqrt(1.0 - self._keep * self._keep)
        self.value = sigma * noise.normal()

    def step(self) -> float:
        self.value = self._keep * self.value + self._kick * self._noise.normal()
        return self.value
