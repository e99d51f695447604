# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of recordings without a given name; the newest are kept, up to a size limit."""

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
"""Environment variable with the size to keep in GB; `inf` keeps everything."""
KEPT_GB = 2.0
BYTES_PER_GB = 1_000_000_000
_DATE = "%Y-%m-%d_%H-%M-%S"
_OURS = re.compile(r"\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d(_\d+)?\.mcap")


@dataclass(frozen=True, slots=True)
class Deleted:
    """Which recordings prune() has deleted."""

    files: int
    size_bytes: int
    kept_gb: float

    def __str__(self) -> str:
        """A line for the user."""
        what = "the oldest recording" if self.files == 1 else f"the {self.files} oldest recordings"
        return (
            f"deleted {what}, {self.size_bytes / 1e6:.0f} MB: the newest {self.kept_gb:g} GB are "
            f"kept ({LIMIT} sets that)"
        )


def recordings_folder() -> Path:
    """The folder of recordings that were given no name."""
    return platformdirs.user_data_path("wayflie", appauthor=False) / "recordings"


def new_recording() -> Path:
    """Choose a free file name from the date; creates the folder."""
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
    """The most recently written recording of the folder."""
    found = _newest_first()
    if not found:
        raise GroundError(
            f"there is no recording in {recordings_folder()}", "fly first, or name a file"
        )
    return found[0][0]


def kept_gb() -> float:
    """The size to keep, in GB. Raises BadInput."""
    text = os.environ.get(LIMIT, "") or str(KEPT_GB)
    with contextlib.suppress(ValueError):
        if not math.isnan(limit_gb := float(text)) and limit_gb >= 0:
            return limit_gb
    raise BadInput(f"{LIMIT} is {text!r}, which is not a number of gigabytes")


def prune() -> Deleted | None:
    """Delete the oldest beyond the limit, except the newest and those that are being written.

    Files with other names than ours were named by somebody, and stay.
    """
    limit_gb = kept_gb()
    spared, files, size_bytes = limit_gb * BYTES_PER_GB, 0, 0
    for number, (path, stat) in enumerate(_newest_first()):
        spared -= stat.st_size
        if number and spared < 0 and _delete(path):
            files, size_bytes = files + 1, size_bytes + stat.st_size
    return Deleted(files, size_bytes, limit_gb) if files else None


def hold(descriptor: int) -> None:
    """Mark a file as being written, until its descriptor is closed or its program ends."""
    fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)


def _newest_first() -> list[tuple[Path, os.stat_result]]:
    found = []
    with contextlib.suppress(OSError):
        for path in recordings_folder().iterdir():
            if _OURS.fullmatch(path.name):
                with contextlib.suppress(OSError):  # another program may have deleted it
                    found.append((path, path.stat()))
    return sorted(found, key=lambda entry: (entry[1].st_mtime_ns, entry[0].name), reverse=True)


def _delete(path: Path) -> bool:
    """Delete a file unless a program holds it."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        path.unlink()
        return True
    return False
