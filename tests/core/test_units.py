# SPDX-License-Identifier: GPL-3.0-or-later
"""Names carry their units: each float in a core header ends in one, or is a known ratio."""

import re
from pathlib import Path

import pytest

from tests.tools.objects import CORE

UNITS = {
    "m", "m2", "m3", "s", "s2", "ms", "us", "rad", "rad2", "mps", "mps2", "m2ps2", "rps", "v",
    "cells", "logodds", "per_m", "per_s", "per_cell", "s_per_m",
}  # fmt: skip
# Names without a unit: components, ratios, and what has the unit of its argument.
PLAIN = {
    "correction",
    "prior", "posterior", "inverse", "off",
    "x", "y", "sin", "cos", "a", "b", "v", "p", "value", "low", "high", "factor", "fraction",
    "max_norm", "stop_ratio", "t_x", "t_y", "dt_x", "dt_y", "away", "robust", "information",
    "lead", "score", "weight", "scale", "scale_sd", "covariance", "hessian", "gradient", "points",
    "fit", "stretch", "turns", "normal",
}  # fmt: skip
DECLARATION = re.compile(
    r"\b(?:float|vec2_t)\s+\*?([a-z0-9_]+(?:\s*,\s*[a-z0-9_]+)*)\s*(?=[;,)\[])"
)


def without_comments(path: Path) -> str:
    text = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL)
    return re.sub(r"//[^\n]*", "", text)


def names(path: Path) -> list[str]:
    found = DECLARATION.findall(without_comments(path))
    return [name.strip() for group in found for name in group.split(",")]


def has_unit(name: str) -> bool:
    return any(name.endswith(f"_{unit}") or name == unit for unit in UNITS)


@pytest.mark.parametrize("path", sorted(CORE.glob("*.h")), ids=lambda path: path.name)
def test_every_float_says_its_unit(path: Path) -> None:
    assert [n for n in names(path) if not has_unit(n) and n not in PLAIN] == []


def test_the_search_finds_declarations() -> None:
    assert len(names(CORE / "nav.h")) > 15
    assert "range_m" in names(CORE / "scan.h")
    assert "origin_m" in names(CORE / "grid.h")


def test_no_angle_is_in_degrees_and_no_length_in_millimetres() -> None:
    for path in sorted(CORE.glob("*.h")):
        wrong = re.findall(r"\bfloat\s+\w*_(?:deg|mm|cm|dps)\b", without_comments(path))
        assert wrong == [], path.name
