# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of results, one per mission, in a CSV file that grows as missions end."""

from __future__ import annotations

import csv
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Final, get_type_hints

from ground.errors import GroundError


@dataclass(frozen=True, slots=True)
class Row:
    """The result of a mission; `ok` and `cause` are the verdict. None: not measured in this kind.

    Lengths are true and horizontal; only wall_s depends on the machine.
    """

    kind: str
    seed: int
    number: int
    conditions: str = ""
    """Noise profile, packet loss, settings."""
    style: str = ""
    task: str = ""
    """What was asked, and whether it is possible."""
    outcome: str = ""
    """What the drone reported, in a word: arrived, refused, failed, explored, ... or error."""
    reason: str = ""
    ok: bool = False
    cause: str = ""
    collisions: int = 0
    """Contacts that the drone caused by moving into something."""
    touches: int = 0
    """All contacts."""
    sim_s: float = 0.0
    """Simulated time, with the baseline's flight."""
    wall_s: float = 0.0
    task_s: float | None = None
    """From the command to its end."""
    known_s: float | None = None
    """From the command until 95 % of the reachable area is known."""
    baseline_s: float | None = None
    """known_s of the baseline; the time limit if it never gets there."""
    flown_m: float | None = None
    shortest_m: float | None = None
    miss_m: float | None = None
    """True distance from the drone to the goal, or home, at the end."""
    covered: float | None = None
    claimed: bool | None = None
    """Whether the drone reported that everything is explored."""
    person_m: float | None = None
    """Least distance to a person slow enough to be yielded to."""
    ghosts: int | None = None
    """Cells still occupied long after a moving obstacle has gone."""


class BadRows(GroundError):
    """A file to resume from that belongs to another campaign or is damaged."""


_NAMES: Final = tuple(field.name for field in fields(Row))
_TYPES: Final = get_type_hints(Row)


class RowFile:
    """Rows on disk, appended one by one, so that an interrupted campaign can be resumed."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> list[Row]:
        """Read all complete rows; a last row that was cut off is removed from the file."""
        if not self._path.exists():
            return []
        text = self._path.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            self._path.write_text(whole, encoding="utf-8")
        lines = list(csv.reader(whole.splitlines()))
        if not lines:
            return []
        if tuple(lines[0]) != _NAMES:
            raise BadRows(f"{self._path} was not written by this version of `wayflie campaign`")
        try:
            return [_row(line) for line in lines[1:]]
        except ValueError as error:
            raise BadRows(f"{self._path} is damaged: {error}") from error

    def append(self, row: Row) -> None:
        """Write a row at once."""
        is_new = not self._path.exists() or self._path.stat().st_size == 0
        with self._path.open("a", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            if is_new:
                writer.writerow(_NAMES)
            writer.writerow(["" if value is None else value for value in asdict(row).values()])


def _row(line: list[str]) -> Row:
    values: dict[str, Any] = {}
    for name, text in zip(_NAMES, line, strict=True):
        kind = _TYPES[name]
        if kind is str or text == "":
            values[name] = text if kind is str else None
        elif kind in (bool, bool | None):
            values[name] = text == "True"
        else:
            values[name] = int(text) if kind in (int, int | None) else float(text)
    return Row(**values)
