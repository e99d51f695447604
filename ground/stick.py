# SPDX-License-Identifier: GPL-3.0-or-later
"""The word for flying by hand."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Stick:
    """What a stick wants just now: level velocity and yaw rate of the body, and climb rate.

    Together no more than 4 in m/s and rad/s, else the drone refuses it.
    """

    ahead_mps: float = 0.0
    left_mps: float = 0.0
    yaw_rate_rps: float = 0.0
    climb_mps: float = 0.0


REST = Stick()


@dataclass(frozen=True, slots=True)
class Steer:
    """A stick for the drone; only a refusal is acknowledged, with the sequence."""

    sequence: int
    stick: Stick
