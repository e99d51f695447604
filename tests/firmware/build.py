# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles test programs for this machine and the chip, and the cycle model for this machine."""

import atexit
import shutil
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.tools.objects import CHIP, CHIP_STRICT, CORE, FIRMWARE_APP, HOST

HERE = Path(__file__).parent
FLAG_SETS = {"strict": CHIP_STRICT, "firmware": CHIP}
"""The two ways in which the chip's program is compiled; `firmware` is the real firmware's."""

MODEL = ("m4_decode.c", "m4_cost.c", "m4_hooks.c")


@dataclass(frozen=True)
class Program:
    """A test program: its own C files and those that it tests."""

    name: str
    sources: tuple[Path, ...]
    includes: tuple[Path, ...]
    flags: tuple[str, ...] = ()


def core_program(name: str, *files: str) -> Program:
    """A program of files of this folder and the core."""
    own = tuple(HERE / file for file in files)
    return Program(name, (*own, *sorted(CORE.glob("*.c"))), (HERE, CORE))


def app_stack_bytes() -> int:
    """Stack size that the firmware is told to give the app's task; the firmware counts words."""
    text = (FIRMWARE_APP / "app-config").read_text()
    return 4 * int(text.partition("CONFIG_APP_STACKSIZE=")[2].split()[0])


def app_program() -> Program:
    """The app, the core and stand-ins for the firmware; only for the chip."""
    parts = [FIRMWARE_APP / part for part in ("app", "core", "host")]
    code = [path for part in parts for path in sorted(part.glob("*.c"))]
    code = [path for path in code if path.name != "coroutine.c"]
    own = (HERE / "calls.c", HERE / "coroutine_chip.c")
    flags = (f"-DAPP_STACK_BYTES={app_stack_bytes()}",)
    return Program("app", (*own, *code), (HERE, *parts), flags)


FLIGHT = core_program("flight", "flight.c", "bits.c")
SCENARIO = core_program("scenario", "scenario.c", "bits.c")
APP = app_program()


@cache
def workshop() -> Path:
    """A folder for what is compiled; gone when the process ends."""
    folder = Path(tempfile.mkdtemp(prefix="wayflie-chip-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def build(program: Program, flags: str | None = None) -> Path:
    """Build the program for the chip with a set of flags, or for this machine."""
    toolchain = FLAG_SETS[flags] if flags else HOST
    folder = workshop() / f"{program.name}-{flags or 'host'}"
    folder.mkdir()
    port = HERE / ("port_chip.c" if flags else "port_host.c")
    options = [*toolchain.flags, *program.flags, *(f"-I{path}" for path in program.includes)]
    if flags:
        options += ["-fstack-usage", "-fcallgraph-info=su"]
    toolchain.run("gcc", *options, "-c", port, *program.sources, cwd=folder)
    target = folder / "program"
    link: list[str] = list(toolchain.flags)
    if flags:
        link += ["-nostartfiles", "--specs=nano.specs", "--specs=nosys.specs"]
        link += ["-T", str(HERE / "chip.ld"), "-Wl,--gc-sections,--no-warn-rwx-segments"]
    objects = [path.name for path in sorted(folder.glob("*.o"))]
    toolchain.run("gcc", *link, *objects, "-lm", "-o", target, cwd=folder)
    return target


@cache
def build_model() -> Path:
    """The cycle model as a shared library."""
    target = workshop() / "m4.so"
    flags = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared")
    HOST.run("gcc", *flags, *(HERE / name for name in MODEL), "-o", target)
    return target
