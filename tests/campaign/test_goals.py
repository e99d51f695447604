# SPDX-License-Identifier: GPL-3.0-or-later
"""Flights to goals in worlds that no constant was tuned on; two hundred of them in CI."""

import json
import os
from typing import Any

import pytest
from typer.testing import CliRunner

from ground.cli.app import app

SEED = 4711
MANY, FEW = (200, 2, 0.85), (40, 0, 0.6)
"""Missions, how many of them may collide, how much of what cannot be reached must be reported."""
MISSIONS, COLLISIONS_MAX, REPORTED = MANY if os.environ.get("CI") == "true" else FEW


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    report = tmp_path_factory.mktemp("campaign") / "out.json"
    arguments = ["--seed", str(SEED), "--missions", str(MISSIONS), "--json", str(report)]
    CliRunner().invoke(app, ["campaign", *arguments, "--workers", "2"])
    figures: dict[str, Any] = json.loads(report.read_text())
    return figures


@pytest.mark.timeout(1800)
def test_they_are_flown_and_judged(found: dict[str, Any]) -> None:
    assert found["missions"] == MISSIONS
    assert found["causes"].get("error", 0) == 0, found["failures"]
    assert found["collisions"] <= COLLISIONS_MAX, found["failures"]
    assert found["reached_fraction"] > 0.9, found["failures"]
    assert found["unreachable_reported_fraction"] > REPORTED, found["failures"]
    assert found["length_ratio_median"] < 1.25
