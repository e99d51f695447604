# SPDX-License-Identifier: GPL-3.0-or-later
"""Compile the firmware app for this machine: `python -m ground.sim.firmware_build`.

The app's own C files, the core and the host version of the firmware become one extension module in
cffi's API mode, with firmware_app/host/sim_port.h as its interface.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from cffi import FFI

ROOT = Path(__file__).resolve().parent.parent.parent
PARTS = [ROOT / "firmware_app" / part for part in ("app", "core", "host")]
INTERFACE = ROOT / "firmware_app/host/sim_port.h"
MODULE = "ground.sim._firmware"
FLAGS = [
    "-std=gnu11",
    "-O2",
    "-ffp-contract=off",
    "-fvisibility=hidden",
    "-Wall",
    "-Wextra",
    "-Werror",
]
# cffi's own generated code casts between function types.
PREAMBLE = '#pragma GCC diagnostic ignored "-Wcast-function-type"\n'


def make_ffibuilder() -> FFI:
    """What shall be compiled, and what Python shall see of it."""
    lines = INTERFACE.read_text().splitlines()
    builder = FFI()
    builder.cdef("\n".join(line for line in lines if not line.startswith("#")))
    builder.set_source(
        MODULE,
        f'{PREAMBLE}#include "{INTERFACE.name}"\n',
        sources=[str(path) for part in PARTS for path in sorted(part.glob("*.c"))],
        include_dirs=[str(part) for part in PARTS],
        extra_compile_args=FLAGS,
        libraries=["m"],
    )
    return builder


def build() -> Path:
    """Compile, put the module beside this file and return its path."""
    with tempfile.TemporaryDirectory(prefix="wayflie-fw-") as scratch:
        built = Path(make_ffibuilder().compile(tmpdir=scratch))
        target = Path(__file__).resolve().parent / built.name
        # A new file, then a rename: a running program keeps the module that it has mapped.
        partial = target.with_suffix(".partial")
        shutil.copyfile(built, partial)
        partial.replace(target)
    return target


if __name__ == "__main__":
    print(build())
