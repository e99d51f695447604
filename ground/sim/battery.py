# SPDX-License-Identifier: GPL-3.0-or-later
"""A 250 mAh cell under load: its voltage sags with thrust, and it lasts for 7 minutes of hovering.

States and levels as the firmware computes them: pm_stm32f4.c, table bat671723HS25C, thresholds of
platform_defaults_cf2.h.
"""

from bisect import bisect_left
from itertools import pairwise
from typing import Final

HOVER_ENDURANCE_S: Final = 420.0
HOVER_SAG_V: Final = 0.4
IDLE_LOAD: Final = 0.02
LOW_V: Final = 3.2
LOW_AFTER_S: Final = 5.0
STATE_BATTERY: Final = 0
STATE_LOW: Final = 3
_LEVELS_V: Final = (3.00, 3.78, 3.83, 3.87, 3.89, 3.92, 3.96, 4.00, 4.04, 4.10)
_REST_CURVE: Final = ((0.0, 3.4), (0.1, 3.6), (0.2, 3.7), (0.5, 3.85), (0.9, 4.1), (1.0, 4.2))


class Battery:
    """Charge 1 is full; load 1 is that of hovering, which empties the cell in endurance_s."""

    def __init__(self, charge: float = 1.0, endurance_s: float = HOVER_ENDURANCE_S) -> None:
        self.charge = charge
        self._endurance_s = endurance_s
        self.voltage_v = _rest_v(charge)
        self.state = STATE_BATTERY
        self.sag_v = 0.0
        """Voltage lost in addition to that under load: a bad contact, a cold or old cell."""
        self._low_s = 0.0

    @property
    def percent(self) -> int:
        """Charge level that the firmware shows, in steps of 10, at most 90."""
        return 10 * min(bisect_left(_LEVELS_V, self.voltage_v), 9)

    def step(self, load: float, elapsed_s: float) -> None:
        drawn = max(load, IDLE_LOAD)
        self.charge = max(0.0, self.charge - drawn * elapsed_s / self._endurance_s)
        target_v = _rest_v(self.charge) - HOVER_SAG_V * drawn - self.sag_v
        self.voltage_v += (target_v - self.voltage_v) * min(1.0, 2.0 * elapsed_s)
        self._low_s = self._low_s + elapsed_s if self.voltage_v < LOW_V else 0.0
        self.state = STATE_LOW if self._low_s > LOW_AFTER_S else STATE_BATTERY


def _rest_v(charge: float) -> float:
    for (c0, v0), (c1, v1) in pairwise(_REST_CURVE):
        if charge <= c1:
            return v0 + (v1 - v0) * (charge - c0) / (c1 - c0)
    return _REST_CURVE[-1][1]
