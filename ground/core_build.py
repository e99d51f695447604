# SPDX-License-Identifier: GPL-3.0-or-later
"""Compile the C core for Python: `python -m ground.core_build`.

The headers are handed to cffi as they are, without their preprocessor lines, and the module is
built in API mode: a struct that Python sees differently from the C compiler stops the build.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path

from cffi import FFI

ROOT = Path(__file__).resolve().parent.parent
CORE = Path("firmware_app/core")
MODULE = "ground._core"
# No contraction: the core shall give the same bits here as on the chip.
FLAGS = ["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
# cffi's own generated code casts between function types.
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
    """What to compile, and what Python sees of it."""
    folder = ROOT / CORE
    includes = "".join(f'#include "{name}"\n' for name in header_order(folder))
    builder = FFI()
    builder.cdef(declarations(folder))
    builder.set_source(
        MODULE,
        PREAMBLE + includes,
        sources=[str(path) for path in sorted(folder.glob("*.c"))],
        include_dirs=[str(folder)],
        extra_compile_args=FLAGS,
    )
    return builder


def build() -> Path:
    """Compile, put the module beside this file and return its path."""
    with tempfile.TemporaryDirectory(prefix="wayflie-core-") as scratch:
        built = Path(make_ffibuilder().compile(tmpdir=scratch))
        target = ROOT / "ground" / built.name
        # A new file, then a rename: a running program keeps the module that it has mapped.
        partial = target.with_suffix(".partial")
        shutil.copyfile(built, partial)
        partial.replace(target)
    return target


if __name__ == "__main__":
    print(build())
