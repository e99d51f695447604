# SPDX-License-Identifier: GPL-3.0-or-later
"""The mission table: total, never stuck in the air, and consistent with every flight."""

from itertools import product
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import ffi, lib

STATES = range(lib.MISSION_STATES)
EVENTS = range(lib.MISSION_EVENTS)
TASKS = range(lib.MISSION_TASKS)
GROUNDED = {lib.MISSION_IDLE, lib.MISSION_FAULT}


class Mission(NamedTuple):
    state: int
    task: int
    lost: bool = False


ALL = [Mission(*parts) for parts in product(STATES, TASKS, (False, True))]
FLYING = [mission for mission in ALL if mission.state not in GROUNDED]
STANDING = [mission for mission in ALL if mission.state in GROUNDED]
LOST = [mission for mission in ALL if mission.lost]
TAKING_OFF = (
    lib.MISSION_EV_TAKE_OFF,
    lib.MISSION_EV_WAY_EXISTS,
    lib.MISSION_EV_RELOCALISE,
)


def step(mission: Mission, event: int) -> tuple[Mission, bool]:
    """The mission after an event, and whether a state was entered."""
    c = ffi.new("mission_t *", (mission.state, mission.task, lib.MISSION_OK, mission.lost))
    entered = lib.mission_step(c, event)
    return Mission(c.state, c.task, c.lost), entered


def run(events: list[str], task: int = lib.MISSION_TASK_NONE) -> list[int]:
    """The states that are passed through, starting on the ground."""
    mission = Mission(lib.MISSION_IDLE, task)
    states = []
    for name in events:
        mission, entered = step(mission, getattr(lib, f"MISSION_EV_{name}"))
        if entered:
            states.append(mission.state)
    return states


def named(*names: str) -> list[int]:
    return [getattr(lib, f"MISSION_{name}") for name in names]


def test_every_event_is_defined_in_every_state() -> None:
    for mission in ALL:
        for event in EVENTS:
            after, entered = step(mission, event)
            assert after.state in STATES, (mission, event)
            assert after.task in TASKS, (mission, event)
            assert entered or after.state == mission.state, (mission, event)


# By events, with a goal to fly to: where each leads, and from which states; from others nowhere.
IN_FLIGHT = "SCAN PLAN FOLLOW HOVER RETURN SPIN"
LEADS: dict[str, dict[str, str]] = {
    "NONE": {},
    "TAKE_OFF": {"TAKEOFF": "IDLE LAND FAULT"},
    "TASK": {"IDLE": "IDLE FAULT", "PLAN": "PLAN FOLLOW HOVER RETURN SPIN", "TAKEOFF": "LAND"},
    "LAND": {"IDLE": "IDLE", "LAND": f"TAKEOFF {IN_FLIGHT} AVOID RELOCALISE"},
    "HOLD": {"IDLE": "IDLE", "HOVER": f"TAKEOFF {IN_FLIGHT} LAND RELOCALISE"},
    "SCAN": {"SCAN": f"{IN_FLIGHT} RELOCALISE"},
    "HEIGHT": {"SCAN": "TAKEOFF"},
    "SCANNED": {"PLAN": "SCAN", "HOVER": "SPIN"},
    "WAY_EXISTS": {"TAKEOFF": "IDLE"},
    "ROUTE": {"FOLLOW": "PLAN"},
    "NO_ROUTE": {"IDLE": "IDLE", "HOVER": "PLAN"},
    "LOOK": {"SCAN": "PLAN FOLLOW RETURN"},
    "BLOCKED": {"PLAN": "FOLLOW RETURN"},
    "ARRIVED": {"HOVER": "FOLLOW RETURN"},
    "NEAR": {"AVOID": IN_FLIGHT},
    "CLEAR": {"SCAN": "AVOID"},
    "LANDED": {"IDLE": "LAND"},
    "FAILED": {"FAULT": f"IDLE TAKEOFF {IN_FLIGHT} AVOID LAND RELOCALISE"},
    "RELOCALISE": {"TAKEOFF": "IDLE LAND FAULT", "RELOCALISE": f"{IN_FLIGHT} AVOID RELOCALISE"},
    "FOUND": {"PLAN": "RELOCALISE"},
    "NOT_FOUND": {"LAND": "RELOCALISE"},
}


