# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pages name is there: commands and options, files, parameters, words of the code.

A code span may be a command of `make` or `wayflie`, one of its options, a file or folder by the
end of its path, a parameter or log variable, or words that stand in some source.
"""

import re
import subprocess
from functools import cache
from pathlib import Path
from urllib.parse import urlsplit

import click
import pytest
import typer

from ground.cli.app import app
from ground.cli.sim import sim
from ground.docparams import log_variables, map_variables, parameters
from tests.project.files import ROOT, sources, tracked
from tests.project.readme import BLOCK, LINK, SPAN

README = Path("README.md")
DESIGN = Path("firmware_app/DESIGN.md")
CHANGELOG = Path("CHANGELOG.md")
PAGES = {path: (ROOT / path).read_text() for path in (README, DESIGN, CHANGELOG)}
GENERATED = re.compile(r"<!-- Written by.*?<!-- End of", re.DOTALL)
NAMED = sorted(
    {
        (str(path), " ".join(span.split()))
        for path, text in PAGES.items()
        for span in SPAN.findall(GENERATED.sub("", BLOCK.sub("", text)))
    }
)
OF_OTHERS = {"pipx install .", "EXTRX", "RPYT", "README", "JPEG"}


@cache
def words_of_the_sources() -> frozenset[str]:
    here = Path(__file__).parent.relative_to(ROOT)
    read = [path for path in sources(".c", ".h", ".py", ".js", ".toml") if path.parent != here]
    return frozenset(re.findall(r"\w+", " ".join((ROOT / path).read_text() for path in read)))


@cache
def variables() -> frozenset[str]:
    own = {f"way.{name}" for name in (*parameters(), *log_variables())}
    return frozenset(own | {f"waymap.{name}" for name in map_variables()})


@cache
def make_targets() -> frozenset[str]:
    make = ["make", "--no-print-directory", "help"]
    printed = subprocess.run(make, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return frozenset(re.findall(r"^  make (\S+)", printed, re.MULTILINE))


def commands() -> dict[str, click.Command]:
    """By their words after `wayflie`."""
    simulator = typer.Typer(add_completion=False)
    simulator.command()(sim)
    found = {"": typer.main.get_command(app), "sim": typer.main.get_command(simulator)}
    for name, command in getattr(found[""], "commands", {}).items():
        found.setdefault(name, command)
        for inner, its in getattr(command, "commands", {}).items():
            found[f"{name} {inner}"] = its
    return found


COMMANDS = commands()
OPTIONS = {
    name: {"--help", *(option for one in command.params for option in one.opts)}
    for name, command in COMMANDS.items()
}


def command_options(words: list[str]) -> set[str]:
    """Options of the command that these words begin with."""
    name = next(
        " ".join(words[:count]) for count in (2, 1, 0) if " ".join(words[:count]) in COMMANDS
    )
    assert name or not words or words[0].startswith("--"), f"wayflie has no command {words[0]}"
    return OPTIONS[name]


def check_make(words: list[str]) -> None:
    makefile = (ROOT / "Makefile").read_text()
    for word in words:
        name, is_variable, _ = word.partition("=")
        if is_variable:
            assert f"$({name})" in makefile or f"$(if $({name})" in makefile, name
        else:
            assert name in make_targets(), name


def check_options(words: list[str], known: set[str]) -> None:
    for word in words:
        assert not word.startswith("--") or word in known, f"no option {word}"


def is_file(name: str) -> bool:
    """The end of the path of a file or of a folder."""
    end = f"/{name.rstrip('/')}"
    return any(f"/{path}".endswith(end) or f"{end}/" in f"/{path}" for path in tracked())


def check(span: str) -> None:
    first, *rest = span.split()
    if first == "make":
        check_make(rest)
    elif first == "wayflie":
        check_options(rest, command_options(rest))
    elif first.startswith("--"):
        check_options([first], set().union(*OPTIONS.values()))
    elif first.startswith(("way.", "waymap.")):
        assert first in variables()
    elif first == "pytest" or re.fullmatch(r"[\w.]*\w(/[\w./]*|\.(c|h|py|md))", span):
        assert is_file(span.split()[-1])
    else:
        missing = set(re.findall(r"[^\W\d]\w+", span)) - words_of_the_sources()
        assert not missing


@pytest.mark.parametrize(("page", "span"), NAMED)
def test_what_a_code_span_names_is_there(page: str, span: str) -> None:
    if span not in OF_OTHERS:
        check(span)


@pytest.mark.parametrize(
    "wrong",
    ["make coffee", "make demo TEA=1", "wayflie dance", "wayflie goto --upside", "--upside",
     "core/soul.c", "nav_dance.c", "way.soul", "nav_danced()", "pytest tests/app/test_soul.py"],
)  # fmt: skip
def test_a_name_that_is_not_there_is_found(wrong: str) -> None:
    with pytest.raises(AssertionError):
        check(wrong)


@pytest.mark.parametrize("path", PAGES, ids=str)
def test_a_word_in_capitals_is_one_of_the_code(path: Path) -> None:
    text = SPAN.sub("", LINK.sub("", BLOCK.sub("", PAGES[path])))
    capitals = set(re.findall(r"\b[A-Z][A-Z_]{3,}\b", text))
    assert capitals - OF_OTHERS <= words_of_the_sources()


@pytest.mark.parametrize("path", PAGES, ids=str)
def test_links_lead_somewhere(path: Path) -> None:
    """Files are there; addresses are whole ones (nobody is asked for them here)."""
    text = PAGES[path]
    anchors = {re.sub(r"[^\w-]", "", line.lower().replace(" ", "-")) for line in
               re.findall(r"^#+ (.*)$", text, re.MULTILINE)}  # fmt: skip
    for link in LINK.findall(text):
        file, _, anchor = link.partition("#")
        if "://" in link:
            parts = urlsplit(link)
            assert parts.scheme == "https" and "." in parts.netloc, link
        elif file:
            assert (ROOT / path.parent / file).exists(), link
        else:
            assert anchor in anchors, link
