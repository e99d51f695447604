# SPDX-License-Identifier: GPL-3.0-or-later
"""Relocalisation: certain of the right place, never of one of several that look alike."""

import itertools
import math
from collections.abc import Iterable, Iterator

import pytest

from ground.core import CData, ffi, lib

CELL_M = 0.05
BUDGET = 500
Box = tuple[float, float, float, float]
Pose = tuple[float, float, float]
ROOM: Box = (-2.0, -1.6, 2.0, 1.6)
FURNITURE: tuple[Box, ...] = ((0.9, -1.6, 1.6, -0.8), (-2.0, 0.6, -1.4, 1.2), (-0.2, 1.2, 0.7, 1.6))


def cells_of(low_m: float, high_m: float) -> range:
    return range(64 + round(low_m / CELL_M), 64 + round(high_m / CELL_M))


def made_map(boxes: Iterable[Box]) -> CData:
    """A free room, with its outline and all cells of boxes occupied."""
    grid = ffi.new("grid_t *")
    lib.grid_init(grid, ffi.new("grid_config_t *", lib.grid_config_default()), (0.0, 0.0), CELL_M)
    x0, y0, x1, y1 = ROOM
    for iy in cells_of(y0 - CELL_M, y1 + CELL_M):
        for ix in cells_of(x0 - CELL_M, x1 + CELL_M):
            inside = ix in cells_of(x0, x1) and iy in cells_of(y0, y1)
            lib.grid_set_value(grid, ix, iy, 1 if inside else 15)
    for bx0, by0, bx1, by1 in boxes:
        for iy in cells_of(by0, by1):
            for ix in cells_of(bx0, bx1):
                lib.grid_set_value(grid, ix, iy, 15)
    return grid


def range_m(boxes: Iterable[Box], pose: Pose, bearing: float) -> float:
    """The range by small steps to the wall or a box."""
    x, y, yaw = pose
    c, s = math.cos(yaw + bearing), math.sin(yaw + bearing)
    reach = 0.0
    while True:
        px, py = x + reach * c, y + reach * s
        if not (ROOM[0] < px < ROOM[2] and ROOM[1] < py < ROOM[3]):
            return reach
        if any(a <= px <= c_ and b <= py <= d for a, b, c_, d in boxes):
            return reach
        reach += 0.01


def frame_of(boxes: tuple[Box, ...], pose: Pose, start: Pose, reads: float = 1.0) -> CData:
    """What is measured there; odometry begins with zero at the start and reads so many times too
    far."""
    frame = ffi.new("scan_frame_t *")
    dx, dy = pose[0] - start[0], pose[1] - start[1]
    c, s = math.cos(start[2]), math.sin(start[2])
    yaw = math.remainder(pose[2] - start[2], math.tau)
    frame.pose = (reads * (c * dx + s * dy), reads * (c * dy - s * dx), yaw)
    frame.hit = 15
    bearings = (lib.scan_bearing_rad(beam) for beam in range(lib.SCAN_BEAMS))
    frame.range_m = [range_m(boxes, pose, bearing) for bearing in bearings]
    return frame


def route(start: Pose) -> Iterator[Pose]:
    """A turn, then three times a move and a turn."""
    x, y, yaw = start
    for step in range(60):
        yield x, y, yaw + math.radians(6.0) * step
    for leg in range(3):
        for _ in range(10):
            x += (0.06, -0.06, 0.06)[leg]
            y += 0.03
            yield x, y, yaw
        for step in range(40):
            yield x, y, yaw + math.radians(6.0) * step


def flown(
    grid: CData, boxes: tuple[Box, ...], start: Pose, budget: int = BUDGET
) -> tuple[CData, Pose, bool]:
    """Fly the route and process each set. @return the pose, and whether it was ever certain"""
    reloc = ffi.new("reloc_t *")
    lib.reloc_init(reloc)
    sure = False
    pose = start
    for pose in route(start):
        lib.reloc_add(reloc, frame_of(boxes, pose, start))
        while lib.reloc_work(reloc, grid, budget):
            pass
        sure = sure or reloc.sure
    return reloc, pose, sure


