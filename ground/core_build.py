# SPDX-License-Identifier: GPL-3.0-or-later
"""How the C core becomes a Python module; build_extensions.py compiles it.

cffi gets the headers without their preprocessor lines, and the module is built in API mode: if a
struct differs between Python and the C compiler, the module does not load.
"""

from __future__ import annotations

import re
from pathlib import Path

from cffi import FFI

ROOT = Path(__file__).resolve().parent.parent
CORE = ROOT / "firmware_app" / "core"
PARTS = [CORE]
MODULE = "ground._core"
# No floating-point contraction: the core must compute the same bits here as on the chip.
FLAGS = ["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra"]
# The code that cffi generates casts between function types.
PREAMBLE = '#pragma GCC diagnostic ignored "-Wcast-function-type"\n'

_INCLUDE = re.compile(r'^#include "(\w+\.h)"', re.MULTILINE)


def header_order(folder: Path) -> list[str]:
    """Names of all headers in the folder, each after those that it includes."""
    texts = {path.name: path.read_text() for path in sorted(folder.glob("*.h"))}
    order: list[str] = []

    def visit(name: str) -> None:
        for included in _INCLUDE.findall(texts[name]):
            if included not in order:
                visit(included)
        if name not in order:
            order.append(name)

    for name in texts:
        visit(name)
    return order


def declarations(folder: Path) -> str:
    """All headers in one text, without preprocessor lines."""
    lines: list[str] = []
    for name in header_order(folder):
        text = (folder / name).read_text()
        lines += [line for line in text.splitlines() if not line.startswith("#")]
    return "\n".join(lines)


def make_ffibuilder() -> FFI:
    """Describe the extension module to cffi."""
    includes = "".join(f'#include "{name}"\n' for name in header_order(CORE))
    builder = FFI()
    builder.cdef(declarations(CORE))
    builder.set_source(MODULE, PREAMBLE + includes)
    return builder
