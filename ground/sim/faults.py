# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults that begin and end at set times or on command."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ground.sim.faulttable import FAULTS, Bench, End


@dataclass(frozen=True, slots=True)
class FaultSpec:
    """A fault to inject; at_s is simulated time since the start."""

    name: str
    at_s: float = 0.0
    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.name not in FAULTS:
            raise ValueError(f"no fault {self.name!r}; there are " + ", ".join(FAULTS))
        if not 0.0 <= self.at_s < math.inf:
            raise ValueError(f"{self.name}: {self.at_s} is not a time")
        if self.seconds is not None and not 0.0 < self.seconds < math.inf:
            raise ValueError(f"{self.name}: {self.seconds} is not a duration")


def parse_fault(text: str) -> FaultSpec:
    """Read NAME@T[:SECONDS]."""
    name, _, when = text.partition("@")
    at, colon, seconds = when.partition(":")
    FaultSpec(name)
    try:
        times = float(at), float(seconds) if colon else None
    except ValueError as error:
        raise ValueError(f"{text!r} is not NAME@T[:SECONDS]") from error
    return FaultSpec(name, *times)


@dataclass(slots=True)
class Happened:
    """A fault that was injected; times are simulated."""

    name: str
    begin_s: float
    end_s: float | None = None


class Faults:
    """Begins and ends faults as simulated time goes on."""

    def __init__(self, bench: Bench, specs: tuple[FaultSpec, ...]) -> None:
        self.log: list[Happened] = []
        self.bench = bench
        self._due = sorted(specs, key=lambda spec: spec.at_s)
        self._running: list[tuple[Happened, float, End]] = []
        self.step()

    def step(self) -> None:
        """Begin and end the faults that are due."""
        now_s = self.bench.plant.time_s
        while self._due and self._due[0].at_s <= now_s:
            spec = self._due.pop(0)
            self.begin(spec.name, spec.seconds)
        for happened, end_s, _ in list(self._running):
            if end_s <= now_s:
                self.end(happened.name)

    def begin(self, name: str, seconds: float | None = None) -> None:
        """Begin a fault now; without `seconds` it lasts as long as the fault table says."""
        FaultSpec(name, seconds=seconds)
        fault, now_s = FAULTS[name], self.bench.plant.time_s
        self.end(name)
        lasts_s = fault.seconds if seconds is None else seconds
        happened = Happened(name, now_s)
        self.log.append(happened)
        end = fault.begin(self.bench, lasts_s)
        if fault.lasts:
            self._running.append((happened, now_s + lasts_s, end))

    def end(self, name: str) -> bool:
        """End a fault now; false if it was not active."""
        for entry in self._running:
            happened, _, end = entry
            if happened.name == name:
                self._running.remove(entry)
                happened.end_s = self.bench.plant.time_s
                end()
                return True
        return False
