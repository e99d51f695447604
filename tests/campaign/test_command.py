# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie campaign` as a whole: figures, rows, replay by seed, resuming after an interruption."""

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import get_args

import pytest
from typer.testing import CliRunner

from ground.cli.app import app
from ground.cli.campaign import Kind
from ground.cli.parts import EXIT_INTERRUPTED
from ground.sim.campaign.figures import checks, figures
from ground.sim.campaign.flights import Mission, kinds, row_of
from ground.sim.campaign.rows import RowFile
from ground.sim.worldfile import read_world

SEED = 16
MISSIONS = 3


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(
        app, ["campaign", "--seed", str(SEED), "--workers", "1", *arguments]
    )
    return result.exit_code, result.output


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all files that a small campaign writes."""
    folder = tmp_path_factory.mktemp("campaign")
    code, output = run(
        *("--missions", str(MISSIONS), "--resume", str(folder / "rows.csv")),
        *("--json", str(folder / "out.json"), "--plot", str(folder / "out.png")),
    )
    failed = [check for check in report(folder)["checks"] if not check["ok"]]
    assert code == bool(failed), output
    return folder


def report(folder: Path) -> dict:
    return json.loads((folder / "out.json").read_text())


def test_it_tells_figures_and_checks(flown: Path) -> None:
    found = report(flown)
    assert found["missions"] == MISSIONS
    assert found["reachable"] + found["unreachable"] == MISSIONS
    assert {check["name"] for check in found["checks"]} >= {"collisions", "reached_fraction"}
    assert found["realtime_factor"] > 0
    assert (flown / "out.png").read_bytes().startswith(b"\x89PNG")


def rows(path: Path) -> dict[str, dict[str, str]]:
    """The rows by number, without what depends on the machine."""
    with path.open() as file:
        found = {row["number"]: row for row in csv.DictReader(file)}
    for row in found.values():
        del row["wall_s"]
    return found


def test_each_mission_has_a_row_that_flying_it_again_repeats(flown: Path, tmp_path: Path) -> None:
    kept = rows(flown / "rows.csv")
    assert sorted(kept) == [str(number) for number in range(MISSIONS)]
    again = RowFile(tmp_path / "again.csv")
    again.append(row_of(Mission("goto", SEED, MISSIONS - 1)))
    assert rows(tmp_path / "again.csv") == {str(MISSIONS - 1): kept[str(MISSIONS - 1)]}


def test_an_interrupted_campaign_goes_on_where_it_was(flown: Path, tmp_path: Path) -> None:
    whole = (flown / "rows.csv").read_text().splitlines(keepends=True)
    kept = tmp_path / "rows.csv"
    kept.write_text("".join(whole[:-2]) + whole[-2][:17])  # killed while it wrote
    run("--missions", str(MISSIONS), "--resume", str(kept))
    assert rows(kept) == rows(flown / "rows.csv")
    assert "".join(whole[:-2]) == "".join(kept.read_text().splitlines(keepends=True)[:-2])


def test_ctrl_c_leaves_whole_rows(tmp_path: Path) -> None:
    kept = tmp_path / "rows.csv"
    command = [sys.executable, "-m", "ground", "campaign", "--seed", str(SEED), "--missions", "500"]
    command += ["--workers", "1", "--resume", str(kept)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as flying:
        while not kept.exists() or len(kept.read_text().splitlines()) < 3:
            assert flying.poll() is None
            time.sleep(0.2)
        flying.send_signal(signal.SIGINT)
        assert flying.wait() == EXIT_INTERRUPTED
    assert kept.read_text().endswith("\n")
    found = RowFile(kept).read()
    assert 2 <= len(found) < 500
    assert {row.number for row in found} == set(range(len(found)))


def test_rows_of_another_campaign_are_refused(flown: Path) -> None:
    code, output = run("--missions", "2", "--resume", str(flown / "rows.csv"))
    assert code == 1
    assert "another campaign" in " ".join(output.split())


def test_one_mission_flown_again_leaves_its_world_and_a_picture(tmp_path: Path) -> None:
    world, picture = tmp_path / "again.toml", tmp_path / "again.png"
    run("--only", "0", "--world", str(world), "--plot", str(picture))
    spec = read_world(world)
    assert spec.eeprom["way.cell"] >= 0.05
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_each_kind_that_is_offered_can_be_flown_and_judged() -> None:
    assert set(get_args(Kind)) == set(kinds())
    for kind in kinds():
        assert {check.name for check in checks(kind, figures([]), 1)} >= {"missions", "collisions"}
