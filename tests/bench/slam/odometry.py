# SPDX-License-Identifier: GPL-3.0-or-later
"""Odometry of a whole flight at once, with the errors of the simulator's drift profiles."""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import lfilter

from ground.sim.profiles import PROFILES
from tests.bench.slam.rooms import Array
from tests.bench.slam.routes import TICK_S


def _wander(ticks: int, sigma: float, tau_s: float, rng: np.random.Generator) -> Array:
    """As ground.sim.noise.Wander: starts in its steady state."""
    keep = math.exp(-TICK_S / tau_s)
    kicks = rng.standard_normal(ticks) * sigma * math.sqrt(1.0 - keep * keep)
    values: Array = lfilter([1.0], [1.0, -keep], kicks, zi=[keep * sigma * rng.standard_normal()])[
        0
    ]
    return values


def body_steps(poses: Array) -> Array:
    """What the body moved and turned in each tick, in its own axes."""
    moved = np.diff(poses, axis=0)
    c, s = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    return np.stack(
        [c * moved[:, 0] + s * moved[:, 1], c * moved[:, 1] - s * moved[:, 0], moved[:, 2]], axis=1
    )


def add_up(steps: Array, start: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Array:
    """Integrate steps to poses."""
    yaw = start[2] + np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    c, s = np.cos(yaw[:-1]), np.sin(yaw[:-1])
    x = start[0] + np.concatenate([[0.0], np.cumsum(c * steps[:, 0] - s * steps[:, 1])])
    y = start[1] + np.concatenate([[0.0], np.cumsum(s * steps[:, 0] + c * steps[:, 1])])
    return np.stack([x, y, yaw], axis=1)


def drifting(poses: Array, profile: str, rng: np.random.Generator) -> Array:
    """Poses as odometry reports them, its frame where the flight begins."""
    errors = PROFILES[profile]
    steps = body_steps(poses)
    ticks = len(steps)
    scale = rng.uniform(*errors.scale)
    if errors.scale_either_sign:
        scale *= rng.choice((-1.0, 1.0))
    skew = errors.anisotropy * rng.standard_normal()
    for column, own in ((0, scale + skew), (1, scale - skew)):
        steps[:, column] *= 1.0 + own + _wander(ticks, errors.scale_wander, 12.0, rng)
        steps[:, column] += _wander(ticks, errors.velocity_bias_mps, 10.0, rng) * TICK_S
        walk_m = errors.walk_m_per_root_s * math.sqrt(TICK_S)
        steps[:, column] += walk_m * rng.standard_normal(ticks)
    bias_rps = math.radians(rng.uniform(*errors.yaw_bias_dps) * rng.choice((-1.0, 1.0)))
    turning_rps = bias_rps + _wander(ticks, 0.25 * abs(bias_rps), 60.0, rng)
    steps[:, 2] *= 1.0 + errors.gyro_scale * rng.standard_normal()
    steps[:, 2] += turning_rps * TICK_S
    yaw_walk_rad = math.radians(errors.yaw_walk_dps) * math.sqrt(TICK_S)
    steps[:, 2] += yaw_walk_rad * rng.standard_normal(ticks)
    return add_up(steps)
