# SPDX-License-Identifier: GPL-3.0-or-later
"""The self-test, run by the chip: it agrees, soon, and costs little more than the flight itself."""

import struct

import pytest

from ground.core import lib
from tests.firmware.build import FLAG_SETS, build, core_program
from tests.firmware.chip import CLOCK_HZ, Chip

GOLDEN = core_program("golden", "golden.c")
ITS_OWN_S = 0.001  # of one slice: sensing, moving, and the whole map into the hash
DURATION_S = 5.0


@pytest.mark.parametrize("flags", FLAG_SETS)
def test_the_self_test_agrees_on_the_chip(flags: str) -> None:
    run = Chip(build(GOLDEN, flags)).run(b"", watch=["selftest_step", "nav_step"])
    number, state = struct.unpack("<IB", run.output)
    assert (f"{number:#x}", state) == (f"{lib.selftest_golden():#x}", lib.SELFTEST_AGREES)
    slices, flight = run.cycles["selftest_step"], run.cycles["nav_step"]
    assert len(slices) == lib.SELFTEST_TICKS
    assert (slices - flight).max() <= ITS_OWN_S * CLOCK_HZ
    assert slices.sum() <= DURATION_S * CLOCK_HZ
