# SPDX-License-Identifier: GPL-3.0-or-later
"""What the README says, in parts: commands, code, prose; and what was measured for it."""

import json
import re
import shlex
from pathlib import Path
from typing import Any

from tests.project.files import ROOT

TEXT = (ROOT / "README.md").read_text()
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"`([^`]+)`")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
MEASURED = ROOT / "tests" / "bench" / "measured"


def code(kind: str) -> list[str]:
    """Fenced blocks of that language."""
    return [body for marked, body in BLOCK.findall(TEXT) if marked == kind]


def commands() -> list[list[str]]:
    """Every command in a block of the shell's or in a code span, in words, each once."""
    lines = [line for body in code("sh") for line in body.splitlines() if line.strip()]
    lines += SPAN.findall(BLOCK.sub("", TEXT))
    typed = [shlex.split(line, comments=True) for line in lines]
    found = [[Path(words[0]).name, *words[1:]] for words in typed]
    found = [words for words in found if words[0] in ("make", "wayflie")]
    return list(map(list, dict.fromkeys(map(tuple, found))))


def report(name: str) -> dict[str, Any]:
    """What a measuring command has written with --json."""
    found: dict[str, Any] = json.loads((MEASURED / f"{name}.json").read_text())
    return found


def was_measured(words: list[str]) -> bool:
    """Some report was written by this command, whatever else it was given."""
    given = [shlex.split(report(path.stem)["command"]) for path in MEASURED.iterdir()]
    return any(words[:2] == one[:2] and set(words[2:]) <= set(one) for one in given)
