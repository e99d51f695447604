# SPDX-License-Identifier: GPL-3.0-or-later
"""The README's table of memory agrees with the measured sizes."""

import re

import pytest

from tests.project.files import ROOT
from tests.tools.needed import need
from tests.tools.objects import CHIP, compile_tree
from tests.tools.sizes import readme_rows

TEXT = (ROOT / "README.md").read_text()
OTHER_COMPILER = 0.05


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    need("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi", "the table of memory")
    return readme_rows(compile_tree(CHIP, tmp_path_factory.mktemp("objects")))


def used(row: str) -> int:
    (number,) = re.findall(r"([\d,]+) bytes", row)
    return int(number.replace(",", ""))


def test_the_readme_tells_the_measured_sizes(measured: list[str]) -> None:
    """If not, copy the table from the end of what `make sizes` prints."""
    (compiler,) = re.findall(r"arm-none-eabi-gcc ([\d.]+)", TEXT)
    first = TEXT.index(measured[0].partition(" |")[0])
    told = TEXT[first:].splitlines()[: len(measured)]
    if CHIP.run("gcc", "-dumpfullversion").startswith(compiler):
        assert told == measured
    else:
        assert [used(row) for row in told] == [
            pytest.approx(used(row), rel=OTHER_COMPILER) for row in measured
        ]
