# SPDX-License-Identifier: GPL-3.0-or-later
"""The README is true.

Rule: every line of a fenced block marked ``sh``, and every code span that begins with `make` or
`wayflie`, is a command that exists. `make` lines may name only targets of `make help`, with
variables that the Makefile reads; `wayflie` lines must be accepted, with their options and
arguments, by the command line's own parser (nothing is flown here: CI runs the demo itself).
Every relative link leads to a file, and no placeholder is left.
"""

import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import click
import pytest
import typer

from ground.cli import app
from ground.sim.command import sim
from tests.project.files import ROOT

README = ROOT / "README.md"
TEXT = README.read_text()
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
SPAN = re.compile(r"`((?:make|wayflie) [^`]+)`")
LINES_MAX = 200


def shell_lines() -> list[str]:
    blocks = [body for kind, body in BLOCK.findall(TEXT) if kind == "sh"]
    return [line for body in blocks for line in body.splitlines() if line.strip()]


def commands() -> list[str]:
    return shell_lines() + SPAN.findall(BLOCK.sub("", TEXT))


def make_targets() -> set[str]:
    make = ["make", "--no-print-directory", "help"]
    printed = subprocess.run(make, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return set(re.findall(r"^  make (\S+)", printed, re.MULTILINE))


def check_make(words: list[str]) -> None:
    makefile = (ROOT / "Makefile").read_text()
    for word in words:
        name, is_variable, _ = word.partition("=")
        if is_variable:
            assert f"$({name})" in makefile or f"$(if $({name})" in makefile, name
        else:
            assert name in make_targets()


def check_wayflie(words: list[str]) -> None:
    """Parse as the command would, without running it."""
    command: click.Command = typer.main.get_command(app)
    if words[:1] == ["sim"]:
        simulator = typer.Typer(add_completion=False)
        simulator.command()(sim)
        command, words = typer.main.get_command(simulator), words[1:]
    context = None
    while hasattr(command, "commands"):
        assert words, "a command is missing"
        assert words[0] in command.commands, f"wayflie has no command {words[0]}"
        command, words = command.commands[words[0]], words[1:]
    if "--help" not in words:
        context = command.make_context(str(command.name), list(words))
    assert context is None or context.params is not None


@pytest.mark.parametrize("line", commands())
def test_every_command_exists(line: str) -> None:
    program, *words = shlex.split(line, comments=True)
    if program == "make":
        check_make(words)
    elif Path(program).name == "wayflie":
        check_wayflie(words)
    else:
        pytest.fail(f"neither make nor wayflie: {line}")


def test_there_are_commands_to_check() -> None:
    assert len(shell_lines()) >= 5
    assert "make demo" in shell_lines()[0]
    assert "make test" in shell_lines()[1]


@pytest.mark.parametrize("link", sorted(set(LINK.findall(TEXT))))
def test_every_relative_link_leads_somewhere(link: str) -> None:
    if not link.startswith(("http://", "https://", "#")):
        assert (ROOT / link.partition("#")[0]).exists()


@pytest.mark.parametrize("path", sorted(ROOT.glob("firmware_app/**/*.md")), ids=lambda p: p.name)
def test_links_of_other_pages_lead_somewhere(path: Path) -> None:
    for link in LINK.findall(path.read_text()):
        if not link.startswith(("http://", "https://", "#")):
            assert (path.parent / link.partition("#")[0]).exists(), link


def test_no_placeholder_is_left() -> None:
    assert re.findall(r"^[A-Z]{4,}$", TEXT, re.MULTILINE) == []


def test_it_is_short_enough_to_be_read() -> None:
    assert len(TEXT.splitlines()) <= LINES_MAX


def test_the_first_sentence_comes_right_after_the_name() -> None:
    name, empty, sentence = TEXT.splitlines()[:3]
    assert (name, empty) == ("# Wayflie", "")
    assert sentence.startswith("A stock Crazyflie")


def test_the_parameters_it_names_are_those_of_the_app() -> None:
    code = "".join(path.read_text() for path in ROOT.glob("firmware_app/app/*.c"))
    for name in set(re.findall(r"`way\.(\w+)`", TEXT)):
        assert re.search(rf"_ADD\w*\([^)]*\b{name}\b", code), name


def test_the_oldest_python_it_names_is_the_oldest_that_is_allowed() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    (oldest,) = set(re.findall(r"Python (3\.\d+)", TEXT))
    assert project["requires-python"] == f">={oldest}"
