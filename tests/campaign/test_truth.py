# SPDX-License-Identifier: GPL-3.0-or-later
"""How maps are compared with the truth: a map that is rotated as a whole is fitted first."""

from dataclasses import replace

import numpy as np
import pytest

from ground.map.groundmap import GroundMap
from ground.sim.campaign.explore import Coverage
from ground.sim.campaign.flights import Mission, row_of
from ground.sim.campaign.furniture import pole
from ground.sim.campaign.ghosts import count_ghosts
from ground.sim.campaign.overlay import Overlay, gap_m, lay_over
from ground.sim.campaign.scenes import Scene, draw_scene
from ground.sim.world import World
from ground.sim.worldspec import Motion


@pytest.fixture(scope="module")
def scene() -> Scene:
    return draw_scene("home", np.random.default_rng(3))


@pytest.fixture(scope="module")
def turned(scene: Scene) -> np.ndarray:
    """The outlines of all obstacles, as a drone with a heading error of 8 degrees maps them."""
    outlines = scene.truth.points_m[np.abs(scene.truth.body_gap_m) < 0.04][::3]
    middle = outlines.mean(axis=0)
    return Overlay(np.radians(8.0), middle, np.array([0.1, -0.2])).lifted(outlines)


def test_a_turned_map_is_laid_back(scene: Scene, turned: np.ndarray) -> None:
    off = np.abs(gap_m(turned, scene.truth))
    laid = np.abs(gap_m(lay_over(turned, scene.truth).laid(turned), scene.truth))
    assert np.mean(off > 0.1) > 0.2
    assert np.mean(laid > 0.1) < 0.05


def test_who_has_gone_is_counted_and_walls_are_not(scene: Scene, turned: np.ndarray) -> None:
    free = np.argwhere(scene.reachable() & (scene.truth.body_gap_m > 0.6))
    here, there = (scene.truth.place(free[i]) for i in (0, -1))
    walk = Motion((there,), speed_mps=0.5)
    person = replace(pole("person", 0.2, (0.0, 1.7), 0.5, here), motion=walk, vanishes_s=30.0)
    assert count_ghosts(turned, scene.truth, [person]) == 0
    seen = lay_over(turned, scene.truth).lifted(np.array([here, there]))
    assert count_ghosts(np.vstack([turned, seen]), scene.truth, [person]) == 2
    assert count_ghosts(np.vstack([turned, seen]), scene.truth, []) == 0


def test_coverage_counts_what_was_observed_where_one_can_be(scene: Scene) -> None:
    grid = GroundMap()
    coverage = Coverage(scene, World(scene.spec))
    grid.cell_m = 0.2
    half = 64 * grid.cell_m
    grid.origin = type(grid.origin)(-half, -half)
    assert coverage.of(grid) == 0.0
    grid.states[:, 64:] = 1
    assert 0.0 < coverage.of(grid) < 1.0
    grid.states[:] = 1
    assert coverage.of(grid) == 1.0


def test_an_exploration_is_judged_and_compared() -> None:
    row = row_of(Mission("explore", 104, 2, baseline=(("way.frontier", 2.0),)))
    assert row.cause != "error", row.reason
    assert row.covered is not None and 0.0 < row.covered <= 1.0
    assert row.claimed is not None
    assert row.baseline_s is not None and row.baseline_s > 0.0


def test_a_flight_among_people_is_judged() -> None:
    row = row_of(Mission("moving", 5, 7))
    assert row.cause != "error", row.reason
    assert row.task == "reachable"
    assert row.shortest_m is not None and row.miss_m is not None
