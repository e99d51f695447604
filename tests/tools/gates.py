# SPDX-License-Identifier: GPL-3.0-or-later
"""What core and app must not do or exceed on the chip: each gate lists what breaks its rule.

A gate takes objects, so that tests can show it objects that break the rule on purpose.
"""

import re
from collections.abc import Callable
from pathlib import Path

from tests.tools.objects import Function, Objects, call_graph, sections, symbols

RAM_LIMIT_BYTES = 22_528
FLASH_LIMIT_BYTES = 73 * 1024
FRAME_LIMIT_BYTES = 256
STACK_LIMIT_BYTES = 2_048 - 204  # the app's task, less what a switch of tasks saves on it
# Frames that gcc cannot tell: functions of the C library, and of the firmware.
LIBRARY_BYTES = 64
FIRMWARE_BYTES = 512

# What the compiler itself may call, and the three functions that both C libraries round alike.
LIBRARY = {"memset", "memcpy", "memcmp", "memmove", "sqrtf", "floorf", "fabsf"}
FIRMWARE = {
    "appchannelHasOverflowOccurred", "appchannelReceiveDataPacket", "appchannelSendDataPacket",
    "commanderRelaxPriority", "commanderSetSetpoint", "consolePrintf", "crtpIsConnected",
    "estimatorEnqueuePosition", "estimatorEnqueueYawError",
    "logGetFloat", "logGetUint", "logGetVarId", "paramGetUint", "paramGetVarId", "paramSetFloat",
    "paramSetInt", "supervisorCanFly", "supervisorIsArmed", "supervisorIsCrashed",
    "supervisorIsFlying", "supervisorIsLocked", "supervisorIsTumbled", "usecTimestamp",
    "vTaskDelayUntil", "xTaskGetTickCount",
}  # fmt: skip
ENTRY = "appMain"
KEEPS = "dDbBcC"  # letters of nm for what is not constant

_FUSED = re.compile(r"\tvfn?m[as]\S*\t")


def kept(objects: Objects) -> list[str]:
    """Static variables: the core must keep nothing between two calls."""
    core = objects.of("core")
    named = [
        f"{path.stem} keeps {symbol.name}"
        for path, found in symbols(objects.toolchain, *core).items()
        for symbol in found
        if symbol.letter in KEEPS
    ]
    nameless = [
        f"{path.stem} has {size.data} bytes of data, {size.bss} of bss"
        for path, size in sections(objects.toolchain, *core).items()
        if size.data + size.bss > 0
    ]
    return named + nameless


def needed(objects: Objects) -> list[str]:
    """External symbols other than a few functions: no heap, no libm, no double."""
    complaints: list[str] = []
    known = set(LIBRARY)
    for part, offered in (("core", set[str]()), ("app", FIRMWARE)):
        if not (paths := objects.of(part)):
            continue
        found = symbols(objects.toolchain, *paths)
        known |= offered
        known |= {s.name for of_one in found.values() for s in of_one if s.letter not in "Uu"}
        complaints += [
            f"{path.stem} needs {symbol.name}"
            for path, of_one in found.items()
            for symbol in of_one
            if symbol.letter == "U" and symbol.name not in known
        ]
    return complaints


def fused(objects: Objects) -> list[str]:
    """Multiplications fused with an addition, which round once where a PC rounds twice."""
    listing = objects.toolchain.run("objdump", "--disassemble", *objects.of("core"))
    complaints, name = [], ""
    for line in listing.splitlines():
        if ": " in line and "file format" in line:
            name = Path(line.partition(":")[0]).stem
        elif found := _FUSED.search(line):
            complaints.append(f"{name} fuses: {found[0].strip()}")
    return complaints


def frames(objects: Objects) -> list[str]:
    """Frames that are large, or grow while they run."""
    functions = call_graph(objects.folder)
    return [
        f"{_short(name)} has a frame of {function.frame_bytes} bytes"
        for name, function in functions.items()
        if function.frame_bytes > FRAME_LIMIT_BYTES
    ] + [
        f"{_short(name)} has a frame that grows"
        for name, function in functions.items()
        if not function.is_static
    ]


def stack(objects: Objects) -> list[str]:
    """Call chains from the app's task without a bound, or too deep."""
    try:
        depth, way = deepest(call_graph(objects.folder))
    except UnboundedStack as error:
        return [str(error)]
    return [] if depth <= STACK_LIMIT_BYTES else [f"{depth} bytes of stack: {' > '.join(way)}"]


def ram(objects: Objects) -> list[str]:
    """Static memory beyond its limit."""
    used = ram_bytes(objects)
    return [] if used <= RAM_LIMIT_BYTES else [f"{used} bytes of static RAM"]


def flash(objects: Objects) -> list[str]:
    """Code and constants beyond their limit."""
    used = flash_bytes(objects)
    return [] if used <= FLASH_LIMIT_BYTES else [f"{used} bytes of flash"]


Gate = Callable[[Objects], list[str]]
OF_ANY_MACHINE: tuple[Gate, ...] = (kept, needed)
OF_ANY_FLAGS: tuple[Gate, ...] = (*OF_ANY_MACHINE, fused, stack, ram)
GATES: tuple[Gate, ...] = (*OF_ANY_FLAGS, flash, frames)


class UnboundedStack(Exception):
    """No bound of the stack can be computed."""


def deepest(functions: dict[str, Function], entry: str = ENTRY) -> tuple[int, tuple[str, ...]]:
    """Bytes of stack that a function needs with all it calls, and the chain of calls for it."""
    known: dict[str, tuple[int, tuple[str, ...]]] = {}

    def descend(name: str, above: tuple[str, ...]) -> tuple[int, tuple[str, ...]]:
        short = _short(name)
        if name in above:
            raise UnboundedStack(f"recursion: {' > '.join(map(_short, (*above, name)))}")
        if name in LIBRARY or name in FIRMWARE:
            return LIBRARY_BYTES if name in LIBRARY else FIRMWARE_BYTES, (short,)
        if name not in functions:
            raise UnboundedStack(f"{_short(above[-1])} calls {short}, whose frame is not known")
        if name not in known:
            below = [descend(callee, (*above, name)) for callee in functions[name].calls]
            depth, way = max(below, default=(0, ()))
            known[name] = functions[name].frame_bytes + depth, (short, *way)
        return known[name]

    return descend(entry, ())


def ram_bytes(objects: Objects) -> int:
    """Variables of core and app."""
    return sum(s.data + s.bss for s in sections(objects.toolchain, *objects.all()).values())


def flash_bytes(objects: Objects) -> int:
    """Code, constants and initial values of variables."""
    return sum(s.text + s.data for s in sections(objects.toolchain, *objects.all()).values())


def stack_bytes(objects: Objects) -> int:
    """Greatest stack use of the app's task."""
    return deepest(call_graph(objects.folder))[0]


def nav_bytes(objects: Objects) -> int:
    """Size of the only nav_t, as compiled into the app."""
    (found,) = symbols(objects.toolchain, objects.folder / "app" / "app_main.o").values()
    return next(symbol.size for symbol in found if symbol.name == "nav")


def _short(name: str) -> str:
    """From `file:function`, as gcc names static functions, keep the function."""
    return name.rpartition(":")[2]
