# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands typed at a running simulator, which begin and end faults."""

import os
import select
from collections.abc import Iterator, Sequence

from ground.sim.faults import Faults
from ground.sim.faulttable import FAULTS

HELP = "fault NAME[:SECONDS], end NAME, faults"
_CHUNK_BYTES = 4096


class Lines:
    """Whole lines from a file descriptor, read without blocking."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor: int | None = descriptor
        self._rest = b""

    def take(self) -> Iterator[str]:
        """Yield the lines that have arrived since the last call."""
        while self._descriptor is not None and self._readable(self._descriptor):
            chunk = os.read(self._descriptor, _CHUNK_BYTES)
            if not chunk:
                self._descriptor = None
            *lines, self._rest = (self._rest + chunk).split(b"\n")
            yield from (line.decode(errors="replace").strip() for line in lines)

    @staticmethod
    def _readable(descriptor: int) -> bool:
        """Whether a read will not block; a background process must not read from its terminal."""
        try:
            if os.isatty(descriptor) and os.tcgetpgrp(descriptor) != os.getpgrp():
                return False
            return bool(select.select((descriptor,), (), (), 0.0)[0])
        except OSError:
            return False


def obey_one(line: str, drones: Sequence[Faults]) -> str:
    """Obey a line that begins with a drone's number; without a number it is for drone 1."""
    number, _, rest = line.partition(" ")
    if not number.isdecimal():
        return obey(line, drones[0])
    if not 1 <= int(number) <= len(drones):
        return f"there are drones 1 to {len(drones)}"
    return obey(rest.strip(), drones[int(number) - 1])


def obey(line: str, faults: Faults) -> str:
    """Obey one line and return the answer."""
    word, _, rest = line.partition(" ")
    name, colon, seconds = rest.strip().partition(":")
    try:
        match word:
            case "":
                return ""
            case "faults":
                return "\n".join(f"{name:18} {fault.what}" for name, fault in FAULTS.items())
            case "fault":
                faults.begin(name, float(seconds) if colon else None)
                return f"{name}: begun"
            case "end":
                return f"{name}: over" if faults.end(name) else f"{name}: not there"
    except ValueError as error:
        return str(error)
    return f"{word}? There are: {HELP}"
