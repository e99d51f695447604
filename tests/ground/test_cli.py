# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: help, errors with the next step, exit codes, figures as JSON."""

import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console
from typer.testing import CliRunner

from ground.checks import Check, write_report
from ground.cli import start
from ground.cli.app import app
from ground.cli.parts import EXITS, finish
from ground.core import MissionReason
from ground.nextsteps import after
from ground.progress import bar, waiting

MEASURING = (
    "demo", "sim", "goto", "explore", "fly", "patrol", "spin", "home", "land", "stop", "scan",
    "doctor", "map save", "map load", "replay", "campaign", "bench chip", "bench slam",
    "bench reloc", "bench plan", "bench link", "bench page",
)  # fmt: skip
COMMANDS = (*MEASURING, "ground", "plot", "map", "bench")


@pytest.fixture
def dead_uri() -> Iterator[str]:
    """A URI at which nobody answers, as its socket hears only itself."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as held:
        held.bind(("127.0.0.1", 0))
        held.connect(held.getsockname())
        yield f"udp://127.0.0.1:{held.getsockname()[1]}"


def run(*words: str) -> Any:  # noqa: ANN401  its class depends on typer's version
    return CliRunner().invoke(app, words)


def helped(command: str) -> str:
    result = run(*command.split(), "--help")
    assert result.exit_code == 0
    return str(result.output)


def test_alone_it_shows_what_to_try_first_in_commands_that_exist() -> None:
    result = run()
    assert result.exit_code == 0
    lines = [line for lines in start.DAY.values() for line in lines]
    assert lines[0] == "wayflie demo"
    for line in lines:
        assert line in result.output
        assert re.match(r"wayflie [a-z]", line)
        words = line.replace("map save", "map-save").split()[1]
        assert words.replace("-", " ") in COMMANDS
    assert max(map(len, result.output.splitlines())) <= 80


def test_help_names_all_commands_and_the_exit_codes() -> None:
    told = " ".join(helped("").split())
    for command in COMMANDS:
        assert f" {command.split()[0]} " in told
    assert EXITS.replace("`", "") in told


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_help(command: str) -> None:
    told = helped(command)
    assert f"Usage: wayflie {command}" in told.replace("root", "wayflie")
    assert bool(re.search(r"^│ --json", told, re.MULTILINE)) == (command in MEASURING)


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("wayflie go", "goto"),
        ("wayflie map s", "save"),
        ("wayflie sim --prof", "--profile"),
        ("wayflie campaign --kind mov", "moving"),
        ("wayflie demo --world cl", "clutter"),
    ],
)
def test_a_shell_completes(typed: str, offered: str) -> None:
    count = str(len(typed.split()) - 1)
    environment = os.environ | {
        "_WAYFLIE_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": count,
    }  # fmt: skip
    command = [sys.executable, "-m", "ground"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.stdout.split() == [offered]


@pytest.mark.parametrize("arguments", [["goto", "1", "-2"], ["land"], ["explore"], ["stop"]])
def test_nobody_there_is_one_line_what_to_do_and_exit_1(
    arguments: list[str], dead_uri: str
) -> None:
    result = run(*arguments, "--uri", dead_uri)
    assert result.exit_code == 1
    assert result.stderr.splitlines() == [
        f"wayflie: nobody answers at {dead_uri} (connection refused)",
        "  next: start a simulator: `wayflie sim`, in another terminal",
    ]
    assert result.stdout == ""


def test_json_goes_to_standard_output_and_words_beside_it(dead_uri: str, tmp_path: Path) -> None:
    result = run("doctor", "--uri", dead_uri, "--json", "-")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["findings"][-1]["next_step"]
    assert "nobody answers" in result.stderr
    result = run("explore", "--uri", dead_uri, "--json", str(tmp_path / "out.json"))
    assert (result.exit_code, result.stdout) == (1, "")
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["reached"] is False
    assert "nobody answers" in told["sentence"] and "wayflie sim" in told["next_step"]
    assert run("doctor", "--uri", dead_uri).stdout != ""


@pytest.mark.parametrize(
    "typed",
    [
        "goto 1 2 --json", "goto 1 2 --record", "map save", "map save a.png --from b --poses",
        "campaign --plot", "campaign --resume", "campaign --only 1 --world", "plot b --image",
        "replay b --rerun --into", "sim --record-inputs", "sim --eeprom",
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_written_is_told_before_anything_flies(typed: str) -> None:
    result = run(*typed.split(), "/nowhere/a.png")
    assert result.exit_code == 2
    assert "there is no folder /nowhere" in result.stderr


def test_a_file_that_cannot_be_opened_is_told_in_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    def work() -> bool:
        Path("/").write_text("")
        return True

    with pytest.raises(SystemExit, match="1"):
        finish(work)
    assert capsys.readouterr().err == "wayflie: /: Is a directory\n"


def test_uri_may_come_from_the_environment(dead_uri: str) -> None:
    result = CliRunner().invoke(app, ["home"], env={"CFLIB_URI": dead_uri})
    assert result.exit_code == 1
    assert dead_uri in result.stderr


@pytest.mark.parametrize(
    ("typed", "named"),
    [
        ("goto one 2", "'X'"), ("goto 1", "'Y'"), ("goto 1 nan", "nan"), ("fly", "X,Y"),
        ("fly 1", "'1'"), ("fly 1,inf", "inf"), ("land 7", "(7)"), ("launch", "launch"),
        ("land --uri carrier-pigeon://1", "carrier-pigeon"), ("sim --profile none", "perfect"),
        ("sim --speed -1", "speed"), ("sim --loss 2", "loss"),
        ("sim --world atlantis", "clutter"), ("demo --headless --world atlantis", "clutter"),
        ("campaign --kind none", "moving"), ("campaign --set a", "PARAMETER=NUMBER"),
        ("map save room.txt", ".yaml"), ("plot no.mcap --image room.txt", ".svg"),
        ("spin --turns 99", "20"), ("bench slam --against a", "pf"),
        ("replay a.mcap --json -", "--rerun"), ("map save a.png --poses b.csv", "--from"),
        ("campaign --world a.toml", "--only"), ("ground --uri foo://1", "foo://1"),
        ("ground --uri udp://a:1@1,inf", "inf"), ("sim --speed 0", "--speed"),
        ("map load a.yaml --pose 1,2,nan", "nan"), ("sim --eeprom README.md", "README.md"),
        ("fly 1,2,3", "X,Y in metres"),
    ],
)  # fmt: skip
def test_wrong_usage_is_exit_2_and_says_what_is_wrong(typed: str, named: str) -> None:
    result = run(*typed.split())
    assert result.exit_code == 2
    assert named in result.stderr


def test_every_reason_of_a_refusal_has_a_next_step() -> None:
    obvious = {
        MissionReason.OK,
        MissionReason.BAD_VALUE,
        MissionReason.UNKNOWN_COMMAND,
        MissionReason.NOT_FLYING,
        MissionReason.BUSY,  # its words say it
    }
    assert {reason for reason in MissionReason if not after(reason)} <= obvious


def test_without_the_compiled_core_it_says_what_to_do(tmp_path: Path) -> None:
    lacking = (
        "import sys; sys.modules['ground._core'] = None; from ground.cli.app import main; main()"
    )
    for words in ([], ["--help"], ["goto", "1", "2"]):
        command = [sys.executable, "-c", lacking, *words]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == (1 if "goto" in words else 0), done.stderr
    assert done.stderr.splitlines()[-1].startswith("  next: `make setup`")
    assert len(done.stderr.splitlines()) == 2


def test_progress_is_quiet_where_output_is_piped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    with (tmp_path / "out").open("w+") as file:
        console = Console(file=file)
        with waiting(console, "long"), bar(console) as progress:
            progress.update(progress.add_task("longer", total=1.0), completed=1.0)
        assert file.tell() == 0
        console = Console(file=file, force_terminal=True)
        with waiting(console, "long"):
            pass
        assert file.tell() > 0


def test_version() -> None:
    result = CliRunner().invoke(app, ["--version"])
    assert result.output.startswith("wayflie ")
    assert result.exit_code == 0


@pytest.mark.parametrize(
    ("check", "ok"),
    [
        (Check("error_m", 0.1, 0.25, "<="), True),
        (Check("error_m", 0.3, 0.25, "<="), False),
        (Check("factor", 20.0, 20.0, ">="), True),
        (Check("reached", True, True, "=="), True),
        (Check("collisions", 1, 0, "=="), False),
        (Check("error_m", None, 0.25, "<="), False),
        (Check("error_m", float("nan"), 0.25, "<="), False),
    ],
)
def test_checks(check: Check, ok: bool, tmp_path: Path) -> None:
    assert check.ok is ok
    write_report(tmp_path / "out.json", {"a": 1}, [check])
    report = json.loads((tmp_path / "out.json").read_text())
    assert report["a"] == 1
    assert report["checks"][0]["ok"] is ok
    assert set(report["checks"][0]) == {"name", "value", "limit", "sense", "ok"}
