# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters and log variables that a built ELF holds: are they those that are documented?

`python -m tests.tools.elf_tables FILE.elf`, for the real firmware's ELF or the test chip's. As the
firmware's own elf_sanity.py, but by the symbol of each group.
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

from ground.docparams import Variable, log_variables, map_variables, parameters

# What a group's symbol begins with, here and in the firmware, and the bytes of each entry.
PARAM_SYMBOLS = {"param_group_": 16, "__params_": 20}
LOG_SYMBOLS = {"log_group_": 12, "__logs_": 12}
PARAM_TYPES = {0x0: "int8", 0x1: "int16", 0x2: "int32", 0x6: "float", 0x8: "uint8", 0x9: "uint16",
               0xA: "uint32"}  # fmt: skip
LOG_TYPES = {1: "uint8", 2: "uint16", 3: "uint32", 4: "int8", 5: "int16", 6: "int32", 7: "float",
             8: "fp16"}  # fmt: skip
TYPE_MASK, EXTENDED, READ_ONLY, GROUP = 0x0F, 0x10, 0x40, 0x80
PERSISTENT = 1


@dataclass(frozen=True, slots=True)
class Held:
    """One entry of a table. `stored`, `read_only`: of parameters."""

    type: str
    stored: bool = False
    read_only: bool = False


def params_of(file: Path, group: str) -> dict[str, Held]:
    """Parameters of a group, by name."""
    return {
        name: Held(
            PARAM_TYPES[kind & TYPE_MASK],
            bool(kind & EXTENDED and more & PERSISTENT),
            bool(kind & READ_ONLY),
        )
        for kind, more, name in _entries(file, group, PARAM_SYMBOLS)
    }


def logs_of(file: Path, group: str) -> dict[str, Held]:
    """Log variables of a group, by name."""
    return {
        name: Held(LOG_TYPES[kind & TYPE_MASK])
        for kind, _, name in _entries(file, group, LOG_SYMBOLS)
    }


def documented(variables: dict[str, Variable]) -> dict[str, Held]:
    """The same entries from the doc comments."""
    return {name: Held(one.type, one.stored) for name, one in variables.items()}


def differences(file: Path) -> list[str]:
    """Differences between the ELF and the documentation, a line each."""
    wanted = {
        "parameter way": (params_of(file, "way"), documented(parameters())),
        "log way": (logs_of(file, "way"), documented(log_variables())),
        "log waymap": (logs_of(file, "waymap"), documented(map_variables())),
    }
    return [
        f"{what}.{name}: {held.get(name, 'missing')} in the ELF, {told.get(name, 'missing')} told"
        for what, (held, told) in wanted.items()
        for name in sorted(held.keys() | told.keys())
        if held.get(name) != told.get(name)
    ]


def _entries(file: Path, group: str, symbols: dict[str, int]) -> Iterator[tuple[int, int, str]]:
    """Type, extended type and name of each entry; lines that begin or end a group are skipped."""
    with file.open("rb") as stream:
        elf = ELFFile(stream)
        address, size, step = _table(elf, group, symbols)
        table = _bytes(elf, address, size)
        for at in range(0, size, step):
            kind, more, name = struct.unpack_from("<BBxxI", table, at)
            if not kind & GROUP:
                yield kind, more, _bytes(elf, name, 32).partition(b"\0")[0].decode()


def _table(elf: ELFFile, group: str, symbols: dict[str, int]) -> tuple[int, int, int]:
    """Address, size, and bytes per entry."""
    found = elf.get_section_by_name(".symtab")
    assert isinstance(found, SymbolTableSection), "the ELF was stripped of its symbols"
    for prefix, step in symbols.items():
        for symbol in found.get_symbol_by_name(prefix + group) or ():
            return symbol["st_value"], symbol["st_size"], step
    raise LookupError(f"no table {group} in it")


def _bytes(elf: ELFFile, address: int, count: int) -> bytes:
    """The bytes at an address once the file is loaded."""
    for section in elf.iter_sections():
        start = section["sh_addr"]
        if section["sh_type"] == "SHT_PROGBITS" and start <= address < start + section["sh_size"]:
            return bytes(section.data()[address - start :][:count])
    raise LookupError(f"nothing at {address:#x}")


def main() -> None:
    """Check the tables of one file; exit 1 if they are not as documented."""
    file = Path(sys.argv[1])
    for what, held in (
        ("parameter way", params_of(file, "way")),
        ("log way", logs_of(file, "way")),
        ("log waymap", logs_of(file, "waymap")),
    ):
        for name, one in held.items():
            print(f"{what}.{name:12} {one.type}{'  stored' if one.stored else ''}")
    wrong = differences(file)
    print("\n".join(wrong) or f"{file}: as documented")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
