# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone flies from room to room on the pose that it corrects itself; odometry would be lost."""

import numpy as np
import pytest

from tests.bench.slam.closed_loop import Flown, Plan, fly_closed

MINUTES = 2.5


@pytest.fixture(scope="module")
def flights() -> dict[int, Flown]:
    """The same goals under the same drift, by `way.slam`."""
    return {slam: fly_closed(Plan("hard", slam, seed=6, minutes=MINUTES)) for slam in (0, 1)}


def test_goals_are_truly_reached_and_nothing_is_touched(flights: dict[int, Flown]) -> None:
    flown = flights[1]
    assert flown.touches == ()
    assert len(flown.legs) >= 4
    assert [leg.sentence for leg in flown.legs if not leg.arrived] == []
    assert flown.truly_there >= len(flown.legs) - 1, flown.leg_errors_m
    assert flown.map_m < 0.1


def test_by_odometry_alone_it_is_several_times_as_far_off(flights: dict[int, Flown]) -> None:
    slam_m, odometry_m = (float(np.median(flights[slam].errors_m)) for slam in (1, 0))
    assert odometry_m > 3 * slam_m
    assert flights[0].truly_there < len(flights[0].legs)
