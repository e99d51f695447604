# SPDX-License-Identifier: GPL-3.0-or-later
"""The JSON report of a measuring command: its figures, and checks of some of them."""

from __future__ import annotations

import json
import math
import operator
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

Sense = Literal["<=", ">=", "=="]
_SENSES = {"<=": operator.le, ">=": operator.ge, "==": operator.eq}


@dataclass(frozen=True, slots=True)
class Check:
    """A check that value SENSE limit holds."""

    name: str
    value: float | bool | None
    limit: float | bool
    sense: Sense

    @property
    def ok(self) -> bool:
        """Whether it holds; a value that could not be measured fails."""
        if self.value is None or math.isnan(self.value):
            return False
        return bool(_SENSES[self.sense](self.value, self.limit))


@dataclass(frozen=True, slots=True)
class Files:
    """Files that a flight writes, if wanted."""

    report: Path | None = None
    recording: Path | None = None


STANDARD_OUTPUT = Path("-")
"""As a report's file: write to standard output."""


def write_report(path: Path, figures: Mapping[str, object], checks: Sequence[Check]) -> None:
    """Write one JSON object: the command as it was given, the figures, and the list `checks`."""
    command = shlex.join(["wayflie", *sys.argv[1:]])
    rows = [{**asdict(check), "ok": check.ok} for check in checks]
    write_json(path, {"command": command, **figures, "checks": rows})


def write_json(path: Path, found: Mapping[str, object]) -> None:
    """Write JSON to the file or to standard output."""
    text = json.dumps(found, indent=2) + "\n"
    if path == STANDARD_OUTPUT:
        sys.stdout.write(text)
    else:
        path.write_text(text)
