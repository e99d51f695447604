# SPDX-License-Identifier: GPL-3.0-or-later
"""Wall directions: what a beam's line tells, and whether directions are used at all."""

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
        """Move on by 4 cm; return the direction of the line that ended, if one did."""
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
    """Feed these directions in turn, the last after the yaw went wrong."""
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


def known(walls: CData, filter_: CData, angle_rad: float) -> float | None:
    """The direction that a wall's normal is matched to, if a known wall is near."""
    normal = ffi.new("vec2_t *", (math.cos(angle_rad), math.sin(angle_rad)))
    near: bool = lib.slam_walls_know(walls, filter_, normal)
    return math.atan2(normal.y, normal.x) if near else None


@pytest.mark.parametrize("quarters", [-1, 0, 1, 2])
def test_a_wall_drawn_askew_has_the_nearest_known_direction(quarters: int) -> None:
    other = 0.2 + math.radians(30.0)
    walls, filter_ = tell([0.2, other] * 4, 0.0)
    for of, direction in enumerate(filter_.direction_rad):
        outwards = math.radians(12.0 if direction > filter_.direction_rad[1 - of] else -12.0)
        for askew in (0.0, outwards):
            true = direction + quarters * QUARTER
            found = known(walls, filter_, true + askew)
            assert found is not None
            assert math.remainder(found - true, math.tau) == pytest.approx(0.0, abs=1e-4)


def test_a_wall_far_from_known_directions_keeps_its_own() -> None:
    walls, filter_ = tell([0.2] * 6, 0.0)
    assert known(walls, filter_, 0.2 + math.radians(24.0)) is not None
    assert known(walls, filter_, 0.2 + math.radians(45.0)) is None
    filter_of_two = tell([0.2] * 2, 0.0)
    assert known(*filter_of_two, 0.2) is None
    walls.agreeing, walls.differing = 10, 20
    assert known(walls, filter_, 0.2) is None


def pull_m(slam: CData, bent_m: float) -> float:
    """How far a match of one range ahead moves the pose; the wall's last 0.4 m are displaced."""
    grid = ffi.new("grid_t *")
    config = ffi.new("grid_config_t *", lib.grid_config_default())
    lib.grid_init(grid, config, (0.0, 0.0), 0.05)
    for y_m in np.arange(-1.8, 0.2, 0.025):
        frame = ffi.new("scan_frame_t *", {"hit": 1, "range_m": [0.5]})
        for _ in range(3):
            lib.grid_insert(grid, frame, (0.5 + (bent_m if y_m > -0.2 else 0.0), y_m, 0.0))
    slam.closed = 1
    slam.frames[0].hit, slam.frames[0].range_m[0] = 1, 1.0
    match = ffi.new("slam_match_t *")
    lib.slam_match(slam, grid, (bent_m, 0.0, 0.0), match)
    assert match.matched == 1
    pulled: float = match.gradient[0] / match.hessian[0][0]
    return pulled


@pytest.mark.parametrize("bent_m", [-0.05, 0.05])
def test_a_wall_of_known_direction_is_straight(bent_m: float) -> None:
    config = ffi.new("slam_config_t *", lib.slam_config_default())
    slam = ffi.new("slam_t *")
    lib.slam_init(slam, config, True, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    alone = pull_m(slam, bent_m)
    slam.walls, slam.filter = (of[0] for of in tell([0.0] * 6, 0.0))
    held = pull_m(slam, bent_m)
    assert abs(alone) < 0.02
    assert math.copysign(1.0, held) == -math.copysign(1.0, bent_m)
    assert abs(held) > abs(alone) + 0.01
