# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: help that helps, errors of one line, exit codes."""

import json
import socket
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ground.checks import Check, write_report
from ground.cli import app

COMMANDS = ("demo", "sim", "ground", "goto", "explore", "home", "land", "stop", "map", "replay")


@pytest.fixture
def dead_uri() -> str:
    """Nobody answers there."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    return f"udp://127.0.0.1:{port}"


def test_help_names_all_commands_and_what_to_try_first() -> None:
    result = CliRunner().invoke(app, ["--help"])
    assert result.exit_code == 0
    assert "Try first: wayflie demo" in " ".join(result.output.split())
    for command in COMMANDS:
        assert command in result.output


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_help(command: str) -> None:
    result = CliRunner().invoke(app, [command, "--help"])
    assert result.exit_code == 0
    assert "Usage" in result.output


@pytest.mark.parametrize("arguments", [["goto", "1", "-2"], ["land"], ["explore"], ["stop"]])
def test_nobody_there_is_one_line_and_exit_1(arguments: list[str], dead_uri: str) -> None:
    result = CliRunner().invoke(app, [*arguments, "--uri", dead_uri])
    assert result.exit_code == 1
    assert result.stderr.splitlines() == [
        f"wayflie: nobody answers at {dead_uri} (connection refused)"
    ]


def test_uri_may_come_from_the_environment(dead_uri: str) -> None:
    result = CliRunner().invoke(app, ["home"], env={"CFLIB_URI": dead_uri})
    assert result.exit_code == 1
    assert dead_uri in result.stderr


def test_a_uri_of_no_driver_is_told() -> None:
    result = CliRunner().invoke(app, ["land", "--uri", "carrier-pigeon://1"])
    assert result.exit_code == 1
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize("arguments", [["goto", "one", "2"], ["goto", "1"], ["fly"], ["land", "7"]])
def test_wrong_usage_is_exit_2(arguments: list[str]) -> None:
    assert CliRunner().invoke(app, arguments).exit_code == 2


def test_an_unknown_world_is_told() -> None:
    result = CliRunner().invoke(app, ["demo", "--headless", "--world", "atlantis"])
    assert result.exit_code == 1
    assert "atlantis" in result.stderr


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
