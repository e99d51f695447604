# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie replay --rerun`: runs the C code again on a recording, and compares the results."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from rich.console import Console

from ground.checks import Check, write_report
from ground.errors import GroundError, LinkUnavailable
from ground.model import Incoming
from ground.progress import waiting
from ground.record.reader import Entry, read_entries, read_session
from ground.record.writer import RecordFile
from ground.sim.caller import Caller
from ground.sim.hearing import Ear, Keeper
from ground.sim.inputs import CALLS, split
from ground.sim.rerun_radio import RadioRerun

WORDS: Final = {
    b"S": "the setpoint", b"L": "a log block", b"A": "an app channel packet", b"C": "the console",
    b"P": "a parameter", b"w": "a parameter that was written", b"U": "a parameter's news",
    b"M": "a measurement for the estimator", b"T": "a table of contents", b"V": "its health",
}  # fmt: skip


@dataclass(slots=True)
class Outcomes:
    """A Sink that collects what the calls return now."""

    calls: int = 0
    now_ms: int = 0
    outcomes: list[tuple[bytes, bytes, bytes]] = field(default_factory=list)

    def note(self, letter: bytes, arguments: bytes = b"", outcome: bytes = b"") -> None:
        """Collect one call and its outcome."""
        self.calls += 1
        if letter == b"r":
            self.now_ms += int.from_bytes(arguments, "little")
        self.outcomes.append((letter, arguments, outcome))


@dataclass(slots=True)
class Comparison:
    """Comparison with the recording; `first` describes the first difference."""

    messages: int = 0
    different: int = 0
    first: str = ""


def rerun_file(file: Path, into: Path | None, json_file: Path | None, out: Console) -> bool:
    """Run it again. @return whether the C code did the same, where that can be judged"""
    try:
        with waiting(out, f"reading {file}"):
            entries = list(read_entries(file))
    except OSError as error:
        raise LinkUnavailable(f"cannot read {file}: {error.strerror}") from error
    copy = RecordFile(into, {"rerun_of": file.name}) if into else None
    try:
        with waiting(out, "computing it again"):
            if any(entry.topic == CALLS for entry in entries):
                figures, checks = _rerun_calls(entries, copy)
            else:
                figures, checks = RadioRerun(read_session(file), _keeper(copy)).report()
    finally:
        if copy:
            copy.close()
    for name, value in figures.items():
        out.print(f"  {name:24} [bold]{value}[/]")
    if json_file:
        write_report(json_file, figures, checks)
    if not checks:
        out.print(
            "computed from what came over the radio: close to what the drone did, never bit for bit"
        )
    return all(check.ok for check in checks)


def _rerun_calls(
    entries: list[Entry], copy: RecordFile | None
) -> tuple[dict[str, Any], list[Check]]:
    """Make all recorded calls again and compare their outcomes bit by bit."""
    outcomes, found = Outcomes(), Comparison()
    caller = Caller(outcomes)
    ear, tell, begin_s = Ear(caller.firmware), _keeper(copy), time.monotonic()
    for entry in entries:
        if entry.topic != CALLS:
            continue
        try:
            calls, before = split(entry.data)
            caller.make(calls)
        except ValueError as error:
            raise GroundError(f"the recording is damaged: {error}") from error
        _compare(outcomes, before, found)
        for message in ear.hear(outcomes.outcomes):
            tell(message, outcomes.now_ms)
        outcomes.outcomes.clear()
    figures = {
        "simulated_s": outcomes.now_ms / 1000,
        "calls": outcomes.calls,
        "different": found.different,
        "first_difference": found.first or "none: every bit is the same",
        "times_real_time": round(outcomes.now_ms / 1000 / (time.monotonic() - begin_s), 1),
    }
    return figures, [Check("different", found.different, 0, "==")]


def _compare(outcomes: Outcomes, before: bytes, found: Comparison) -> None:
    """Compare the outcomes with those that were recorded for the same calls."""
    found.messages += 1
    if b"".join(letter + outcome for letter, _, outcome in outcomes.outcomes) == before:
        return
    found.different += 1
    if found.first:
        return
    at = 0
    for letter, _, outcome in outcomes.outcomes:
        end = at + 1 + len(outcome)
        if before[at:end] != letter + outcome:
            break
        at = end
    else:
        letter = b"?"
    words = WORDS.get(letter, f"call {letter!r}")
    found.first = f"{words} at {outcomes.now_ms / 1000:.2f} s"


def _keeper(copy: RecordFile | None) -> Keeper:
    """A function that writes messages into the file, if there is one."""

    def keep(message: Incoming, now_ms: int) -> None:
        if copy:
            copy.note("/" + type(message).__name__, message, now_ms * 1_000_000)

    return keep
