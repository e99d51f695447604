# SPDX-License-Identifier: GPL-3.0-or-later
"""Python's enums are those of C, complete, and all have words."""

from enum import IntEnum, IntFlag

import pytest

from ground import core
from ground.core import ffi
from ground.core_build import CORE, header_order
from ground.words import COMMAND_WORDS, REASON_WORDS, SELF_TEST_WORDS, STATE_WORDS

MIRRORS: list[tuple[type[IntEnum | IntFlag], str, str, set[str]]] = [
    (core.MissionCmd, "mission_cmd_t", "MISSION_CMD_", {"MISSION_CMDS"}),
    (core.MissionState, "mission_state_t", "MISSION_", {"MISSION_STATES"}),
    (core.MissionReason, "mission_reason_t", "MISSION_", {"MISSION_REASONS"}),
    (core.WireType, "wire_type_t", "WIRE_", set()),
    (core.WireStatus, "wire_status_t", "WIRE_", set()),
    (core.EventCode, "wire_event_code_t", "WIRE_EVENT_", set()),
    (core.Capability, "wire_capability_t", "WIRE_CAP_", set()),
    (core.SelfTest, "selftest_state_t", "SELFTEST_", set()),
    (core.CellState, "grid_state_t", "GRID_CELL_", set()),
]


@pytest.mark.parametrize(("mirror", "ctype", "prefix", "counters"), MIRRORS)
def test_enum_has_every_enumerator_of_c(
    mirror: type[IntEnum | IntFlag], ctype: str, prefix: str, counters: set[str]
) -> None:
    names = {name: value for name, value in ffi.typeof(ctype).relements.items()}
    expected = {n.removeprefix(prefix): v for n, v in names.items() if n not in counters}
    assert {member.name: member.value for member in mirror} == expected


def test_everything_has_words() -> None:
    assert set(STATE_WORDS) == set(core.MissionState)
    assert set(REASON_WORDS) == set(core.MissionReason)
    assert set(COMMAND_WORDS) == set(core.MissionCmd)
    assert set(SELF_TEST_WORDS) == set(core.SelfTest)
    for table in (STATE_WORDS, REASON_WORDS, COMMAND_WORDS, SELF_TEST_WORDS):
        for words in table.values():
            assert words.strip() and "\n" not in words


def test_headers_come_after_what_they_include() -> None:
    order = header_order(CORE)
    assert set(order) == {path.name for path in CORE.glob("*.h")}
    assert order.index("geometry.h") < order.index("grid.h") < order.index("nav.h")


def test_motors_run_in_all_states_but_idle_and_fault() -> None:
    still = {state for state in core.MissionState if not state.airborne}
    assert still == {core.MissionState.IDLE, core.MissionState.FAULT}