def off(reloc: CData, truth: Pose) -> tuple[float, float]:
    """Error in metres and radians, at the newest set."""
    found = ffi.new("pose2_t *")
    assert lib.reloc_to_map(reloc, reloc.anchor, found)
    turned = math.remainder(found.yaw_rad - truth[2], math.tau)
    return math.hypot(found.x_m - truth[0], found.y_m - truth[1]), abs(turned)


@pytest.mark.parametrize("start", [(-0.8, -0.9, 0.3), (0.3, 0.0, 2.5), (-0.6, 0.1, -1.9)])
def test_it_finds_itself_in_a_room_with_furniture(start: Pose) -> None:
    reloc, truth, sure = flown(made_map(FURNITURE), FURNITURE, start)
    assert sure
    off_m, off_rad = off(reloc, truth)
    assert off_m < 0.1
    assert off_rad < math.radians(9.0)  # one step of the route: the last set may not be spread


def test_hypotheses_are_of_different_places_best_first() -> None:
    start, grid, reloc = (-0.8, -0.9, 0.3), made_map(FURNITURE), ffi.new("reloc_t *")
    lib.reloc_init(reloc)
    most = 0
    for pose in route(start):
        lib.reloc_add(reloc, frame_of(FURNITURE, pose, start))
        while lib.reloc_work(reloc, grid, BUDGET):
            pass
        kept = reloc.place_list[0 : reloc.places]
        most = max(most, len(kept))
        assert [a.score for a in kept] == sorted((a.score for a in kept), reverse=True)
        for a, b in itertools.combinations((place.pose for place in kept), 2):
            turned_rad = math.remainder(a.yaw_rad - b.yaw_rad, math.tau)
            assert math.dist((a.x_m, a.y_m), (b.x_m, b.y_m)) > 0.299 or abs(turned_rad) > 0.26
    assert 2 < most <= 24


def test_it_is_never_sure_where_a_half_turn_changes_nothing() -> None:
    bare: tuple[Box, ...] = ()
    reloc, _, sure = flown(made_map(bare), bare, (-0.8, -0.9, 0.3))
    assert not sure
    assert reloc.places >= 2
    best, second = reloc.place_list[0], reloc.place_list[1]
    assert best.score > 0.8
    assert best.score - second.score < 0.04
    assert best.pose.x_m == pytest.approx(-second.pose.x_m, abs=0.15)
    assert best.pose.y_m == pytest.approx(-second.pose.y_m, abs=0.15)


def test_it_is_not_sure_where_the_map_is_of_another_place() -> None:
    elsewhere: tuple[Box, ...] = ((-2.0, -1.6, -0.2, 0.2), (1.2, 0.4, 2.0, 1.6))
    _, _, sure = flown(made_map(elsewhere), FURNITURE, (0.3, 0.0, 2.5))
    assert not sure


@pytest.mark.parametrize(
    "mapped",
    [
        ((0.2, -1.6, 0.8, -1.2), (0.8, 0.8, 1.4, 1.6), (0.8, 0.8, 1.6, 1.6)),
        ((1.2, 0.0, 2.0, 0.6), (-2.0, -1.2, -1.6, -0.8), (0.8, -1.6, 1.2, -1.0)),
    ],
)
def test_the_best_of_bad_places_is_not_believed(mapped: tuple[Box, ...]) -> None:
    """One place stays best, metres off, with half of the beams fitting: it must not be accepted."""
    reloc, truth, sure = flown(made_map(mapped), FURNITURE, (0.3, 0.0, 2.5))
    assert not sure
    assert reloc.place_list[0].score - reloc.place_list[1].score > 0.04
    off_m, _ = off(reloc, truth)
    assert off_m > 0.5


@pytest.mark.parametrize("reads", [0.87, 1.15])
def test_it_finds_how_far_odometry_reads(reads: float) -> None:
    """Otherwise a newest pose that lags, as old sets lie too far away, would pass as certain."""
    start = (-0.8, -0.9, 0.3)
    grid, reloc = made_map(FURNITURE), ffi.new("reloc_t *")
    lib.reloc_init(reloc)
    worst_m = 0.0
    for step, pose in enumerate(route(start)):
        lib.reloc_add(reloc, frame_of(FURNITURE, pose, start, reads))
        while lib.reloc_work(reloc, grid, BUDGET):
            pass
        if step > 150:  # the last move, and the turn after it
            worst_m = max(worst_m, off(reloc, pose)[0])
    assert reloc.place_list[0].stretch * reads == pytest.approx(1.0, abs=0.5 * abs(reads - 1.0))
    assert worst_m < 0.06


