# SPDX-License-Identifier: GPL-3.0-or-later
"""`make mutate` changes code and nothing else, in every file, and knows the tests of each."""

from pathlib import Path

import pytest

from tests.tools.mutate import ROOT, changes, chosen, related_tests

SOURCES = sorted(path for part in ("core", "app") for path in ROOT.glob(f"firmware_app/{part}/*.c"))


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.name)
def test_each_file_has_lines_to_change(source: Path) -> None:
    lines = source.read_text().splitlines()
    drawn = chosen(changes(source.read_text()), 3, "seed")
    assert drawn
    for number, new in drawn:
        assert new != lines[number].partition(" //")[0]


def test_comments_and_preprocessor_lines_are_left_alone() -> None:
    assert changes("#if A < B\n// a < b\n/** a < b\n * a < b */\nint a; // b < c\n") == []
    assert changes("  return a < b; // c < d\n") == [(0, "  return a >= b;")]


def test_the_tests_of_a_file_come_first() -> None:
    assert related_tests(Path("guard.c"))[0] == "tests/core/test_guard.py"
    assert "tests/core/test_selftest.py" not in related_tests(Path("guard.c"))
    assert "tests/core/test_selftest.py" in related_tests(Path("selftest.c"))
