# SPDX-License-Identifier: GPL-3.0-or-later
"""Recently seen cells: those that beams crossed, for as long as a look counts."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import frame, new_grid, pose, vec2

AGE_S = 10.0
ranges_m = st.floats(0.0, 4.0)
places_m = st.floats(-3.0, 3.0)


def looked(range_m: float, x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0) -> CData:
    """The state after one look of the front beam."""
    seen = ffi.new("seen_t *")
    lib.seen_mark(seen, new_grid(), frame({lib.SCAN_FRONT: range_m}), pose(x_m, y_m, yaw_rad))
    return seen


def lately(seen: CData, x_m: float, y_m: float) -> bool:
    return bool(lib.seen_lately(seen, new_grid(), vec2(x_m, y_m)))


@given(ranges_m, places_m, places_m, st.floats(-math.pi, math.pi))
def test_a_beam_has_seen_its_way_and_nothing_far_from_it(
    range_m: float, x_m: float, y_m: float, yaw_rad: float
) -> None:
    seen = looked(range_m, x_m, y_m, yaw_rad)
    tile_m = lib.GRID_TILE_SIDE_CELLS * new_grid().cell_m
    assert lately(seen, x_m, y_m)
    for at_m in (0.5 * tile_m * i for i in range(round(2 * range_m / tile_m))):
        x, y = x_m + at_m * math.cos(yaw_rad), y_m + at_m * math.sin(yaw_rad)
        if max(abs(x), abs(y)) < 3.2:
            assert lately(seen, x, y)
    beyond_m = range_m + 1.5 * tile_m
    assert not lately(seen, x_m + beyond_m * math.cos(yaw_rad), y_m + beyond_m * math.sin(yaw_rad))
    assert not lately(seen, x_m - 1.5 * tile_m * math.cos(yaw_rad),
                      y_m - 1.5 * tile_m * math.sin(yaw_rad))  # fmt: skip


def test_a_beam_without_a_measurement_sees_nothing() -> None:
    seen = ffi.new("seen_t *")
    lib.seen_mark(seen, new_grid(), frame({}), pose())
    assert not lately(seen, 0.0, 0.0)


@pytest.mark.parametrize("range_m", [math.nan, math.inf, -1.0, 1e30])
def test_a_range_that_is_none_ends(range_m: float) -> None:
    assert not lately(looked(range_m), -1.0, 0.0)


@given(st.integers(0, 2**32 - 1), st.lists(st.floats(0.02, 3.0), min_size=1, max_size=40))
def test_a_look_counts_for_at_least_half_of_the_time_and_at_most_all(
    start_ms: int, steps_s: list[float]
) -> None:
    seen = ffi.new("seen_t *")
    now_ms = start_ms
    lib.seen_step(seen, now_ms, AGE_S)
    lib.seen_mark(seen, new_grid(), frame({lib.SCAN_FRONT: 1.0}), pose())
    for step_s in steps_s:
        now_ms = (now_ms + round(1000 * step_s)) % 2**32
        lib.seen_step(seen, now_ms, AGE_S)
        age_s = ((now_ms - start_ms) % 2**32) / 1000
        if age_s <= AGE_S / 2:
            assert lately(seen, 0.5, 0.0)
        if age_s > AGE_S + 3.0:
            assert not lately(seen, 0.5, 0.0)


def test_forgetting_forgets_both_halves() -> None:
    seen = looked(1.0)
    lib.seen_step(seen, 60_000, AGE_S)
    assert lately(seen, 0.5, 0.0)
    lib.seen_forget(seen)
    assert not lately(seen, 0.5, 0.0)


@pytest.mark.parametrize("place", [(3.3, 0.0), (0.0, -3.3), (math.nan, 0.0)])
def test_outside_the_grid_nothing_was_seen(place: tuple[float, float]) -> None:
    assert not lately(looked(3.9), *place)
