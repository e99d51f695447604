# SPDX-License-Identifier: GPL-3.0-or-later
"""Profiles of how large the errors of the firmware's estimate are, by name.

"real" follows flights with motion capture: a scale of 2 to 12 %, a yaw of 0.01 to 0.1 deg/s.
"""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Profile:
    """A profile; from pairs, which are ranges, each flight draws a value once."""

    scale: tuple[float, float]
    scale_either_sign: bool
    anisotropy: float
    scale_wander: float
    yaw_bias_dps: tuple[float, float]
    gyro_scale: float = 0.004
    yaw_walk_dps: float = 0.03
    velocity_bias_mps: float = 0.008
    walk_m_per_root_s: float = 0.006
    velocity_noise_mps: float = 0.01
    tilt_error_deg: float = 0.3


PROFILES: Final = {
    "real": Profile((0.02, 0.12), False, 0.02, 0.035, (0.01, 0.1)),
    "low": Profile((0.01, 0.03), True, 0.0, 0.01, (0.02, 0.1)),
    "hard": Profile((0.02, 0.04), True, 0.0, 0.01, (0.1, 0.5)),
    "perfect": Profile((0.0, 0.0), False, 0.0, 0.0, (0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
}
