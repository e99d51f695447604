# SPDX-License-Identifier: GPL-3.0-or-later
"""What the core needs, as a table: `python -m tests.tools.sizes`."""

import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

from ground.core import ffi
from tests.tools.objects import CHIP, HOST, Toolchain, compile_core, sections, sizes_of

RAM_LIMIT = 22_528
FLASH_LIMIT = 64 * 1024


def nav_members() -> list[str]:
    return [name for name, _ in ffi.typeof("nav_t").fields]


def ram(toolchains: list[Toolchain], folder: Path) -> Table:
    """nav_t, its larger members, and the rest."""
    names = nav_members()
    types = {"nav_t": "nav_t"} | {f"m_{name}": f"((nav_t *)0)->{name}" for name in names}
    sizes = [sizes_of(toolchain, folder, types) for toolchain in toolchains]
    table = Table("member of nav_t", *[t.name for t in toolchains], title="RAM [bytes]")
    large = sorted(
        (n for n in names if sizes[-1][f"m_{n}"] >= 64), key=lambda n: -sizes[-1][f"m_{n}"]
    )
    for name in large:
        table.add_row(name, *[f"{size[f'm_{name}']:,}" for size in sizes])
    rest = [size["nav_t"] - sum(size[f"m_{name}"] for name in large) for size in sizes]
    table.add_row("all else", *[f"{bytes_:,}" for bytes_ in rest], end_section=True)
    table.add_row("nav_t", *[f"{size['nav_t']:,}" for size in sizes])
    table.add_row("limit, app included", *[f"{RAM_LIMIT:,}" for _ in sizes])
    return table


def flash(toolchain: Toolchain, folder: Path) -> Table:
    """Code and constants of each object."""
    table = Table("object", toolchain.name, title="Flash [bytes]")
    total = 0
    for path in compile_core(toolchain, folder):
        text, _, _ = sections(toolchain, path)
        total += text
        table.add_row(path.stem, f"{text:,}")
    table.add_section()
    table.add_row("core", f"{total:,}")
    table.add_row("limit, app included", f"{FLASH_LIMIT:,}")
    return table


def main() -> None:
    toolchains = [toolchain for toolchain in (HOST, CHIP) if toolchain.is_there()]
    console = Console()
    with tempfile.TemporaryDirectory() as scratch:
        console.print(ram(toolchains, Path(scratch)))
        console.print(flash(toolchains[-1], Path(scratch)))
    if CHIP not in toolchains:
        console.print("The chip's figures need gcc-arm-none-eabi and libnewlib-arm-none-eabi.")


if __name__ == "__main__":
    main()
