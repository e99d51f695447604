# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone's parameters and log variables, read from the doc comments of the C source.

One table for the web page, for DESIGN.md and for checks of a running drone: meaning, unit, range
and default of each parameter.
"""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass
from pathlib import Path

from ground.core import lib

GROUND = Path(__file__).resolve().parent
SOURCES = GROUND.parent / "firmware_app" / "app"
PARAMS, LOGS, MAP = "app_params.c", "app_status.c", "app_map.c"

_ENTRY = re.compile(
    r"/\*\*\s*\n(?P<doc>(?: \*.*\n)+?) \*/\n"
    r"(?P<macro>PARAM|LOG)_ADD\w*\((?P<type>[A-Z_0-9 |]+?), (?P<name>\w+), (?P<rest>[^)]*)\)"
)
_RANGE = re.compile(r"(-?\d[\d.]*) to (-?\d[\d.]*) \[([^\]]+)\]")
_UNIT = re.compile(r"\[([^\]]+)\]")
_CHOICE = re.compile(r"(?:^|[:,] )(\d+) ([^,.;]+)")
_DEFAULT = re.compile(r"\.(\w+) = ([\w.-]+?)f?,")
_WIDEST = {"uint8": 255.0}


@dataclass(frozen=True, slots=True)
class Variable:
    """A parameter or log variable of group `way`; choices[n] is the meaning of the number n."""

    name: str
    type: str
    help: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    default: float = 0.0
    choices: tuple[str, ...] = ()
    stored: bool = False

    @property
    def range_words(self) -> str:
        """The permitted values in a few words."""
        if self.low is None or self.high is None:
            return "any number"
        return f"{self.low:g} to {self.high:g} {self.unit}".strip()


@functools.cache
def parameters() -> dict[str, Variable]:
    """All parameters of the app by name, in the order of the source."""
    return _read(PARAMS, "PARAM")


@functools.cache
def log_variables() -> dict[str, Variable]:
    """All log variables of the group `way`, by name."""
    return _read(LOGS, "LOG")


@functools.cache
def map_variables() -> dict[str, Variable]:
    """All log variables of the group `waymap`, by name."""
    return _read(MAP, "LOG")


def source_text(name: str) -> str:
    """A source of the app: from the checkout, else the copy installed with the package."""
    beside = SOURCES / name
    return (beside if beside.exists() else GROUND / name).read_text()


def _read(file: str, macro: str) -> dict[str, Variable]:
    text = source_text(file)
    defaults = _defaults(text)
    found = (_variable(match, defaults) for match in _ENTRY.finditer(text))
    entries = [one for one, kind in found if kind == macro]
    return {entry.name: entry for entry in entries}


def _variable(match: re.Match[str], defaults: dict[str, float]) -> tuple[Variable, str]:
    words = match["type"].split(" | ")
    kind = words[0].split("_", 1)[1].lower()
    text = " ".join(line.strip(" *") for line in match["doc"].splitlines()).strip()
    text = text.removeprefix("@brief ")
    choices = _choices(text) if kind == "uint8" else ()
    low, high, unit = _range(text)
    if choices:
        low, high, unit = 0.0, len(choices) - 1.0, ""
    elif low is None and kind in _WIDEST:
        low, high = 0.0, _WIDEST[kind]
    field = re.match(r"&wanted\.(\w+)", match["rest"])
    variable = Variable(
        name=match["name"],
        type=kind,
        help=text,
        unit=unit,
        low=low,
        high=high,
        default=defaults.get(field[1], 0.0) if field else 0.0,
        choices=choices,
        stored="PARAM_PERSISTENT" in words,
    )
    return variable, match["macro"]


def _range(text: str) -> tuple[float | None, float | None, str]:
    if found := _RANGE.search(text):
        return float(found[1]), float(found[2]), found[3]
    unit = _UNIT.search(text)
    return None, None, unit[1] if unit else ""


def _choices(text: str) -> tuple[str, ...]:
    """Parse `0 this, 1 that`, with numbers that count up from 0."""
    words: list[str] = []
    for number, word in _CHOICE.findall(text):
        if int(number) == len(words):
            words.append(word.strip())
    return tuple(words) if len(words) > 1 else ()


def _defaults(text: str) -> dict[str, float]:
    """The fields of DEFAULTS with their numbers; names of enumerators are looked up."""
    found = re.search(r"#define DEFAULTS(.*?)\n\n", text, re.DOTALL)
    if not found:
        return {}
    pairs = _DEFAULT.findall(found[1].replace("\\\n", " "))
    return {field: _number(value) for field, value in pairs}


def _number(text: str) -> float:
    return float(getattr(lib, text)) if text[0].isalpha() else float(text)
