# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawn worlds are what they claim: door widths, room to start, reachability of goals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ground.core import GRID_SIDE_CELLS
from ground.sim.campaign import moving
from ground.sim.campaign.goto import BODY_M, IMPOSSIBLE, draw_task
from ground.sim.campaign.layout import DOOR_M, Layout, Rect, office
from ground.sim.campaign.scenes import CLEARANCE_M, START_GAP_M, STYLES, Scene, draw_scene
from ground.sim.campaign.truth import STEP_M, TrueMap, flood, length_m
from ground.sim.footprints import Footprints
from ground.sim.worldfile import read_world
from ground.sim.worldtext import world_text
from tests.bench.plan.exact import ExactMap

SEEDS = range(6)


def scene_of(style: str, seed: int, seal: bool = False) -> Scene:
    return draw_scene(style, np.random.default_rng([77, seed]), seal=seal)


def bare(layout: Layout) -> TrueMap:
    """The walls of a scene alone."""
    spec = scene_of("home", 0).spec
    wall = next(o for o in spec.obstacles if o.name == "wall")
    halves = ((r.size_m[0] / 2, r.size_m[1] / 2) for r in layout.walls)
    walls = zip(layout.walls, halves, strict=True)
    return TrueMap(
        tuple(replace(wall, center_m=r.center_m, half_m=half) for r, half in walls), layout.outline
    )


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("style", STYLES)
def test_sizes_doors_and_start(style: str, seed: int) -> None:
    scene = scene_of(style, seed)
    assert 3.0 < min(scene.layout.outline.size_m) <= max(scene.layout.outline.size_m) <= 12.0
    for door in scene.layout.doors:
        assert DOOR_M[0] <= door.width_m <= DOOR_M[1]
        assert not any(wall.near(door.gap, -1e-6) for wall in scene.layout.walls)
    start = np.array([scene.spec.start_m])
    assert Footprints(scene.spec.obstacles).gap_m(start, 0.03, 1.5)[0] > START_GAP_M - STEP_M


@pytest.mark.parametrize("seed", [56, 2221, 3053])
def test_a_narrow_office_has_rooms_on_both_sides(seed: int) -> None:
    layout = office(np.random.default_rng(seed))
    assert layout.outline.size_m[1] < 6.6
    assert all(min(room.size_m) > 1.0 for room in layout.rooms)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("style", ["home", "office", "maze"])
def test_doors_and_corridors_join_all_rooms(style: str, seed: int) -> None:
    layout = scene_of(style, seed).layout
    truth = bare(layout)
    free = truth.solid_gap_m > CLEARANCE_M + 0.05
    reached = flood(free, truth.cell(layout.rooms[0].center_m))
    for room in layout.rooms:
        assert reached[truth.cell(room.center_m)], room


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("style", STYLES)
def test_the_drone_may_fly_in_all_of_it(style: str, seed: int) -> None:
    scene = scene_of(style, seed)
    way = {name.removeprefix("way."): value for name, value in scene.spec.eeprom.items()}
    assert way["areaX1"] - way["areaX0"] <= GRID_SIDE_CELLS * way["cell"] + 1e-9
    assert way["areaY1"] - way["areaY0"] <= GRID_SIDE_CELLS * way["cell"] + 1e-9
    c, s = np.cos(scene.spec.start_yaw_rad), np.sin(scene.spec.start_yaw_rad)
    off = scene.truth.points_m - scene.spec.start_m
    x, y = c * off[..., 0] + s * off[..., 1], c * off[..., 1] - s * off[..., 0]
    assert way["areaX0"] < x.min() and x.max() < way["areaX1"]
    assert way["areaY0"] < y.min() and y.max() < way["areaY1"]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_shut_room_cannot_be_entered(seed: int) -> None:
    scene = scene_of("office", seed, seal=True)
    assert scene.sealed is not None
    free = scene.truth.body_gap_m > BODY_M
    reached = flood(free, scene.truth.cell(scene.spec.start_m))
    room = scene.layout.rooms[scene.sealed]
    assert not (reached & scene.truth.within(room)).any()
    assert reached.sum() > 100


@pytest.mark.parametrize("what", ["reachable", *IMPOSSIBLE])
def test_goals_are_as_reachable_as_said_by_another_search(what: str) -> None:
    """Exact geometry over the lattice's cells, with the clearance that each claim is about."""
    for seed in range(6):
        task = draw_task(np.random.default_rng([5, seed]), what)
        truth, outline = task.scene.truth, task.scene.layout.outline
        assert task.what == what
        if what == "outside":
            assert not Rect(*task.goal_m, *task.goal_m).near(outline)
            continue
        possible = what == "reachable"
        gap_m, least_m = (
            (truth.solid_gap_m, CLEARANCE_M) if possible else (truth.body_gap_m, BODY_M)
        )
        start, goal = truth.cell(task.scene.spec.start_m), truth.cell(task.goal_m)
        reached = ExactMap((gap_m <= least_m).T).reachable(*start)
        assert reached[goal[1], goal[0]] == possible


@pytest.mark.parametrize("seed", range(8))
def test_the_shortest_way_is_nearly_the_exact_one(seed: int) -> None:
    rng = np.random.default_rng([9, seed])
    task = None
    while task is None or task.what != "reachable":
        task = draw_task(rng)
    truth = task.scene.truth
    exact = ExactMap((truth.body_gap_m <= CLEARANCE_M).T)
    ends = [
        tuple((np.array(place) - truth.points_m[0, 0]) / STEP_M + 0.5)
        for place in (task.scene.spec.start_m, task.goal_m)
    ]
    length, _ = exact.optimum(ends[0], ends[1])
    assert 0.96 < length_m(task.way_m) / (length * STEP_M) < 1.02


def test_a_world_with_all_that_moves_can_be_written_and_read(tmp_path: Path) -> None:
    names = set()
    for seed in range(12):
        task, movers = moving.draw_task(np.random.default_rng([6, seed]))
        names |= {mover.name for mover in movers}
        spec = replace(task.scene.spec, obstacles=(*task.scene.spec.obstacles, *movers))
        file = tmp_path / f"{spec.name}.toml"
        file.write_text(world_text(spec))
        read = read_world(file)
        places = [sorted((o.name, o.center_m) for o in s.obstacles if o.name != "ceiling")
                  for s in (spec, read)]  # fmt: skip
        assert places[0] == places[1]
        assert read.eeprom == spec.eeprom
        for time_s in (0.0, 7.3, 31.0):
            before, after = Footprints(spec.obstacles), Footprints(read.obstacles)
            before.move_to(time_s, None)
            after.move_to(time_s, None)
            points = task.scene.truth.points_m[::9, ::9].reshape(-1, 2)
            gaps = [place.gap_m(points, 0.3, 0.5) for place in (before, after)]
            assert np.abs(gaps[0] - gaps[1]).max() < 1e-6
    assert names == {"person", "sliding door", "crate"}
