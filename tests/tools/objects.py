# SPDX-License-Identifier: GPL-3.0-or-later
"""Compile core and app for this machine or for the chip, and inspect the object files."""

import re
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE_APP = ROOT / "firmware_app"
CORE = FIRMWARE_APP / "core"
INCLUDED = {"core": ("core",), "app": ("app", "core", "host")}
"""What a part of the C code may include."""


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
ARCHITECTURE = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
COMMON = ("-fno-math-errno", "-ffunction-sections", "-fdata-sections", "-Wdouble-promotion",
          "-Werror")  # fmt: skip
# As the firmware is compiled (its tools/make/Makefile and arch/ files).
CHIP = Toolchain(
    "Cortex-M4F",
    "arm-none-eabi-",
    (*ARCHITECTURE, *COMMON, "-std=gnu11", "-Os", "-fno-strict-aliasing"),
)
CHIP_STRICT = Toolchain(
    "Cortex-M4F, -O2",
    "arm-none-eabi-",
    (*ARCHITECTURE, *COMMON, "-std=c11", "-O2", "-ffp-contract=off"),
)


@dataclass(frozen=True, slots=True)
class Symbol:
    """A line of nm; a lower-case letter means local to the object."""

    name: str
    letter: str
    size: int


@dataclass(frozen=True, slots=True)
class Objects:
    """Parts of a tree like firmware_app, compiled into folders of the same names."""

    toolchain: Toolchain
    source: Path
    folder: Path

    def of(self, part: str) -> list[Path]:
        """The objects of core or app."""
        return sorted((self.folder / part).glob("*.o"))

    def all(self) -> list[Path]:
        """The objects of all parts that were compiled."""
        return [path for part in INCLUDED for path in self.of(part)]

    def compile(self, *sources: Path) -> None:
        """Compile these files of the tree again, each with its stack usage and call graph."""
        for part, included in INCLUDED.items():
            of_part = [path for path in sources if path.parent.name == part]
            if of_part:
                folder = self.folder / part
                folder.mkdir(exist_ok=True)
                flags = [*self.toolchain.flags, *(f"-I{self.source / name}" for name in included)]
                self.toolchain.run(
                    "gcc", *flags, "-c", "-fstack-usage", "-fcallgraph-info=su", *of_part,
                    cwd=folder,
                )  # fmt: skip


def compile_tree(
    toolchain: Toolchain, folder: Path, source: Path = FIRMWARE_APP, parts: Iterable[str] = INCLUDED
) -> Objects:
    """All C files of these parts."""
    objects = Objects(toolchain, source, folder)
    objects.compile(*(path for part in parts for path in sorted((source / part).glob("*.c"))))
    return objects


def symbols(toolchain: Toolchain, *paths: Path) -> dict[Path, list[Symbol]]:
    """Everything that these objects define or need."""
    found: dict[Path, list[Symbol]] = {path: [] for path in paths}
    of_one = found[paths[0]]
    for line in toolchain.run("nm", "--format=posix", *paths).splitlines():
        if line.endswith(":"):  # only where there are several
            of_one = found[Path(line[:-1])]
        elif line:
            name, letter, *rest = line.split()
            of_one.append(Symbol(name, letter, int(rest[1], 16) if len(rest) > 1 else 0))
    return found


@dataclass(frozen=True, slots=True)
class Sections:
    """Bytes of an object."""

    text: int
    """Code and constants."""
    data: int
    bss: int


def sections(toolchain: Toolchain, *paths: Path) -> dict[Path, Sections]:
    """Section sizes of these objects."""
    rows = toolchain.run("size", *paths).splitlines()[1:]
    sizes = [Sections(*map(int, row.split()[:3])) for row in rows]
    return dict(zip(paths, sizes, strict=True))


def sizes_of(toolchain: Toolchain, folder: Path, types: dict[str, str]) -> dict[str, int]:
    """Sizes of C expressions by name, as this compiler lays them out."""
    lines = ['#include "nav.h"'] + [f"char size_{n}[sizeof({what})];" for n, what in types.items()]
    source = folder / "sizes_of.c"
    source.write_text("\n".join(lines) + "\n")
    toolchain.run("gcc", *toolchain.flags, "-c", "-fno-common", f"-I{CORE}", source, cwd=folder)
    (found,) = symbols(toolchain, folder / "sizes_of.o").values()
    sizes = {symbol.name: symbol.size for symbol in found}
    return {name: sizes[f"size_{name}"] for name in types}


@dataclass(frozen=True, slots=True)
class Function:
    """A function, its own stack frame and what it calls."""

    frame_bytes: int
    is_static: bool
    calls: tuple[str, ...]


def call_graph(folder: Path) -> dict[str, Function]:
    """All functions of the objects compiled below the folder, from gcc's .ci files."""
    nodes: dict[str, tuple[int, bool]] = {}
    edges: dict[str, list[str]] = {}
    for path in folder.rglob("*.ci"):
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
