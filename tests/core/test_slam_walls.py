# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions of walls: what a beam's line says, and whether directions are listened to at all."""

import math

import numpy as np
import pytest

from ground.core import CData, ffi, lib

LEFT: int = lib.SCAN_LEFT
QUARTER = math.pi / 2


class Beam:
    """The left beam of a drone that flies along +x, a set every 100 ms."""

    def __init__(self) -> None:
        self.walls = ffi.new("slam_walls_t *")
        lib.slam_walls_init(self.walls)
        self.time_ms = 0
        self.x_m = 0.0

    def see(self, range_m: float | None, yaw_rad: float = 0.0) -> CData | None:
        """Go on 4 cm; the direction of the line that ended, if any did."""
        self.time_ms += 100
        self.x_m += 0.04
        frame = ffi.new("scan_frame_t *", {"time_ms": self.time_ms})
        if range_m is not None:
            frame.hit = 1 << LEFT
            frame.range_m[LEFT] = range_m
        bearing = ffi.new("slam_bearing_t *")
        pose = (self.x_m, 0.0, yaw_rad)
        return bearing if lib.slam_walls_add(self.walls, frame, pose, LEFT, bearing) else None


@pytest.mark.parametrize("tilt_deg", [-25.0, -3.0, 0.0, 10.0, 30.0])
def test_a_line_shows_its_wall(tilt_deg: float) -> None:
    rng = np.random.default_rng(3)
    beam = Beam()
    slope = math.tan(math.radians(tilt_deg))
    for _ in range(30):
        assert beam.see(1.5 + slope * (beam.x_m + 0.04) + rng.normal(0.0, 0.01)) is None
    found = beam.see(None)
    assert found is not None
    off = math.remainder(found.angle_rad - math.radians(tilt_deg), math.pi)
    assert abs(off) < 3.0 * found.sd_rad
    assert found.sd_rad < math.radians(1.0)
    assert abs(found.s_per_m) == pytest.approx(2.5 * math.cos(math.radians(tilt_deg)), rel=0.1)


def test_what_is_too_short_oblique_or_round_says_nothing() -> None:
    short = Beam()
    assert [short.see(1.5) for _ in range(10)] == [None] * 10
    assert short.see(None) is None
    oblique = Beam()
    slope = math.tan(math.radians(50.0))
    assert [oblique.see(1.0 + slope * oblique.x_m) for _ in range(30)] == [None] * 30
    assert oblique.see(None) is None
    bowl = Beam()
    ends = [bowl.see(1.0 + 0.3 * (bowl.x_m - 0.6) ** 2) for _ in range(30)]
    assert [found for found in ends if found] == []


def test_a_step_and_a_turn_end_a_line() -> None:
    beam = Beam()
    for _ in range(30):
        beam.see(1.5)
    assert beam.see(2.4) is not None
    for _ in range(29):
        beam.see(2.4)
    assert beam.see(2.4, yaw_rad=0.4) is not None


def tell(angles_rad: list[float], yaw_error_rad: float) -> tuple[CData, CData]:
    """These directions one after the other, the last after the yaw went wrong."""
    config = lib.slam_config_default()
    noise = ffi.new("slam_noise_t *", config.noise)
    walls, filter_ = ffi.new("slam_walls_t *"), ffi.new("slam_filter_t *")
    lib.slam_walls_init(walls)
    lib.slam_filter_init(filter_, noise, (0.0, 0.0, 0.0))
    for i, angle in enumerate(angles_rad):
        if i == len(angles_rad) - 1:
            filter_.pose.yaw_rad += yaw_error_rad
            lib.slam_filter_grow(filter_, noise, (0.0, 0.0), 0.0, 30.0)
        lib.slam_walls_tell(walls, filter_, (angle, math.radians(0.5), 0.0))
    return walls, filter_


def test_walls_at_right_angles_are_one_direction_and_hold_the_yaw() -> None:
    walls, filter_ = tell([0.2, 0.2 + QUARTER, 0.2, 0.2 - QUARTER, 0.2], math.radians(3.0))
    assert list(walls.found) == [5, 0]
    assert abs(filter_.pose.yaw_rad) < math.radians(0.7)


def test_walls_off_square_are_two_directions() -> None:
    other = 0.2 + math.radians(14.0)
    walls, filter_ = tell([0.2, other, 0.2, other, 0.2, other], math.radians(2.0))
    assert min(walls.found) >= 2
    assert abs(filter_.pose.yaw_rad) < math.radians(0.7)


def test_clutter_is_not_listened_to() -> None:
    rng = np.random.default_rng(5)
    unmoved = 0
    for _ in range(20):
        angles = [float(angle) for angle in rng.uniform(-math.pi, math.pi, 25)]
        walls, filter_ = tell(angles, 0.0)
        unmoved += walls.agreeing < walls.differing
        assert abs(filter_.pose.yaw_rad) < math.radians(6.0)
    assert unmoved >= 18
