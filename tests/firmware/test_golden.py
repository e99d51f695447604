# SPDX-License-Identifier: GPL-3.0-or-later
"""The self-test on the chip: it agrees, is fast, and notices arithmetic that differs."""

import struct
from pathlib import Path

from ground.core import lib
from tests.firmware.build import HERE, Program, build, core_program
from tests.firmware.chip import CLOCK_HZ, Chip
from tests.tools.objects import CORE

GOLDEN = core_program("golden", "golden.c")
ITS_OWN_S = 0.001  # of one slice: sensing, moving, and the whole map into the hash
DURATION_S = 5.0
PRAGMA = '#pragma GCC optimize("fp-contract=off")\n'


def test_the_self_test_agrees_on_the_chip() -> None:
    run = Chip(build(GOLDEN, "firmware")).run(b"", watch=["selftest_step", "nav_step"])
    number, state = struct.unpack("<IB", run.output)
    assert (f"{number:#x}", state) == (f"{lib.selftest_golden():#x}", lib.SELFTEST_AGREES)
    slices, flight = run.cycles["selftest_step"], run.cycles["nav_step"]
    assert len(slices) == lib.SELFTEST_TICKS
    assert (slices - flight).max() <= ITS_OWN_S * CLOCK_HZ
    assert slices.sum() <= DURATION_S * CLOCK_HZ


def test_a_chip_that_fuses_is_found_out(tmp_path: Path) -> None:
    """With the firmware's flags, but without the pragma that starts the core's files."""
    for path in CORE.glob("*.[ch]"):
        (tmp_path / path.name).write_text(path.read_text().replace(PRAGMA, ""))
    sources = (HERE / "golden.c", *sorted(tmp_path.glob("*.c")))
    fused = Program("golden-fused", sources, (HERE, tmp_path))
    number, state = struct.unpack("<IB", Chip(build(fused, "firmware")).run(b"").output)
    assert (state, number == lib.selftest_golden()) == (lib.SELFTEST_DIFFERS, False)
