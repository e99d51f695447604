# SPDX-License-Identifier: GPL-3.0-or-later
"""Compile the core for this machine or for the chip, and read what is in the objects."""

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "firmware_app" / "core"


@dataclass(frozen=True, slots=True)
class Toolchain:
    """A compiler with the flags of its target."""

    name: str
    prefix: str
    flags: tuple[str, ...]

    def run(self, tool: str, *arguments: str | Path, cwd: Path | None = None) -> str:
        command = [self.prefix + tool, *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True, cwd=cwd).stdout

    def is_there(self) -> bool:
        return shutil.which(self.prefix + "gcc") is not None


HOST = Toolchain("this machine", "", ("-std=c11", "-O2", "-ffp-contract=off"))
# As the firmware is compiled (its tools/make/Makefile and arch/ files).
CHIP = Toolchain(
    "Cortex-M4F",
    "arm-none-eabi-",
    (
        "-std=gnu11", "-Os", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16",
        "-fno-math-errno", "-fno-strict-aliasing", "-ffunction-sections", "-fdata-sections",
        "-Wdouble-promotion", "-Werror",
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Symbol:
    """One line of nm: its letter is lower case for what is local to the object."""

    name: str
    letter: str
    size: int


def compile_core(toolchain: Toolchain, folder: Path) -> list[Path]:
    """Objects of all core files, in the folder, each with its stack usage and call graph."""
    sources = sorted(CORE.glob("*.c"))
    extra = ("-c", "-fstack-usage", "-fcallgraph-info=su", f"-I{CORE}")
    toolchain.run("gcc", *toolchain.flags, *extra, *sources, cwd=folder)
    return [folder / f"{source.stem}.o" for source in sources]


def symbols(toolchain: Toolchain, path: Path) -> list[Symbol]:
    """Everything that an object defines or needs."""
    found = []
    for line in toolchain.run("nm", "--format=posix", path).splitlines():
        name, letter, *rest = line.split()
        found.append(Symbol(name, letter, int(rest[1], 16) if len(rest) > 1 else 0))
    return found


def sections(toolchain: Toolchain, path: Path) -> tuple[int, int, int]:
    """Bytes of text (with constants), data and bss."""
    text, data, bss = toolchain.run("size", path).splitlines()[1].split()[:3]
    return int(text), int(data), int(bss)


def sizes_of(toolchain: Toolchain, folder: Path, types: dict[str, str]) -> dict[str, int]:
    """Sizes of C expressions by name, as this compiler lays them out."""
    lines = ['#include "nav.h"'] + [f"char size_{n}[sizeof({what})];" for n, what in types.items()]
    source = folder / "sizes_of.c"
    source.write_text("\n".join(lines) + "\n")
    toolchain.run("gcc", *toolchain.flags, "-c", "-fno-common", f"-I{CORE}", source, cwd=folder)
    sizes = {symbol.name: symbol.size for symbol in symbols(toolchain, folder / "sizes_of.o")}
    return {name: sizes[f"size_{name}"] for name in types}


@dataclass(frozen=True, slots=True)
class Function:
    """A function, its own stack frame and what it calls."""

    frame_bytes: int
    is_static: bool
    calls: tuple[str, ...]


def call_graph(folder: Path) -> dict[str, Function]:
    """All functions of the objects compiled into the folder, from gcc's .ci files."""
    nodes: dict[str, tuple[int, bool]] = {}
    edges: dict[str, list[str]] = {}
    for path in folder.glob("*.ci"):
        text = path.read_text()
        node = re.compile(r'node: { title: "([^"]+)" label: "[^"]*\\n(\d+) bytes \(([^)]+)\)')
        for title, frame, kind in node.findall(text):
            nodes[title] = (int(frame), kind == "static")
        for source, target in re.findall(
            r'edge: { sourcename: "([^"]+)" targetname: "([^"]+)"', text
        ):
            edges.setdefault(source, []).append(target)
    return {
        title: Function(frame, is_static, tuple(edges.get(title, ())))
        for title, (frame, is_static) in nodes.items()
    }
