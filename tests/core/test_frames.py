# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimator, odometry and map frames: a correction of the estimate does not move the map pose."""

import cmath
import math

import pytest

from ground.core import CData, ffi, lib
from tests.core.room import Flight, new_config

SLAM, SLAM_ESTIMATOR = lib.NAV_SLAM_MAP, lib.NAV_SLAM_ESTIMATOR
LIGHTHOUSE = lib.NAV_POSITIONING_LIGHTHOUSE
SOURCE_LIGHTHOUSE = lib.NAV_SOURCE_LIGHTHOUSE


def airborne(slam: int = SLAM_ESTIMATOR, positioning: int = 0) -> Flight:
    """A drone that has been exploring for some seconds."""
    flight = Flight(cfg=new_config(slam=slam, watch_rad=0.0))
    flight.input.positioning = positioning
    flight.run_for(1.5)
    assert flight.command(lib.MISSION_CMD_EXPLORE) == lib.MISSION_OK
    flight.run_for(6.0)
    return flight


def pull(flight: Flight, off: complex, turned_rad: float = 0.0) -> None:
    """Move the estimate by this much here; the drone itself does not move."""
    x, y, _ = flight.odometry()
    flight.turned_rad += turned_rad
    here = cmath.rect(1.0, flight.turned_rad) * complex(flight.x_m, flight.y_m)
    flight.shift = complex(x, y) + off - here


def place(flight: Flight) -> complex:
    return complex(flight.nav.pose.x_m, flight.nav.pose.y_m)


def error_m(flight: Flight) -> float:
    return abs(place(flight) - complex(flight.x_m, flight.y_m))


def keep_looking(flight: Flight) -> None:
    """One tick of looking; a drone at rest has nothing to match."""
    flight.step()
    if flight.state == lib.MISSION_HOVER:
        flight.command(lib.MISSION_CMD_SCAN)


def fixed(flight: Flight) -> CData:
    """Fly until there is a correction for the estimator."""
    fix = ffi.new("nav_fix_t *")
    for _ in range(500):
        keep_looking(flight)
        if lib.nav_take_fix(flight.nav, fix):
            return fix
    raise AssertionError("never a match")


def test_what_the_estimator_was_told_is_not_motion() -> None:
    """Whether or not the estimate is moved by decimetres, the flight is the same."""
    pulled, left_alone = airborne(), airborne()
    for _ in range(5):
        fixed(pulled)
        pull(pulled, 0.07 + 0.04j, 0.03)
        fixed(left_alone)
    assert abs(pulled.shift) > 0.3  # the estimate is far away by now
    assert pulled.time_ms == left_alone.time_ms
    assert abs(place(pulled) - place(left_alone)) < 1e-4
    assert pulled.nav.pose.yaw_rad == pytest.approx(left_alone.nav.pose.yaw_rad, abs=1e-4)


def test_the_same_pull_untold_is_motion() -> None:
    """So the test above is able to fail."""
    flight = airborne(SLAM)
    before = error_m(flight)
    pull(flight, 0.3 + 0.0j)
    flight.step()
    assert error_m(flight) - before > 0.2


def test_a_fix_is_the_way_from_the_estimate_to_the_map() -> None:
    flight = airborne()
    fixed(flight)
    pull(flight, 0.1 + 0.2j, 0.1)
    fix = fixed(flight)
    x, y, yaw = flight.odometry()
    assert (fix.estimate.x_m, fix.estimate.y_m) == pytest.approx((x, y), abs=0.02)
    assert fix.estimate.yaw_rad == pytest.approx(yaw, abs=0.02)
    aim = complex(fix.estimate.x_m + fix.off_m.x, fix.estimate.y_m + fix.off_m.y)
    assert abs(aim - place(flight)) < 0.02
    assert fix.off_rad == pytest.approx(-0.1, abs=0.05)
    assert 0.005 < fix.sd_m < 0.3 and 0.001 < fix.sd_rad < 0.1


def test_there_is_nothing_to_tell_in_the_other_modes() -> None:
    flight = airborne(SLAM)
    for _ in range(300):
        flight.step()
        assert not lib.nav_take_fix(flight.nav, ffi.new("nav_fix_t *"))


def test_a_jump_is_a_fault_even_when_a_pull_is_expected() -> None:
    flight = airborne()
    fixed(flight)
    pull(flight, 0.6 + 0.0j)
    flight.step()
    assert flight.nav.mission.fault == lib.MISSION_ESTIMATOR


def test_slam_stands_aside_and_comes_back() -> None:
    flight = airborne(SLAM)
    assert flight.nav.slam.enabled
    flight.input.positioning = LIGHTHOUSE
    flight.run_for(0.5)
    assert flight.nav.slam.enabled, "not at the first glance"
    flight.run_for(0.7)
    before = place(flight)
    assert not flight.nav.slam.enabled
    assert lib.nav_source(flight.nav) == SOURCE_LIGHTHOUSE
    flight.input.positioning = 0
    flight.step()
    assert flight.nav.slam.enabled
    assert lib.nav_source(flight.nav) == SLAM
    assert abs(place(flight) - before) < 0.02


def test_positioning_that_comes_back_pulls_before_it_says_so() -> None:
    """The estimate drifts without positions and then jumps back; the map pose does neither."""
    flight = airborne(SLAM, LIGHTHOUSE)
    flight.input.positioning = 0
    for _ in range(600):
        keep_looking(flight)
        flight.shift += 0.0005
    before = error_m(flight)
    for off in (-0.2, -0.09, -0.01):
        pull(flight, off)
        flight.step()
    assert error_m(flight) == pytest.approx(before, abs=0.03)
    flight.input.positioning = LIGHTHOUSE
    flight.run_for(2.0)
    assert error_m(flight) < 0.05
    assert flight.nav.mission.fault == lib.MISSION_OK


def test_on_the_ground_only_the_gyro_turns_the_drone() -> None:
    flight = airborne(SLAM)
    flight.command(lib.MISSION_CMD_LAND)
    flight.run_until(lib.MISSION_IDLE)
    flight.run_for(1.0)
    before, yaw_rad = place(flight), flight.nav.pose.yaw_rad
    for _ in range(100):
        pull(flight, 0.002 + 0.001j, 0.01)
        flight.step()
    assert abs(place(flight) - before) < 1e-3
    assert flight.nav.pose.yaw_rad == pytest.approx(yaw_rad, abs=1e-3)
    assert math.isfinite(flight.nav.pose.yaw_rad)
