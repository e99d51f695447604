# SPDX-License-Identifier: GPL-3.0-or-later
"""What core and app need on the chip, as tables: `python -m tests.tools.sizes`."""

import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

from ground.core import ffi
from tests.tools import gates
from tests.tools.objects import (
    CHIP,
    HOST,
    Objects,
    Toolchain,
    call_graph,
    compile_tree,
    sections,
    sizes_of,
)


def nav_members() -> list[str]:
    return [name for name, _ in ffi.typeof("nav_t").fields]


def ram(toolchains: list[Toolchain], folder: Path) -> Table:
    """Size of nav_t and all its members."""
    names = nav_members()
    types = {"nav_t": "nav_t"} | {f"m_{name}": f"((nav_t *)0)->{name}" for name in names}
    sizes = [sizes_of(toolchain, folder, types) for toolchain in toolchains]
    table = Table("member of nav_t", *[t.name for t in toolchains], title="nav_t [bytes]")
    for name in sorted(names, key=lambda n: -sizes[-1][f"m_{n}"]):
        table.add_row(name, *[f"{size[f'm_{name}']:,}" for size in sizes])
    rest = [size["nav_t"] - sum(size[f"m_{name}"] for name in names) for size in sizes]
    table.add_row("between them", *[f"{bytes_:,}" for bytes_ in rest], end_section=True)
    table.add_row("nav_t", *[f"{size['nav_t']:,}" for size in sizes])
    return table


def parts(objects: Objects) -> Table:
    """Code with constants, and variables, of each object."""
    table = Table("object", "flash", "static RAM", title=f"{objects.toolchain.name} [bytes]")
    for path, size in sections(objects.toolchain, *objects.all()).items():
        table.add_row(path.stem, f"{size.text + size.data:,}", f"{size.data + size.bss:,}")
    return table


def totals(objects: Objects) -> dict[str, tuple[int, int | None]]:
    """Used and permitted sizes, by the names of the README's table."""
    return {
        "static RAM, core and app": (gates.ram_bytes(objects), gates.RAM_LIMIT_BYTES),
        "of that the one `nav_t`": (gates.nav_bytes(objects), None),
        "flash, core and app": (gates.flash_bytes(objects), gates.FLASH_LIMIT_BYTES),
        "stack of the app's task": (gates.stack_bytes(objects), gates.STACK_LIMIT_BYTES),
    }


def readme_rows(objects: Objects) -> list[str]:
    """The same as rows of the README's table."""
    return [
        f"| {name} | {used:,} bytes | {f'{limit:,}' if limit else ''} |"
        for name, (used, limit) in totals(objects).items()
    ]


def main() -> None:
    console = Console()
    if not CHIP.is_there():
        sys.exit("needs gcc-arm-none-eabi and libnewlib-arm-none-eabi")
    with tempfile.TemporaryDirectory() as scratch:
        objects = compile_tree(CHIP, Path(scratch))
        console.print(ram([HOST, CHIP], Path(scratch)))
        console.print(parts(objects))
        console.print(f"deepest stack: {' > '.join(gates.deepest(call_graph(objects.folder))[1])}")
        console.print("\n".join(readme_rows(objects)))


if __name__ == "__main__":
    main()
