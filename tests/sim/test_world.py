# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds: rays, distances, motion; and every shipped one can be flown."""

import math
from collections import deque
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.sim.world import World, load_world
from ground.sim.worldfile import WORLDS_DIR
from tests.sim.plants import OPEN_FLOOR, world_from

SHIPPED = sorted(path.stem for path in WORLDS_DIR.glob("*.toml"))
CELL_M = 0.05
BODY_AND_MARGIN_M = 0.2

DISC = OPEN_FLOOR + "[[disc]]\ncenter = [2, 0]\nradius_m = 0.5\nheight_m = 1.0\n"
WALKER = DISC + "[disc.motion]\npath = [[2, 3], [5, 3]]\nspeed_mps = 1.0\nstart_s = 10\n"


def distance_m(world: World, x_m: float, y_m: float, angle_rad: float, z_m: float = 0.5) -> float:
    """The range of one level ray."""
    direction = np.array([[math.cos(angle_rad), math.sin(angle_rad), 0.0]])
    return float(world.cast((x_m, y_m, z_m), direction, 50.0).distance_m[0])


def reachable(world: World, goal_m: tuple[float, float]) -> bool:
    """Whether a path from the start to a world point keeps BODY_AND_MARGIN_M everywhere."""
    e = world.spec.eeprom
    xs = np.arange(e["way.areaX0"], e["way.areaX1"], CELL_M)
    ys = np.arange(e["way.areaY0"], e["way.areaY1"], CELL_M)
    mx, my = np.meshgrid(xs, ys, indexing="ij")
    wx, wy = world.to_world(mx, my)
    places = np.stack([wx.ravel(), wy.ravel()], axis=1)
    free = world.surface_distance_m(places).reshape(mx.shape) > BODY_AND_MARGIN_M

    def cell(point: tuple[float, float]) -> tuple[int, int]:
        x, y = world.to_map(*point)
        return round((x - xs[0]) / CELL_M), round((y - ys[0]) / CELL_M)

    queue, seen = deque([cell(world.spec.start_m)]), np.zeros_like(free)
    while queue:
        i, j = queue.popleft()
        if 0 <= i < len(xs) and 0 <= j < len(ys) and free[i, j] and not seen[i, j]:
            seen[i, j] = True
            queue.extend([(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)])
    return bool(seen[cell(goal_m)])


def clearance_m(world: World, point: tuple[float, float]) -> float:
    return float(world.surface_distance_m(np.array([point]))[0])


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_world_can_be_flown(name: str) -> None:
    world = load_world(name)
    goal = world.spec.demo_goal_m
    assert goal is not None
    target = world.to_world(*goal)
    assert clearance_m(world, world.spec.start_m) >= 0.4
    assert clearance_m(world, target) >= 0.4
    assert reachable(world, target)


@pytest.mark.parametrize("name", SHIPPED)
def test_the_area_of_a_shipped_world_fits_the_grid(name: str) -> None:
    e = load_world(name).spec.eeprom
    side_m = 128 * e.get("way.cell", CELL_M)
    assert e["way.areaX1"] - e["way.areaX0"] <= side_m - 0.2
    assert e["way.areaY1"] - e["way.areaY0"] <= side_m - 0.2


def test_in_the_flat_the_readme_goal_is_in_another_room() -> None:
    world = load_world("flat")
    goal = world.to_world(2.0, 1.0)
    (x, y), (gx, gy) = world.spec.start_m, goal
    straight_m = math.hypot(gx - x, gy - y)
    assert distance_m(world, x, y, math.atan2(gy - y, gx - x), z_m=2.3) < straight_m
    assert clearance_m(world, goal) >= 0.35
    assert reachable(world, goal)


def test_rays_meet_walls_where_they_are() -> None:
    world = load_world("empty")
    for angle_deg, expected_m in ((0, 3.75), (90, 2.5), (180, 1.25), (270, 2.5)):
        assert distance_m(world, 1.25, 2.5, math.radians(angle_deg)) == pytest.approx(expected_m)
    slant_m = distance_m(world, 1.25, 2.5, math.radians(30.0))
    assert slant_m == pytest.approx(3.75 / math.cos(math.radians(30.0)))


def test_a_ray_knows_incidence_and_reflectivity(tmp_path: Path) -> None:
    world = world_from(
        tmp_path,
        OPEN_FLOOR
        + "[[box]]\ncenter = [2, 0]\nsize = [1, 1]\nheight_m = 1\nyaw_deg = 30\n"
        + "reflectivity = 0.25\n",
    )
    rays = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, -1.0]])
    seen = world.cast((0.0, 0.0, 0.5), rays, 10.0)
    assert seen.cos_incidence[0] == pytest.approx(math.cos(math.radians(30.0)))
    assert seen.reflectivity[0] == 0.25
    assert math.isinf(seen.distance_m[1])
    assert seen.distance_m[2] == pytest.approx(0.5)
    assert seen.reflectivity[2] != 0.25


