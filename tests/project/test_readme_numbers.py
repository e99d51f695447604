# SPDX-License-Identifier: GPL-3.0-or-later
"""Every number in the README comes from what a command has written, or from the tree."""

import re
import shlex
import string
import tomllib
from collections.abc import Callable
from typing import Any

import pytest

from ground.cli.parts import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_USAGE
from ground.core import GRID_SIDE_CELLS, MissionCmd, MissionReason, SelfTest
from ground.record.folder import KEPT_GB
from ground.sim.campaign.explore import COMPLETE
from ground.sim.campaign.figures import NEAR_M
from tests.bench.plan.families import DRAWN
from tests.bench.plan.runs import FIXED_SAMPLES
from tests.bench.slam.flights import LENGTH_S
from tests.project.files import ROOT
from tests.project.readme import BLOCK, LINK, MEASURED, SPAN, TEXT, report

WORDS = ("No", "One", "Two", "Three", "Four", "Five", "Six")
SIZES = re.compile(r"\| (static RAM|of that the one|flash|stack)")  # as test_sizes.py has them
CLAIMS = (ROOT / "tests" / "project" / "claims.txt").read_text()
README = " ".join(re.sub(r"^> ", "", TEXT, flags=re.MULTILINE).split())
DESIGN = " ".join((ROOT / "firmware_app" / "DESIGN.md").read_text().split())
NO_FIGURES = (
    r"Crazyflie 2\.1\+?|2\.1 Brushless|2\.1\+|deck v2|STM32|GAP9|8 x 8",  # hardware
    r"Debian 12, the demo on 13",
    r"C11|WSL 2|ROS 2|Nav2|Crazyswarm2|OMPL 1\.5\.2|GPL-3\.0",  # names
    r"within 1\.0[25]|95 % bound|9[05]th percentile|p95",  # which figure is meant
    r"arm-none-eabi-gcc [\d.]+",  # test_sizes.py knows it
    r"\b(?:19|20)\d\d\b",
)


def from_the_tree() -> dict[str, str]:
    """The oldest Python that is allowed, the firmware that the simulator stands in for, a tick."""
    app = (ROOT / "firmware_app" / "app" / "app_main.c").read_text()
    (tick_ms,) = re.findall(r"\bPERIOD_MS = (\d+)", app)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    simulated = (ROOT / "ground" / "sim" / "crazyflie.py").read_text()
    (firmware,) = re.findall(r'b"([\d.]+) wayflie sim"', simulated)
    return {
        "python": project["requires-python"].removeprefix(">="),
        "firmware": firmware,
        "tick_ms": tick_ms,
    }


FACTS: dict[str, Any] = {
    **{one.name: one.value for one in (*MissionCmd, *SelfTest)},
    **from_the_tree(),
    "ESTIMATOR": MissionReason.ESTIMATOR.value,
    "cells": GRID_SIDE_CELLS,
    "selftest": 1,
    "reached": 0,
    "kept_gb": KEPT_GB,
    "near_m": NEAR_M,
    "complete": COMPLETE,
    "samples": FIXED_SAMPLES,
    "families": len(DRAWN),
    "shortest_min": LENGTH_S[0] / 60,
    "longest_min": LENGTH_S[1] / 60,
    "failed": EXIT_FAILED,
    "usage": EXIT_USAGE,
    "interrupted": EXIT_INTERRUPTED,
}


class Printed(string.Formatter):
    """As str.format, and with what claims.txt says of its formats."""

    def format_field(self, value: Any, spec: str) -> str:  # noqa: ANN401  as its base
        own: dict[str, Callable[[Any], str]] = {
            "n": lambda share: f"{100 * share:.0f}",
            "p": lambda share: f"{100 * share:.0f} %",
            "kB": lambda size_bytes: f"{size_bytes / 1000:.2g} kB",
            "w": lambda count: WORDS[count].lower(),
            "W": lambda count: WORDS[count],
        }
        return own[spec](value) if spec in own else str(super().format_field(value, spec))


def claims(page: str) -> list[tuple[str, str]]:
    """Names of reports, and templates of what that page says by them."""
    found, name, told_in = [], "", ""
    for line in CLAIMS.splitlines():
        if heading := re.fullmatch(r"\[(\w+)(?: in (\w+))?\]", line):
            name, told_in = heading[1], heading[2] or "README"
        elif name and line and told_in == page:
            found.append((name, line))
    return found


def said(name: str, template: str) -> str:
    """The template with its figures."""
    known = dict(FACTS)
    if name != "tree":
        got = report(name)
        known |= got | {"aim": {check["name"]: check["limit"] for check in got["checks"]}}
        known["missed"] = sum(not check["ok"] for check in got["checks"])
        known["limits"] = len(got["checks"])
    return Printed().vformat(template, (), known)


@pytest.mark.parametrize(("name", "template"), claims("README"))
def test_the_readme_says_what_was_measured(name: str, template: str) -> None:
    sentence = said(name, template)
    assert README.count(sentence) == 1, sentence


@pytest.mark.parametrize(("name", "template"), claims("DESIGN"))
def test_the_design_says_what_was_measured(name: str, template: str) -> None:
    sentence = said(name, template)
    assert DESIGN.count(sentence) == 1, sentence


def test_no_number_is_without_a_source() -> None:
    text = BLOCK.sub("", TEXT)
    text = "\n".join(line for line in text.splitlines() if not SIZES.match(line))
    text = " ".join(re.sub(r"^> ", "", text, flags=re.MULTILINE).split())
    for name, template in claims("README"):
        text = text.replace(said(name, template), "")
    text = LINK.sub("", SPAN.sub("", text))
    for pattern in NO_FIGURES:
        text = re.sub(pattern, "", text)
    left = re.findall(r".{0,30}\d.{0,30}", text)
    assert not left, "\n".join(left)


def test_what_is_written_beside_the_figures_is_no_figure() -> None:
    literal = " ".join(re.sub(r"\{[^}]*\}", "", SPAN.sub("", line)) for _, line in claims("README"))
    for pattern in NO_FIGURES:
        literal = re.sub(pattern, "", literal)
    assert set(re.findall(r"\d+", literal)) == set(), literal


def test_each_report_says_by_which_command_and_the_readme_names_it() -> None:
    spans = [shlex.split(span) for span in SPAN.findall(BLOCK.sub("", TEXT))]
    for path in sorted(MEASURED.iterdir()):
        command = shlex.split(report(path.stem)["command"])
        assert any(
            span[:2] == command[:2] and len(span) > 2 and set(span) <= set(command)
            for span in spans
        ), command
