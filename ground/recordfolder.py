# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of recordings that were given no name. The newest are kept, up to a limit."""

from __future__ import annotations

import contextlib
import fcntl
import math
import os
import re
import time
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from ground.errors import BadInput, GroundError

LIMIT = "WAYFLIE_KEEP_GB"
"""The environment variable that says how much is kept; `inf` keeps all."""
KEPT_GB = 2.0
BYTES_PER_GB = 1_000_000_000
_DATE = "%Y-%m-%d_%H-%M-%S"
_OURS = re.compile(r"\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d(_\d+)?\.mcap")


@dataclass(frozen=True, slots=True)
class Deleted:
    """What had to go."""

    files: int
    size_bytes: int
    kept_gb: float

    def __str__(self) -> str:
        """In one line."""
        what = "the oldest recording" if self.files == 1 else f"the {self.files} oldest recordings"
        return (
            f"deleted {what}, {self.size_bytes / 1e6:.0f} MB: the newest {self.kept_gb:g} GB are "
            f"kept ({LIMIT} sets that)"
        )


def recordings_folder() -> Path:
    """Where recordings go that were given no name."""
    return platformdirs.user_data_path("wayflie", appauthor=False) / "recordings"


def new_recording() -> Path:
    """A name that is not taken, by the date; the folder is made."""
    folder = recordings_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise GroundError(
            f"cannot record to {folder}: {error.strerror}", "`--record off` flies without"
        ) from error
    name = time.strftime(_DATE)
    taken = sum(path.stem.startswith(name) for path in folder.iterdir())
    return folder / (f"{name}_{taken + 1}.mcap" if taken else f"{name}.mcap")


def newest_recording() -> Path:
    """The last that was written to among those that were given no name."""
    folder = recordings_folder()
    files = sorted(folder.glob("*.mcap"), key=lambda path: path.stat().st_mtime)
    if not files:
        raise GroundError(f"there is no recording in {folder}", "fly first, or name a file")
    return files[-1]


def kept_gb() -> float:
    """How much is kept. Raises BadInput."""
    text = os.environ.get(LIMIT, "") or str(KEPT_GB)
    with contextlib.suppress(ValueError):
        if not math.isnan(limit_gb := float(text)) and limit_gb >= 0:
            return limit_gb
    raise BadInput(f"{LIMIT} is {text!r}, which is no number of gigabytes")


def prune() -> Deleted | None:
    """Delete the oldest beyond the limit, but neither the newest nor one that is being written.

    Files with other names than we give were named by somebody, and stay.
    """
    limit_gb = kept_gb()
    spared, files, size_bytes = limit_gb * BYTES_PER_GB, 0, 0
    for number, (path, stat) in enumerate(_newest_first()):
        spared -= stat.st_size
        if number and spared < 0 and _delete(path):
            files, size_bytes = files + 1, size_bytes + stat.st_size
    return Deleted(files, size_bytes, limit_gb) if files else None


def hold(descriptor: int) -> None:
    """The file is being written until the descriptor is closed, or its program has ended."""
    fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)


def _newest_first() -> list[tuple[Path, os.stat_result]]:
    found = []
    with contextlib.suppress(OSError):
        for path in recordings_folder().iterdir():
            if _OURS.fullmatch(path.name):
                with contextlib.suppress(OSError):  # another program deletes as well
                    found.append((path, path.stat()))
    return sorted(found, key=lambda entry: entry[1].st_mtime, reverse=True)


def _delete(path: Path) -> bool:
    """Unless somebody holds it."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        path.unlink()
        return True
    return False
