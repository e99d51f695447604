# SPDX-License-Identifier: GPL-3.0-or-later
"""A minute of fuzzing, under the address and undefined-behaviour sanitizers; longer: make fuzz."""

import os
from pathlib import Path

import pytest

from tests.tools.fuzz import TARGETS, fuzz
from tests.tools.needed import need

SECONDS = 24 if os.environ.get("CI") == "true" else 12


@pytest.mark.parametrize("target", TARGETS)
def test_nothing_that_comes_in_breaks_it(target: str, tmp_path: Path) -> None:
    need("clang", "clang libclang-rt-14-dev", f"{target} by fuzzing")
    assert fuzz(target, SECONDS, tmp_path) == ""
