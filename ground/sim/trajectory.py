# SPDX-License-Identifier: GPL-3.0-or-later
"""One piece of a high-level trajectory, from a moving state to rest at a goal."""

from dataclasses import dataclass
from math import pi, remainder

AXES = 4
Vector = tuple[float, float, float, float]
"""x, y, z [m] and yaw [rad], or their derivatives."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Position, velocity and acceleration of all axes at one time."""

    position: Vector
    velocity: Vector = (0.0, 0.0, 0.0, 0.0)
    acceleration: Vector = (0.0, 0.0, 0.0, 0.0)


class Trajectory:
    """A 7th order polynomial without jerk at both ends, as the firmware's planner makes it."""

    def __init__(self, begin: Motion, goal: Vector, begin_s: float, duration_s: float) -> None:
        self.begin_s = begin_s
        self.duration_s = duration_s
        self._coefficients = [
            _septic(
                begin.position[axis],
                begin.velocity[axis] * duration_s,
                begin.acceleration[axis] * duration_s**2 / 2,
                goal[axis],
            )
            for axis in range(AXES)
        ]

    def finished(self, time_s: float) -> bool:
        """Whether the end is reached."""
        return time_s - self.begin_s >= self.duration_s

    def at(self, time_s: float) -> Motion:
        """The motion at a time; after the end, rest at the goal."""
        part = min(max((time_s - self.begin_s) / self.duration_s, 0.0), 1.0)
        values = [_evaluate(c, part) for c in self._coefficients]
        x, y, z, yaw = values
        first, second = 1 / self.duration_s, 1 / self.duration_s**2
        return Motion(
            (x[0], y[0], z[0], yaw[0]),
            (x[1] * first, y[1] * first, z[1] * first, yaw[1] * first),
            (x[2] * second, y[2] * second, z[2] * second, yaw[2] * second),
        )


class Straight(Trajectory):
    """Constant velocity from start to goal."""

    def __init__(self, begin: Motion, goal: Vector, begin_s: float, duration_s: float) -> None:
        super().__init__(begin, goal, begin_s, duration_s)
        self._coefficients = [
            (begin.position[axis], goal[axis] - begin.position[axis], 0, 0, 0, 0, 0, 0)
            for axis in range(AXES)
        ]


def nearest_turn(from_rad: float, to_rad: float) -> float:
    """The angle equal to to_rad that is nearest to from_rad."""
    return from_rad + remainder(to_rad - from_rad, 2 * pi)


_Coefficients = tuple[float, float, float, float, float, float, float, float]


def _septic(d0: float, d1: float, d2: float, goal: float) -> _Coefficients:
    """Coefficients over [0, 1] that end at the goal without velocity, acceleration and jerk."""
    r0 = goal - d0 - d1 - d2
    r1 = -d1 - 2 * d2
    r2 = -2 * d2
    return (
        d0,
        d1,
        d2,
        0.0,
        35 * r0 - 15 * r1 + 2.5 * r2,
        -84 * r0 + 39 * r1 - 7 * r2,
        70 * r0 - 34 * r1 + 6.5 * r2,
        -20 * r0 + 10 * r1 - 2 * r2,
    )


def _evaluate(coefficients: _Coefficients, part: float) -> tuple[float, float, float]:
    """Value and first two derivatives by Horner's rule."""
    value = first = second = 0.0
    for coefficient in reversed(coefficients):
        second = second * part + 2 * first
        first = first * part + value
        value = value * part + coefficient
    return value, first, second
