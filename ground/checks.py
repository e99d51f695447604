# SPDX-License-Identifier: GPL-3.0-or-later
"""What a measuring command writes with --json: figures, and checks of some of them."""

from __future__ import annotations

import json
import math
import operator
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


def write_report(path: Path, figures: Mapping[str, object], checks: Sequence[Check]) -> None:
    """One JSON object: the figures, and the list `checks`."""
    rows = [{**asdict(check), "ok": check.ok} for check in checks]
    path.write_text(json.dumps({**figures, "checks": rows}, indent=2) + "\n")
