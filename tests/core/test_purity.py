# SPDX-License-Identifier: GPL-3.0-or-later
"""The core as objects, for the host and the chip: no globals, no heap, small frames."""

import re
from pathlib import Path

import pytest

from tests.tools.objects import (
    CHIP,
    CORE,
    HOST,
    ROOT,
    Function,
    Symbol,
    Toolchain,
    call_graph,
    compile_core,
    sections,
    sizes_of,
    symbols,
)

# What the compiler itself may call, and the three functions that both C libraries round alike.
ALLOWED = {"memset", "memcpy", "memcmp", "memmove", "sqrtf", "floorf", "fabsf"}
STANDARD_HEADERS = {"math.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
RAM_LIMIT_BYTES = 22_528
APP_RESERVE_BYTES = 1_024  # for all that app/ keeps beside its one nav_t
FLASH_LIMIT_BYTES = 64 * 1024
FRAME_LIMIT_BYTES = 256
STACK_LIMIT_BYTES = 2_048 - 204 - 256  # the task's, less a saved context, less the app's own frames
# Headers of the firmware with which a name of ours would be confused (its own include path).
FIRMWARE_HEADERS = {
    "app.h", "collision_avoidance.h", "commander.h", "config.h", "console.h", "controller.h",
    "crtp.h", "debug.h", "deck.h", "estimator.h", "filter.h", "flash.h", "health.h", "led.h",
    "list.h", "log.h", "math3d.h", "mem.h", "motors.h", "num.h", "param.h", "pid.h", "planner.h",
    "position_controller.h", "power_distribution.h", "pptraj.h", "queue.h", "range.h",
    "sensors.h", "stabilizer.h", "supervisor.h", "system.h", "task.h", "timers.h", "usb.h",
    "worker.h",
}  # fmt: skip


@pytest.fixture(scope="module", params=[HOST, CHIP], ids=["host", "chip"])
def toolchain(request: pytest.FixtureRequest) -> Toolchain:
    chosen: Toolchain = request.param
    assert chosen.is_there(), f"{chosen.prefix}gcc is needed: apt install gcc-arm-none-eabi"
    return chosen


@pytest.fixture(scope="module")
def objects(toolchain: Toolchain, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return compile_core(toolchain, tmp_path_factory.mktemp("core"))


@pytest.fixture(scope="module")
def all_symbols(toolchain: Toolchain, objects: list[Path]) -> list[Symbol]:
    return [symbol for path in objects for symbol in symbols(toolchain, path)]


@pytest.fixture(scope="module")
def functions(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Function]:
    """The core as it runs on the chip, which alone has a small stack."""
    folder = tmp_path_factory.mktemp("chip")
    compile_core(CHIP, folder)
    return call_graph(folder)


def test_no_file_keeps_anything(toolchain: Toolchain, objects: list[Path]) -> None:
    for path in objects:
        _, data, bss = sections(toolchain, path)
        assert (path.name, data, bss) == (path.name, 0, 0)
        kept = [s.name for s in symbols(toolchain, path) if s.letter in "dDbBcC"]
        assert not kept, f"{path.name} keeps {kept}"


def test_nothing_is_needed_from_outside_but_a_few_functions(all_symbols: list[Symbol]) -> None:
    defined = {symbol.name for symbol in all_symbols if symbol.letter not in "Uu"}
    needed = {symbol.name for symbol in all_symbols if symbol.letter == "U"}
    assert needed - defined - ALLOWED == set()


def test_every_public_name_carries_its_module(all_symbols: list[Symbol]) -> None:
    modules = {path.stem for path in CORE.glob("*.h")} | {"vec2", "pose2"}
    public = {symbol.name for symbol in all_symbols if symbol.letter in "TR"}
    assert {name for name in public if name.split("_")[0] not in modules} == set()


def test_no_frame_is_large_and_none_grows(functions: dict[str, Function]) -> None:
    assert len(functions) > 100
    large = {n: f.frame_bytes for n, f in functions.items() if f.frame_bytes > FRAME_LIMIT_BYTES}
    assert large == {}
    assert [name for name, function in functions.items() if not function.is_static] == []


def test_the_stack_has_a_bound(functions: dict[str, Function]) -> None:
    """No recursion, no call through a pointer, and the deepest way down fits."""
    depths: dict[str, int] = {}

    def depth(name: str, above: tuple[str, ...]) -> int:
        assert name not in above, f"recursion: {' -> '.join((*above, name))}"
        if name in ALLOWED:
            return 0
        assert name in functions, f"{above[-1]} calls {name}, whose frame is not known"
        if name not in depths:
            below = [depth(callee, (*above, name)) for callee in functions[name].calls]
            depths[name] = functions[name].frame_bytes + max(below, default=0)
        return depths[name]

    deepest = max(functions, key=lambda name: depth(name, ()))
    assert depths[deepest] <= STACK_LIMIT_BYTES, deepest


def test_memory_stays_within_the_budget(toolchain: Toolchain, tmp_path: Path) -> None:
    sizes = sizes_of(toolchain, tmp_path, {"nav": "nav_t"})
    assert sizes["nav"] <= RAM_LIMIT_BYTES - APP_RESERVE_BYTES


def test_flash_stays_within_the_budget(toolchain: Toolchain, objects: list[Path]) -> None:
    assert sum(sections(toolchain, path)[0] for path in objects) <= FLASH_LIMIT_BYTES


@pytest.mark.parametrize("path", sorted(CORE.glob("*.[ch]")), ids=lambda path: path.name)
def test_a_file_includes_only_the_core_and_the_standard(path: Path) -> None:
    text = path.read_text()
    own = {header.name for header in CORE.glob("*.h")}
    assert set(re.findall(r'#include "([^"]+)"', text)) <= own
    assert set(re.findall(r"#include <([^>]+)>", text)) <= STANDARD_HEADERS


@pytest.mark.parametrize("path", sorted(CORE.glob("*.c")), ids=lambda path: path.name)
def test_every_source_file_turns_contraction_off(path: Path) -> None:
    """Before anything else: else the chip would fuse a * b + c and no longer equal this machine."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("//")]
    assert lines[0] == '#pragma GCC optimize("fp-contract=off")'


def test_every_source_file_is_in_the_firmware_build() -> None:
    listed = re.findall(r"(\w+)\.o", (CORE / "Kbuild").read_text())
    assert sorted(listed) == sorted(path.stem for path in CORE.glob("*.c"))


def test_no_header_is_called_like_one_of_the_firmware() -> None:
    ours = {path.name for path in (ROOT / "firmware_app").glob("core/*.h")}
    assert ours & FIRMWARE_HEADERS == set()


@pytest.mark.parametrize("path", sorted(CORE.glob("*.h")), ids=lambda path: path.name)
def test_a_header_stands_alone(path: Path, tmp_path: Path) -> None:
    source = tmp_path / "alone.c"
    source.write_text(f'#include "{path.name}"\n#include "{path.name}"\n')
    HOST.run("gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", f"-I{CORE}", source)


@pytest.mark.parametrize("path", sorted(CORE.glob("*.c")), ids=lambda path: path.name)
def test_a_source_file_stays_readable(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= 450