@given(x=st.floats(-50, 50), y=st.floats(-50, 50))
def test_map_and_world_frame_are_inverse(x: float, y: float) -> None:
    world = load_world("empty")
    assert world.to_map(*world.to_world(x, y)) == pytest.approx((x, y), abs=1e-9)


def test_the_map_frame_looks_along_the_start_heading(tmp_path: Path) -> None:
    world = world_from(tmp_path, "[start]\nx_m = 1\ny_m = 2\nyaw_deg = 90\n")
    assert world.to_world(1.0, 0.0) == pytest.approx((1.0, 3.0))
    assert world.to_world(0.0, 1.0) == pytest.approx((0.0, 2.0))


def test_surface_distance_is_to_the_nearest_outline_from_both_sides(tmp_path: Path) -> None:
    world = world_from(tmp_path, DISC)
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.9], [2.5, 0.0]])
    assert world.surface_distance_m(points) == pytest.approx([1.5, 0.5, 0.4, 0.0])


def test_surface_distance_ignores_what_is_below_flight_height(tmp_path: Path) -> None:
    world = world_from(tmp_path, DISC.replace("height_m = 1.0", "height_m = 0.3"))
    assert math.isinf(world.surface_distance_m(np.zeros((1, 2)))[0])
    assert world.surface_distance_m(np.zeros((1, 2)), height_m=0.2)[0] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("time_s", "expected"),
    [(0.0, (2, 0)), (10.0, (2, 0)), (11.5, (2, 1.5)), (14.0, (3, 3)), (99.0, (5, 3))],
)
def test_something_moving_once_is_where_it_should_be(
    tmp_path: Path, time_s: float, expected: tuple[float, float]
) -> None:
    world = world_from(tmp_path, WALKER)
    world.set_time(time_s)
    assert world.footprints.center_m[0] == pytest.approx(expected)
    x, y = expected
    assert distance_m(world, x - 2.0, y, 0.0) == pytest.approx(1.5)


def test_something_moving_round_and_round_comes_home(tmp_path: Path) -> None:
    world = world_from(tmp_path, WALKER + "loop = true\n")
    lap_s = 3.0 + 3.0 + math.hypot(3.0, 3.0)
    world.set_time(10.0 + 5 * lap_s + 1.0)
    assert world.footprints.center_m[0] == pytest.approx((2.0, 1.0))


def test_a_moving_thing_knows_its_speed(tmp_path: Path) -> None:
    world = world_from(tmp_path, WALKER)
    for time_s in (10.5, 10.51):
        world.set_time(time_s)
    assert world.footprints.velocity_mps[0] == pytest.approx((0.0, 1.0))
    for time_s in (50.0, 50.01):
        world.set_time(time_s)
    assert world.footprints.velocity_mps[0] == pytest.approx((0.0, 0.0))


def test_things_appear_and_vanish(tmp_path: Path) -> None:
    world = world_from(tmp_path, DISC + "appears_s = 5\nvanishes_s = 8\n")
    for time_s, there in ((0.0, False), (4.99, False), (5.0, True), (7.99, True), (8.0, False)):
        world.set_time(time_s)
        assert (distance_m(world, 0.0, 0.0, 0.0) < 2.0) is there
        assert math.isfinite(world.surface_distance_m(np.zeros((1, 2)))[0]) is there


def test_the_door_closes_when_the_drone_comes_and_another_way_stays() -> None:
    world = load_world("door")
    goal = world.to_world(*(world.spec.demo_goal_m or (0.0, 0.0)))
    x, y = world.spec.start_m
    world.set_time(60.0, (x, y))
    assert distance_m(world, x, y, 0.0) > 4.0
    for step in range(300):
        world.set_time(60.0 + 0.01 * step, (x + 0.95, y))
    assert distance_m(world, x, y, 0.0) < 2.2
    assert reachable(world, goal)


def test_floor_quality_is_that_of_the_patch(tmp_path: Path) -> None:
    world = world_from(
        tmp_path,
        OPEN_FLOOR
        + "[floor]\nquality = 0.9\n[[floor.patch]]\nfrom = [1, 1]\nto = [2, 2]\nquality = 0.1\n",
    )
    assert world.floor_quality(1.5, 1.5) == 0.1
    assert world.floor_quality(0.5, 1.5) == 0.9
