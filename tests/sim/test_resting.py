# SPDX-License-Identifier: GPL-3.0-or-later
"""Left alone, a hovering drone stays in place: false ranges are not taken for intruders."""

from ground.core import EventCode, MissionCmd, MissionReason, MissionState
from ground.model import Event
from ground.sim.pilot import Pilot
from ground.sim.runtime import Options
from ground.sim.world import load_world

SEEDS = (1, 3, 4, 5)
RESTING_S = 100.0


def backed_away(event: Event) -> bool:
    return event.code is EventCode.STATE and event.argument == MissionState.AVOID


def test_it_hardly_ever_backs_away_from_nothing() -> None:
    times_s = []
    for seed in SEEDS:
        pilot = Pilot(load_world("flat"), Options(seed=seed))
        assert pilot.fly(MissionCmd.TAKE_OFF).reason is MissionReason.OK
        pilot.rest(RESTING_S)
        times_s += [(seed, e.drone_ms / 1000) for e in pilot.picture.events if backed_away(e)]
        assert pilot.truth()["collisions"] == 0
    assert len(times_s) <= 1, times_s
