# SPDX-License-Identifier: GPL-3.0-or-later
"""Half a minute of fuzzing, with address and undefined-behaviour sanitizers; longer: make fuzz."""

import os
from pathlib import Path

import pytest

from tests.tools.fuzz import TARGETS, fuzz, objects
from tests.tools.needed import need

SECONDS = 24 if os.environ.get("CI") == "true" else 6


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Path]]:
    need("clang", "clang libclang-rt-14-dev", "by fuzzing that nothing breaks the C code")
    return objects(tmp_path_factory.mktemp("objects"))


@pytest.mark.parametrize("target", TARGETS)
def test_nothing_that_comes_in_breaks_it(
    target: str, compiled: dict[str, list[Path]], tmp_path: Path
) -> None:
    assert fuzz(target, SECONDS, compiled, tmp_path) == ""
