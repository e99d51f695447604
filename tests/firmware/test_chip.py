# SPDX-License-Identifier: GPL-3.0-or-later
"""The emulated chip: its memory ends where the real one's does, and its figures add up."""

import struct

import numpy as np
import pytest

from tests.firmware.build import FLIGHT, HERE, Program, build
from tests.firmware.chip import (
    BOOT_LOADER_BYTES,
    CCM,
    CCM_BYTES,
    FLASH,
    FLASH_BYTES,
    SRAM,
    SRAM_BYTES,
    Chip,
    ChipError,
)
from tests.firmware.flights import FEW
from tests.firmware.replay import STAGES, TICK, replay
from tests.tools.gates import STACK_LIMIT_BYTES, deepest
from tests.tools.objects import call_graph

ASTRAY = Program("astray", (HERE / "astray.c",), (HERE,))
FLIGHT_OF_ALL_STAGES = FEW[0]


def access(what: bytes, address: int) -> bytes:
    return Chip(build(ASTRAY, "firmware")).run(what + struct.pack("<I", address)).output


@pytest.mark.parametrize("address", [SRAM + SRAM_BYTES - 4, CCM + CCM_BYTES - 4])
def test_memory_can_be_written_up_to_its_end(address: int) -> None:
    assert access(b"W", address) == struct.pack("<I", 0x5A5A5A5A)


@pytest.mark.parametrize("address", [FLASH + BOOT_LOADER_BYTES, FLASH + FLASH_BYTES - 4])
def test_flash_can_be_read_and_not_written(address: int) -> None:
    assert len(access(b"R", address)) == 4
    with pytest.raises(ChipError, match="port_main"):
        access(b"W", address)


@pytest.mark.parametrize(
    "address",
    [0, FLASH, FLASH + BOOT_LOADER_BYTES - 4, FLASH + FLASH_BYTES, CCM - 4, CCM + CCM_BYTES,
     SRAM - 4, SRAM + SRAM_BYTES, 0x4000_0000],
    ids=hex,
)  # fmt: skip
@pytest.mark.parametrize("what", [b"R", b"W"])
def test_beside_its_memory_there_is_nothing(what: bytes, address: int) -> None:
    with pytest.raises(ChipError, match="port_main"):
        access(what, address)


def test_the_stages_of_a_tick_are_parts_of_it() -> None:
    cycles = replay(FLIGHT_OF_ALL_STAGES, "firmware").run.cycles
    whole = cycles[TICK].astype(np.int64)
    known = {name: cycles[f].astype(np.int64) for name, f in STAGES.items() if ":" not in name}
    assert (whole - sum(known.values())).max() < 20_000  # taking the input in, and reporting
    known.pop("clearance")  # planning calls for it too
    assert (sum(known.values()) <= whole).all()
    for name, function in STAGES.items():
        assert cycles[function].any(), name
        assert (cycles[function] <= whole).all(), name


def test_the_same_run_costs_the_same() -> None:
    data = bytes(replay(FLIGHT_OF_ALL_STAGES, "firmware").recording.records)[:12_000]
    chip = Chip(build(FLIGHT, "firmware"))
    first, second = (chip.run(data, (TICK,)) for _ in range(2))
    assert first.output == second.output
    assert first.all_cycles == second.all_cycles > first.instructions


@pytest.mark.parametrize("flags", ["strict", "firmware"])
def test_the_stack_is_never_deeper_than_computed(flags: str) -> None:
    done = replay(FLIGHT_OF_ALL_STAGES, flags)
    computed, _ = deepest(call_graph(build(FLIGHT, flags).parent), TICK)
    assert 0 < done.run.stack_bytes[TICK] <= computed <= STACK_LIMIT_BYTES
