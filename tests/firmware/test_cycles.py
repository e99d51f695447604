# SPDX-License-Identifier: GPL-3.0-or-later
"""No tick takes longer than a quarter of its period, with room for the model's error."""

import pytest

from tests.bench.cycles import SAFETY, TICK_LIMIT_CYCLES
from tests.firmware.flights import Flight
from tests.firmware.replay import RUNS, TICK, part_name, replay


@pytest.mark.parametrize(("flight", "flags"), RUNS, ids=part_name)
def test_the_worst_tick_is_within_its_budget(flight: Flight, flags: str) -> None:
    assert SAFETY * replay(flight, flags).run.cycles[TICK].max() <= TICK_LIMIT_CYCLES
