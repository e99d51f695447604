# SPDX-License-Identifier: GPL-3.0-or-later
"""The app itself on the chip: a whole flight call by call, its stack, and the cost of a period."""

from dataclasses import replace

import numpy as np
import pytest

from ground.core import EventCode, MissionState
from tests.bench.cycles import AROUND_LIMIT_CYCLES, SAFETY
from tests.firmware.app_flights import FEW
from tests.firmware.app_replay import APP_STAGES, PERIOD, AppReplay, replay_app
from tests.firmware.build import APP, app_stack_bytes, build
from tests.firmware.chip import Chip, ChipError
from tests.firmware.replay import TICK
from tests.tools.gates import STACK_LIMIT_BYTES, deepest
from tests.tools.objects import call_graph

SWITCH_BYTES = 204  # what FreeRTOS saves on a task's stack when another runs


@pytest.fixture(scope="module")
def done() -> AppReplay:
    return replay_app(FEW[0], "firmware")


def test_the_app_says_on_the_chip_what_it_says_here(done: AppReplay) -> None:
    assert done.difference is None
    assert MissionState.FOLLOW in done.flown.states and MissionState.LAND in done.flown.states
    assert EventCode.ARRIVED in done.flown.events
    told = b"".join(done.flown.recording.outcomes)
    assert b"way.height refused" in told and b"command 2 refused" in told


def test_a_difference_of_one_bit_is_found(done: AppReplay) -> None:
    recording = done.flown.recording
    there = bytearray(recording.outcome)
    assert recording.first_difference(bytes(there)) is None
    assert recording.first_difference(bytes(there[:-1])) is not None
    there[len(there) // 2] ^= 1
    assert recording.first_difference(bytes(there)) is not None


def test_the_stack_of_the_task_is_large_enough(done: AppReplay) -> None:
    assert app_stack_bytes() == STACK_LIMIT_BYTES + SWITCH_BYTES
    assert 0 < done.stack_bytes <= STACK_LIMIT_BYTES


def test_the_stack_is_never_deeper_than_computed(done: AppReplay) -> None:
    computed, _ = deepest(call_graph(build(APP, "firmware").parent))
    assert done.stack_bytes <= computed


def test_a_stack_that_overflows_ends_the_run(done: AppReplay) -> None:
    small = replace(APP, name="app-small", flags=("-DAPP_STACK_BYTES=768",))
    calls = bytes(done.flown.recording.calls)
    with pytest.raises(ChipError, match="sp 0x"):
        Chip(build(small, "firmware")).run(calls)


def test_a_period_is_the_tick_and_little_more(done: AppReplay) -> None:
    cycles = {name: column.astype(np.int64) for name, column in done.run.cycles.items()}
    flew = cycles[TICK] > 0
    assert np.count_nonzero(~flew) == 1  # the start
    around = cycles[PERIOD] - cycles[TICK]
    assert SAFETY * around[flew].max() <= AROUND_LIMIT_CYCLES
    parts = sum(cycles[function] for function in APP_STAGES.values())
    assert (parts <= cycles[PERIOD]).all()
    assert (cycles[PERIOD] - parts)[flew].max() < 5_000  # waking and sleeping
