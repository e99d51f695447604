# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole flights with one fault each: the stated reaction, and never a collision."""

import pytest

from ground.core import MissionReason, MissionState
from ground.model import Point
from ground.sim.faultflight import fly_with_fault
from ground.sim.pilot import Pilot
from ground.sim.runtime import Options
from ground.sim.world import load_world

LANDS = {
    "flow-lost": MissionReason.FLOW_LOST,
    "flow-gone": MissionReason.FLOW_LOST,
    "ranges-frozen": MissionReason.RANGES_FROZEN,
    "ranges-dead": MissionReason.BLIND,
}
STOPS = {"tumbled": MissionReason.TUMBLED, "e-stop": MissionReason.CANNOT_FLY}


def pilot() -> tuple[Pilot, Point]:
    world = load_world("flat")
    assert world.spec.demo_goal_m is not None
    return Pilot(world, Options(seed=3)), Point(*world.spec.demo_goal_m)


@pytest.mark.parametrize(
    ("fault", "phase"),
    [
        ("flow-lost", "takeoff"), ("flow-lost", "follow"), ("flow-lost", "return"),
        ("flow-gone", "scan"), ("flow-gone", "follow"), ("flow-gone", "hover"),
        ("ranges-frozen", "takeoff"), ("ranges-frozen", "follow"), ("ranges-frozen", "hover"),
        ("ranges-dead", "scan"), ("ranges-dead", "follow"), ("ranges-dead", "return"),
    ],
)  # fmt: skip
def test_it_lands_where_it_is_and_says_why(fault: str, phase: str) -> None:
    """Each fault in some phases and vice versa; `wayflie campaign --kind fault` flies all."""
    flight = fly_with_fault(*pilot(), fault, phase, 0.3)
    assert flight.happened and flight.alive and not flight.hangs
    assert flight.state is MissionState.IDLE
    assert LANDS[fault] in flight.reasons
    assert flight.collisions == 0


@pytest.mark.parametrize("phase", ["takeoff", "follow", "hover"])
@pytest.mark.parametrize("fault", STOPS)
def test_the_motors_stop(fault: str, phase: str) -> None:
    flight = fly_with_fault(*pilot(), fault, phase, 0.5)
    assert flight.state is MissionState.FAULT
    assert STOPS[fault] in flight.reasons


@pytest.mark.parametrize("fault", ["front-dead", "left-frozen", "ranges-dead"])
def test_it_does_not_take_off_half_blind(fault: str) -> None:
    flight = fly_with_fault(*pilot(), fault, "ground")
    assert flight.state is MissionState.IDLE
    assert flight.reasons == (MissionReason.BLIND,)


@pytest.mark.parametrize("fault", ["packets-doubled", "packets-reordered", "packets-late", "box"])
def test_what_does_no_harm_changes_nothing(fault: str) -> None:
    flight = fly_with_fault(*pilot(), fault, "follow", 0.5)
    assert flight.alive and not flight.hangs
    assert flight.collisions == 0
    assert flight.reasons == ()
