# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone's EEPROM: parameter values that survive a restart."""

import json
from collections.abc import Mapping
from pathlib import Path

from ground.errors import BadInput

Value = int | float


class Eeprom:
    """Values by "group.name", in memory and, if a path is given, in a JSON file."""

    def __init__(self, initial: Mapping[str, Value], file: Path | None = None) -> None:
        self._file = file
        self._values: dict[str, Value] = dict(initial)
        if file is not None and file.exists():
            try:
                self._values |= json.loads(file.read_text())
            except (ValueError, TypeError) as error:
                raise BadInput(f"{file} holds no parameters as JSON: {error}") from error

    def values(self) -> Mapping[str, Value]:
        """All stored values."""
        return self._values

    def store(self, name: str, value: Value) -> None:
        """Store a value."""
        self._values[name] = value
        self._save()

    def clear(self, name: str) -> bool:
        """Delete a value; false if there was none."""
        if self._values.pop(name, None) is None:
            return False
        self._save()
        return True

    def _save(self) -> None:
        if self._file is not None:
            self._file.write_text(json.dumps(self._values, indent=2) + "\n")
