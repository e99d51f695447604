# SPDX-License-Identifier: GPL-3.0-or-later
"""The README is short, and begins as a newcomer reads it."""

import re

from tests.project.readme import TEXT, code

LINES_MAX = 199
COLUMNS_MAX = 120
SECTIONS = (
    "Measured", "On a drone", "Using it", "What four beams", "Beside", "Sources", "Contributing",
)  # fmt: skip


def test_it_is_short_enough_to_be_read() -> None:
    lines = TEXT.splitlines()
    assert len(lines) <= LINES_MAX
    assert [line for line in lines if len(line) > COLUMNS_MAX and not line.startswith("|")] == []


def test_one_sentence_two_pictures_and_two_commands_come_first() -> None:
    name, empty, sentence = TEXT.splitlines()[:3]
    assert (name, empty) == ("# Wayflie", "")
    assert sentence.startswith("A stock Crazyflie")
    assert len(re.findall(r"^!\[", TEXT[: TEXT.index("```sh")], re.MULTILINE)) == 2
    assert [line.split("#")[0].split() for line in code("sh")[0].splitlines()] == [
        ["make", "demo"],
        ["make", "test"],
    ]


def test_its_sections_are_in_their_order() -> None:
    headings = re.findall(r"^## (.*)$", TEXT, re.MULTILINE)
    assert len(headings) == len(SECTIONS)
    assert all(map(str.startswith, headings, SECTIONS))


def test_it_says_plainly_that_it_was_not_flown() -> None:
    assert "No flight on real hardware has been made by this project." in " ".join(TEXT.split())


def test_no_placeholder_is_left() -> None:
    assert re.findall(r"^[A-Z]{4,}$", TEXT, re.MULTILINE) == []
