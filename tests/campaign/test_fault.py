# SPDX-License-Identifier: GPL-3.0-or-later
"""The matrix of faults and phases: all of it is flown, and reactions are judged by the table."""

from dataclasses import replace

import pytest

from ground.core import MissionReason, MissionState
from ground.sim.campaign.fault import cause_of, cells, stated_reaction
from ground.sim.campaign.flights import Mission, row_of
from ground.sim.faultflight import PHASES, FaultFlight
from ground.sim.faulttable import FAULTS

LANDED = FaultFlight(
    "flow-lost", "follow", True, MissionState.IDLE, (MissionReason.FLOW_LOST,), False, True, 0
)


def test_each_fault_meets_each_phase() -> None:
    pairs = cells()
    assert len(set(pairs)) == len(pairs)
    assert {phase for _, phase in pairs} == set(PHASES)
    left_out = set(FAULTS) - {fault for fault, _ in pairs}
    assert all(name.startswith(("back-", "right-")) for name in left_out)


def test_what_is_not_as_stated_has_a_cause() -> None:
    assert cause_of(LANDED) == ""
    assert cause_of(replace(LANDED, state=MissionState.HOVER)) == "another reaction"
    assert cause_of(replace(LANDED, reasons=())) == "another reaction"
    assert cause_of(replace(LANDED, collisions=1)) == "collision"
    assert cause_of(replace(LANDED, hangs=True)) == "hangs"
    assert cause_of(replace(LANDED, alive=False)) == "the app stopped"
    assert cause_of(replace(LANDED, fault="packets-late")) == ""
    assert stated_reaction("flow-lost").what == "lands"


def test_a_row_tells_what_followed() -> None:
    number = cells().index(("flow-lost", "hover"))
    row = row_of(Mission("fault", 2, number))
    assert row.task == "flow-lost / hover"
    assert (row.outcome, row.reason, row.cause) == ("idle", "FLOW_LOST", "")


@pytest.mark.parametrize(
    ("fault", "phase", "seed", "says"),
    [
        ("estimate-diverges", "takeoff", 52, "ESTIMATOR"),
        ("estimate-diverges", "scan", 53, "ESTIMATOR"),
        ("estimate-diverges", "return", 52, "ESTIMATOR"),
        ("ranges-short", "hover", 201, "BLIND"),
        ("left-short", "ground", 201, "BLIND"),
        ("front-short", "follow", 201, "BLIND"),
    ],
)
def test_what_cannot_be_believed_lands_it_and_touches_nothing(
    fault: str, phase: str, seed: int, says: str
) -> None:
    row = row_of(Mission("fault", seed, cells().index((fault, phase))))
    assert (row.cause, row.touches, row.outcome) == ("", 0, "idle")
    assert says in row.reason
