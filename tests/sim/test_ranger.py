# SPDX-License-Identifier: GPL-3.0-or-later
"""The Multi-ranger's cones: what they see, how accurately, and what they miss."""

import math
from pathlib import Path

import numpy as np
import pytest

from ground.sim.model import RANGE_NONE_MM
from ground.sim.ranger import BEAMS, FALSE_SHORT, SENSOR_OFFSET_M, MultiRanger
from ground.sim.vehicle import Vehicle
from ground.sim.world import World, load_world
from tests.sim.plants import OPEN_FLOOR, in_the_air, wall_at, world_from

FRONT, BACK, LEFT, RIGHT, UP = range(len(BEAMS))


def sets(
    world: World, body: Vehicle, count: int = 400, false_short: float = FALSE_SHORT
) -> np.ndarray:
    """`count` measured sets as an array (count x 5), NaN without return."""
    ranger = MultiRanger(world, np.random.default_rng(3), false_short)
    values = np.array([ranger.measure(body) for _ in range(count)], float)
    return np.where(values == RANGE_NONE_MM, np.nan, values) / 1000.0


def test_ranges_are_the_true_distances_within_noise() -> None:
    seen = sets(load_world("empty"), in_the_air(1.25, 2.5))
    for beam, true_m in ((BACK, 1.25), (LEFT, 2.5), (RIGHT, 2.5), (UP, 1.97)):
        expected_m = true_m - SENSOR_OFFSET_M
        values = seen[:, beam][np.abs(seen[:, beam] - expected_m) < 0.2]
        assert len(values) > 0.9 * len(seen)
        assert np.mean(values) == pytest.approx(expected_m, rel=0.01)
        assert 0.008 < np.std(values) / expected_m < 0.022


@pytest.mark.parametrize(
    ("distance_m", "reflectivity", "low", "high"),
    [
        (1.0, 0.88, 0.97, 1.0),
        (2.5, 0.88, 0.95, 1.0),
        (3.9, 0.88, 0.2, 0.8),
        (1.2, 0.17, 0.9, 1.0),
        (2.5, 0.17, 0.0, 0.1),
    ],
)
def test_far_and_dark_walls_are_missed(
    tmp_path: Path, distance_m: float, reflectivity: float, low: float, high: float
) -> None:
    world = wall_at(tmp_path, distance_m, f"reflectivity = {reflectivity}")
    found = np.mean(np.isfinite(sets(world, in_the_air())[:, FRONT]))
    assert low <= found <= high


def test_slanting_walls_are_missed_sooner_and_seem_nearer(tmp_path: Path) -> None:
    world, slant_rad = wall_at(tmp_path, 2.0), math.radians(45.0)
    square, slanting = (sets(world, in_the_air(yaw_rad=turn))[:, FRONT] for turn in (0, slant_rad))
    assert np.mean(np.isfinite(slanting)) < 0.5 < 0.95 < np.mean(np.isfinite(square))
    assert 2.0 < np.nanmedian(slanting) < 0.95 * 2.0 / math.cos(slant_rad)


def test_something_thin_within_the_cone_is_seen_off_the_axis(tmp_path: Path) -> None:
    post = "[[disc]]\ncenter = [1.0, 0.12]\nradius_m = 0.08\nheight_m = 2\n"
    world = world_from(tmp_path, OPEN_FLOOR + post)
    assert np.nanmedian(sets(world, in_the_air())[:, FRONT]) == pytest.approx(0.92, abs=0.06)


def test_the_floor_is_seen_only_when_tilted_towards_it(tmp_path: Path) -> None:
    world = world_from(tmp_path, OPEN_FLOOR)
    level, nose_down = in_the_air(), in_the_air()
    nose_down.pitch_rad = math.radians(-25.0)
    assert np.mean(np.isfinite(sets(world, level)[:, FRONT])) < 0.02
    tilted = sets(world, nose_down)
    assert np.mean(np.isfinite(tilted[:, FRONT])) > 0.9
    assert 0.9 < np.nanmedian(tilted[:, FRONT]) < 1.7
    assert np.mean(np.isfinite(tilted[:, BACK])) < 0.02


def test_sometimes_a_range_is_missing_or_far_too_short(tmp_path: Path) -> None:
    seen = sets(wall_at(tmp_path, 2.0), in_the_air(), 4000)[:, FRONT]
    assert 0.0 < np.mean(np.isnan(seen)) < 0.02
    assert 0.0005 < np.mean(seen < 1.7) < 0.01


def test_a_fifth_of_the_echoes_can_be_false_and_short(tmp_path: Path) -> None:
    seen = sets(wall_at(tmp_path, 2.0), in_the_air(), false_short=0.2)[:, FRONT]
    assert 0.1 < np.mean(seen < 1.7) < 0.25
    assert np.nanmedian(seen) == pytest.approx(2.0, abs=0.1)