def test_only_states_of_cells_count() -> None:
    """So a map of two bits per cell, imported or kept, is as good as the original."""
    start = (0.3, 0.0, 2.5)
    drawn, states = made_map(FURNITURE), made_map(FURNITURE)
    for iy in range(lib.GRID_SIDE_CELLS):
        for ix in range(lib.GRID_SIDE_CELLS):
            state = lib.grid_state(drawn, ix, iy)
            if state != lib.GRID_CELL_UNKNOWN:
                free = state == lib.GRID_CELL_FREE
                lib.grid_set_value(drawn, ix, iy, 1 + (ix + iy) % 7 + (0 if free else 7))
    one, _, _ = flown(drawn, FURNITURE, start)
    other, _, _ = flown(states, FURNITURE, start)
    assert bytes(ffi.buffer(one)) == bytes(ffi.buffer(other))


def test_it_is_not_sure_before_it_has_moved() -> None:
    grid, start = made_map(FURNITURE), (-0.8, -0.9, 0.3)
    reloc = ffi.new("reloc_t *")
    lib.reloc_init(reloc)
    for step in range(240):
        pose = (*start[:2], start[2] + math.radians(6.0) * step)
        lib.reloc_add(reloc, frame_of(FURNITURE, pose, start))
        while lib.reloc_work(reloc, grid, BUDGET):
            assert not reloc.sure
    assert reloc.places > 0


def test_slices_do_not_matter() -> None:
    grid, start = made_map(FURNITURE), (0.3, 0.0, 2.5)
    one, _, _ = flown(grid, FURNITURE, start, budget=1)
    other, _, _ = flown(grid, FURNITURE, start, budget=100_000)
    assert bytes(ffi.buffer(one)) == bytes(ffi.buffer(other))


def test_a_slice_ends_soon_after_its_budget() -> None:
    """Even one unit at a time completes a search, with at most one stage per call."""
    grid, start = made_map(FURNITURE), (0.3, 0.0, 2.5)
    reloc = ffi.new("reloc_t *")
    lib.reloc_init(reloc)
    for pose in list(route(start))[:24]:
        lib.reloc_add(reloc, frame_of(FURNITURE, pose, start))
        lib.reloc_work(reloc, grid, 1)
    calls = 0
    while lib.reloc_work(reloc, grid, 1):
        calls += 1
    assert calls > 5_000


def test_sets_without_sense_are_dropped() -> None:
    reloc, grid = ffi.new("reloc_t *"), made_map(FURNITURE)
    lib.reloc_init(reloc)
    frame = ffi.new("scan_frame_t *")
    for bad in (math.nan, math.inf, 1.0e30):
        frame.pose = (bad, 0.0, 0.0)
        lib.reloc_add(reloc, frame)
    assert reloc.waiting == 0
    frame.hit = frame.clear = 255
    for step in range(60):
        frame.pose = (0.0, 0.0, 0.2 * step)
        frame.range_m = [math.nan, math.inf, -1.0, 1.0e9]
        lib.reloc_add(reloc, frame)
        while lib.reloc_work(reloc, grid, BUDGET):
            pass
    assert reloc.count > 0
    assert all(one.hit == 0 and one.clear == 0 for one in reloc.sets)
    assert not reloc.sure


def test_nothing_is_known_at_first() -> None:
    reloc, pose = ffi.new("reloc_t *"), ffi.new("pose2_t *")
    lib.reloc_init(reloc)
    assert not lib.reloc_work(reloc, made_map(()), BUDGET)
    assert not lib.reloc_to_map(reloc, (0.0, 0.0, 0.0), pose)


def test_an_empty_map_says_nothing() -> None:
    grid = ffi.new("grid_t *")
    lib.grid_init(grid, ffi.new("grid_config_t *", lib.grid_config_default()), (0.0, 0.0), CELL_M)
    reloc, _, sure = flown(grid, FURNITURE, (0.3, 0.0, 2.5))
    assert not sure
    assert reloc.places == 0


def test_it_fits_where_the_planner_is() -> None:
    assert ffi.sizeof("reloc_t") <= ffi.sizeof("pathfinder_t")