@pytest.mark.parametrize("event", EVENTS)
def test_each_event_leads_where_it_should_and_from_nowhere_else(event: int) -> None:
    name = next(name for name in LEADS if getattr(lib, f"MISSION_EV_{name}") == event)
    leads = {state: to for to, states in LEADS[name].items() for state in named(*states.split())}
    for state in STATES:
        after, entered = step(Mission(state, lib.MISSION_TASK_GOTO), event)
        assert entered == (state in leads)
        assert [after.state] == named(leads[state]) if entered else [state]


def test_no_event_at_all_changes_nothing() -> None:
    for mission in ALL:
        assert step(mission, lib.MISSION_EV_NONE) == (mission, False)


def test_a_failure_in_the_air_always_ends_the_motors_and_the_task() -> None:
    for mission in FLYING:
        after, _ = step(mission, lib.MISSION_EV_FAILED)
        assert after == Mission(lib.MISSION_FAULT, lib.MISSION_TASK_NONE, mission.lost)
        assert not lib.mission_airborne(after.state)


def test_from_everywhere_in_the_air_a_command_lands() -> None:
    for mission in FLYING:
        landing, _ = step(mission, lib.MISSION_EV_LAND)
        assert landing.state == lib.MISSION_LAND, mission
        landed, _ = step(landing, lib.MISSION_EV_LANDED)
        assert landed == Mission(lib.MISSION_IDLE, lib.MISSION_TASK_NONE, mission.lost)


def test_holding_ends_the_task_and_stays_in_the_air() -> None:
    for mission in FLYING:
        after, _ = step(mission, lib.MISSION_EV_HOLD)
        assert after.task == lib.MISSION_TASK_NONE, mission
        assert lib.mission_airborne(after.state), mission


def test_motors_run_everywhere_but_on_the_ground() -> None:
    assert {state for state in STATES if not lib.mission_airborne(state)} == GROUNDED


def test_only_taking_off_leaves_the_ground() -> None:
    for mission in STANDING:
        for event in EVENTS:
            after, _ = step(mission, event)
            if lib.mission_airborne(after.state):
                assert after.state == lib.MISSION_TAKEOFF, (mission, event)
                assert event in TAKING_OFF, mission


def test_motors_stop_only_after_touch_down_or_failure() -> None:
    for mission in FLYING:
        for event in EVENTS:
            after, _ = step(mission, event)
            if not lib.mission_airborne(after.state):
                assert event in (lib.MISSION_EV_LANDED, lib.MISSION_EV_FAILED), mission


def test_every_state_can_be_reached_and_left() -> None:
    start = Mission(lib.MISSION_IDLE, lib.MISSION_TASK_NONE)
    edges: dict[Mission, set[Mission]] = {}
    todo = [start, *(Mission(lib.MISSION_IDLE, task) for task in TASKS)]
    while todo:
        mission = todo.pop()
        if mission not in edges:
            edges[mission] = {step(mission, event)[0] for event in EVENTS}
            todo += edges[mission]
    assert {mission.state for mission in edges} == set(STATES)
    assert all(any(after.state != m.state for after in afters) for m, afters in edges.items())


@pytest.mark.parametrize("state", named("SCAN", "PLAN", "FOLLOW", "HOVER", "RETURN"))
def test_in_flight_the_guard_comes_first_and_the_task_goes_on_after(state: int) -> None:
    for task in TASKS:
        avoiding, _ = step(Mission(state, task), lib.MISSION_EV_NEAR)
        assert avoiding == Mission(lib.MISSION_AVOID, task)
        after, _ = step(avoiding, lib.MISSION_EV_CLEAR)
        assert after.task == task
        assert after.state == (lib.MISSION_SCAN if task else lib.MISSION_HOVER)


