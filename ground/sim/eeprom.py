# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone's EEPROM: parameter values that survive a restart."""

import json
from collections.abc import Mapping
from pathlib import Path

Value = int | float


class Eeprom:
    """Values by "group.name"; kept in memory, and in a JSON file if one is given."""

    def __init__(self, initial: Mapping[str, Value], file: Path | None = None) -> None:
        self._file = file
        self._values: dict[str, Value] = dict(initial)
        if file is not None and file.exists():
            self._values |= json.loads(file.read_text())

    def values(self) -> Mapping[str, Value]:
        """Everything that is stored."""
        return self._values

    def store(self, name: str, value: Value) -> None:
        """Keep a value."""
        self._values[name] = value
        self._save()

    def clear(self, name: str) -> bool:
        """Forget a value; false if there was none."""
        if self._values.pop(name, None) is None:
            return False
        self._save()
        return True

    def _save(self) -> None:
        if self._file is not None:
            self._file.write_text(json.dumps(self._values, indent=2) + "\n")
