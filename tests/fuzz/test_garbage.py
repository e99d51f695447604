# SPDX-License-Identifier: GPL-3.0-or-later
"""Some seconds of nonsense for each decoder in Python; longer: make fuzz."""

import os

import pytest

from tests.tools.fuzz_python import TARGETS, fuzz

SECONDS = float(os.environ.get("FUZZ_SECONDS", "3"))


@pytest.mark.parametrize("target", TARGETS)
def test_no_nonsense_breaks_a_decoder(target: str) -> None:
    cases, trouble = fuzz(target, SECONDS)
    assert not trouble, trouble
    assert cases > 0
