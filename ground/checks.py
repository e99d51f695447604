# SPDX-License-Identifier: GPL-3.0-or-later
"""What a measuring command writes with --json: figures, and checks of some of them."""

from __future__ import annotations

import json
import math
import operator
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

Sense = Literal["<=", ">=", "=="]
_SENSES = {"<=": operator.le, ">=": operator.ge, "==": operator.eq}


@dataclass(frozen=True, slots=True)
class Check:
    """value SENSE limit must hold."""

    name: str
    value: float | bool | None
    limit: float | bool
    sense: Sense

    @property
    def ok(self) -> bool:
        """It holds; what could not be measured does not."""
        if self.value is None or math.isnan(self.value):
            return False
        return bool(_SENSES[self.sense](self.value, self.limit))


@dataclass(frozen=True, slots=True)
class Files:
    """What a flight leaves behind, where wanted."""

    report: Path | None = None
    recording: Path | None = None


STANDARD_OUTPUT = Path("-")
"""In place of a report's file."""


def write_report(path: Path, figures: Mapping[str, object], checks: Sequence[Check]) -> None:
    """One JSON object: the figures, and the list `checks`."""
    rows = [{**asdict(check), "ok": check.ok} for check in checks]
    write_json(path, {**figures, "checks": rows})


def write_json(path: Path, found: Mapping[str, object]) -> None:
    """Into the file, or on standard output."""
    text = json.dumps(found, indent=2) + "\n"
    if path == STANDARD_OUTPUT:
        sys.stdout.write(text)
    else:
        path.write_text(text)