def test_a_flight_to_a_goal() -> None:
    flown = run(
        ["TASK", "WAY_EXISTS", "HEIGHT", "SCANNED", "ROUTE", "LOOK", "SCANNED", "ROUTE", "ARRIVED"],
        lib.MISSION_TASK_GOTO,
    )
    assert flown == named(
        "IDLE", "TAKEOFF", "SCAN", "PLAN", "FOLLOW", "SCAN", "PLAN", "FOLLOW", "HOVER"
    )


def test_a_flight_home_ends_on_the_ground() -> None:
    flown = run(
        ["TAKE_OFF", "HEIGHT", "SCANNED", "ROUTE", "BLOCKED", "ROUTE", "ARRIVED", "LANDED"],
        lib.MISSION_TASK_HOME,
    )
    assert flown == named("TAKEOFF", "SCAN", "PLAN", "RETURN", "PLAN", "RETURN", "LAND", "IDLE")


def test_exploring_looks_again_at_the_end_of_each_route() -> None:
    flown = run(
        ["TAKE_OFF", "HEIGHT", "SCANNED", "ROUTE", "ARRIVED", "SCANNED"], lib.MISSION_TASK_EXPLORE
    )
    assert flown == named("TAKEOFF", "SCAN", "PLAN", "FOLLOW", "SCAN", "PLAN")


def test_lost_it_never_begins_to_act_on_its_map() -> None:
    for mission in LOST:
        for event in EVENTS:
            after, entered = step(mission, event)
            begun = entered and after.state in named("SCAN", "PLAN", "FOLLOW", "RETURN")
            assert not begun, (mission, event)


def test_found_it_goes_on_with_its_task_and_not_found_it_lands() -> None:
    for task, goes_on in ((lib.MISSION_TASK_NONE, "HOVER"), (lib.MISSION_TASK_HOME, "PLAN")):
        looking = Mission(lib.MISSION_RELOCALISE, task)
        assert step(looking, lib.MISSION_EV_FOUND)[0] == Mission(*named(goes_on), task)
        after, _ = step(looking, lib.MISSION_EV_NOT_FOUND)
        assert after == Mission(lib.MISSION_LAND, lib.MISSION_TASK_NONE)


def test_a_take_off_alone_ends_hovering() -> None:
    assert run(["TAKE_OFF", "HEIGHT", "SCANNED"]) == named("TAKEOFF", "SCAN", "HOVER")


def test_a_goal_without_a_way_never_takes_off() -> None:
    flown = run(["TASK", "NO_ROUTE", "WAY_EXISTS"], lib.MISSION_TASK_GOTO)
    assert lib.MISSION_SCAN not in flown
    mission, _ = step(Mission(lib.MISSION_IDLE, lib.MISSION_TASK_GOTO), lib.MISSION_EV_NO_ROUTE)
    assert mission == Mission(lib.MISSION_IDLE, lib.MISSION_TASK_NONE)


@given(st.lists(st.sampled_from(list(EVENTS)), max_size=60))
def test_after_any_history_two_events_bring_it_to_the_ground(history: list[int]) -> None:
    mission = Mission(lib.MISSION_IDLE, lib.MISSION_TASK_NONE)
    for event in [*history, lib.MISSION_EV_LAND, lib.MISSION_EV_LANDED]:
        mission, _ = step(mission, event)
    assert not lib.mission_airborne(mission.state)
    assert mission.task == lib.MISSION_TASK_NONE


def test_a_mission_begins_on_the_ground_with_nothing_to_do() -> None:
    c = ffi.new("mission_t *")
    lib.mission_init(c)
    assert (c.state, c.task, c.fault) == (lib.MISSION_IDLE, lib.MISSION_TASK_NONE, lib.MISSION_OK)
