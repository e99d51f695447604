# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles the bench's C files afresh, into a folder that is removed with the process."""

from __future__ import annotations

import atexit
import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from tests.tools.objects import CORE, ROOT

HERE = Path(__file__).resolve().parent
BUILT = ROOT / "build" / "bench-plan"
"""Where `make bench-ompl` puts its driver, and what may be kept between runs."""
FAST = ("-std=c11", "-O3", "-march=native")
SHARED = ("drive.c", "exact.c", "exact_search.c")


@cache
def workshop() -> Path:
    """A folder for what is compiled; gone when the process ends."""
    folder = Path(tempfile.mkdtemp(prefix="wayflie-plan-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _gcc(*arguments: str | Path) -> None:
    subprocess.run(["gcc", *FAST, *map(str, arguments)], check=True)


@cache
def exact_library() -> Path:
    """exact.h as a shared library."""
    target = workshop() / "exact.so"
    sources = [HERE / name for name in ("exact.c", "exact_search.c")]
    _gcc("-shared", "-fPIC", *sources, "-lm", "-o", target)
    return target


def core_files(source: Path) -> list[Path]:
    """The C files of the core that a source needs, directly or through its includes."""
    wanted: set[Path] = set()
    ahead = [source]
    while ahead:
        included = re.findall(r'#include "(\w+)\.h"', ahead.pop().read_text())
        files = [path for stem in included for path in CORE.glob(f"{stem}.[ch]")]
        files += [path for stem in included for path in CORE.glob(f"{stem}_*.c")]
        ahead += [path for path in files if path not in wanted]
        wanted |= set(files)
    return sorted(path for path in wanted if path.suffix == ".c")


@cache
def driver(name: str) -> Path:
    """Compile one of the C drivers with what it needs of the core."""
    target = workshop() / name
    own = [HERE / f"drive_{name}.c", *(HERE / file for file in SHARED)]
    core: list[Path] = []
    if name == "ours":
        own.append(HERE / "ours.c")
        core = core_files(own[-1])
    _gcc(f"-I{CORE}", *own, *core, "-lm", "-o", target)
    return target
