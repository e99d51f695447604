# SPDX-License-Identifier: GPL-3.0-or-later
"""How the firmware app becomes a Python module; ground/build_extensions.py compiles it.

The app's own C files, the core and the host version of the firmware become one extension module in
cffi's API mode, with firmware_app/host/sim_port.h as its interface.
"""

from __future__ import annotations

from cffi import FFI

from ground import core_build

FIRMWARE_APP = core_build.ROOT / "firmware_app"
PARTS = [FIRMWARE_APP / part for part in ("app", "core", "host")]
INTERFACE = FIRMWARE_APP / "host" / "sim_port.h"
MODULE = "ground.sim._firmware"
FLAGS = [*core_build.FLAGS, "-std=gnu11", "-fvisibility=hidden"]


def make_ffibuilder() -> FFI:
    """Describe the extension module to cffi."""
    lines = INTERFACE.read_text().splitlines()
    builder = FFI()
    builder.cdef("\n".join(line for line in lines if not line.startswith("#")))
    builder.set_source(MODULE, f'{core_build.PREAMBLE}#include "{INTERFACE.name}"\n')
    return builder
