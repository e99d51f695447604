# SPDX-License-Identifier: GPL-3.0-or-later
"""Absurd inputs under the address and undefined-behaviour sanitizers: nothing breaks."""

import subprocess
from pathlib import Path

import pytest

from ground.core import lib
from tests.tools.objects import CORE, HOST

TICKS = 30_000
SEEDS = range(16)
SANITIZERS = (
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all",
)


@pytest.fixture(scope="module")
def fuzzer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = tmp_path_factory.mktemp("fuzz") / "fuzz_nav"
    source = Path(__file__).with_name("fuzz_nav.c")
    HOST.run(
        "gcc", "-std=c11", "-O1", "-g", *SANITIZERS, f"-I{CORE}", source,
        *sorted(CORE.glob("*.c")), "-lm", "-o", program,
    )  # fmt: skip
    return program


def run(fuzzer: Path, seed: int) -> int:
    """States that were met, as bits."""
    done = subprocess.run([fuzzer, str(seed), str(TICKS)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return int(done.stdout, 16)


def test_nothing_absurd_breaks_it_and_every_state_is_met(fuzzer: Path) -> None:
    states = 0
    for seed in SEEDS:
        states |= run(fuzzer, seed)
    assert states == (1 << lib.MISSION_STATES) - 1
