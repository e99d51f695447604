# SPDX-License-Identifier: GPL-3.0-or-later
"""Two hundred flights to goals in worlds that no number was chosen on."""

import json
from typing import Any

import pytest
from typer.testing import CliRunner

from ground.cli import app

SEED = 4711
MISSIONS = 200


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
    assert found["collisions"] <= 2, found["failures"]
    assert found["reached_fraction"] > 0.9, found["failures"]
    assert found["unreachable_reported_fraction"] > 0.85, found["failures"]
    assert found["length_ratio_median"] < 1.25
