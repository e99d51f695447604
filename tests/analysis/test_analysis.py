# SPDX-License-Identifier: GPL-3.0-or-later
"""Each static analyser of `make analyse` reports a planted fault; CI runs them on the C code."""

import subprocess
from pathlib import Path

import pytest

from tests.tools.analyse import CLANG_WARNINGS, CPPCHECK, GCC_WARNINGS, READERS, ROOT
from tests.tools.needed import need

FAULTS = {
    "gcc": "float f(int n);\nfloat f(int n) {\n  return n * 0.1;\n}\n",
    "clang": "int f(int n) {\n  return n;\n}\n",
    "clang-tidy": "int f(int n) {\n  const int *p = 0;\n  return n > 3 ? *p : n;\n}\n",
    "cppcheck": "int f(void) {\n  int a[3] = {0, 0, 0};\n  return a[3];\n}\n",
}
COMMANDS = {
    "gcc": ["gcc", "-O2", *GCC_WARNINGS, "-fsyntax-only"],
    "clang": ["clang", *CLANG_WARNINGS, "-fsyntax-only"],
    "clang-tidy": ["clang-tidy", "--quiet", f"--config-file={ROOT / '.clang-tidy'}"],
    "cppcheck": [*CPPCHECK],
}


@pytest.mark.parametrize("name", READERS)
def test_it_finds_a_fault(name: str, tmp_path: Path) -> None:
    need(name, READERS[name].package, f"that {name} finds a fault")
    (tmp_path / "fault.c").write_text(FAULTS[name])
    command = [*COMMANDS[name], tmp_path / "fault.c"]
    extra = ["--"] if name == "clang-tidy" else []
    assert subprocess.run([*command, *extra], cwd=ROOT, capture_output=True).returncode != 0
