# SPDX-License-Identifier: GPL-3.0-or-later
"""The core's object files, for host and chip: no globals, no heap, small stack frames."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.tools import gates
from tests.tools.objects import (
    CHIP,
    CHIP_STRICT,
    CORE,
    HOST,
    ROOT,
    Objects,
    call_graph,
    compile_tree,
    symbols,
)

STANDARD_HEADERS = {"math.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
# Headers of the firmware with which a name of ours would be confused (its own include path).
FIRMWARE_HEADERS = {
    "app.h", "collision_avoidance.h", "commander.h", "config.h", "console.h", "controller.h",
    "crtp.h", "debug.h", "deck.h", "estimator.h", "filter.h", "flash.h", "health.h", "led.h",
    "list.h", "log.h", "math3d.h", "mem.h", "motors.h", "num.h", "param.h", "pid.h", "planner.h",
    "position_controller.h", "power_distribution.h", "pptraj.h", "queue.h", "range.h",
    "sensors.h", "stabilizer.h", "supervisor.h", "system.h", "task.h", "timers.h", "usb.h",
    "worker.h",
}  # fmt: skip


@pytest.fixture(scope="module")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Objects:
    """Core and app as the firmware compiles them."""
    return compile_tree(CHIP, tmp_path_factory.mktemp("firmware"))


@pytest.fixture(scope="module")
def strict(tmp_path_factory: pytest.TempPathFactory) -> Objects:
    """Core and app for the chip, with the flags of this machine."""
    return compile_tree(CHIP_STRICT, tmp_path_factory.mktemp("strict"))


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Objects:
    """The core for this machine."""
    return compile_tree(HOST, tmp_path_factory.mktemp("host"), parts=["core"])


@pytest.mark.parametrize("gate", gates.GATES, ids=lambda gate: gate.__name__)
def test_what_flies_passes_every_gate(gate: gates.Gate, firmware: Objects) -> None:
    assert gate(firmware) == []


@pytest.mark.parametrize("gate", gates.OF_ANY_FLAGS, ids=lambda gate: gate.__name__)
def test_with_other_flags_it_passes_too(gate: gates.Gate, strict: Objects) -> None:
    assert gate(strict) == []


@pytest.mark.parametrize("gate", gates.OF_ANY_MACHINE, ids=lambda gate: gate.__name__)
def test_on_this_machine_it_passes_too(gate: gates.Gate, host: Objects) -> None:
    assert gate(host) == []


def test_every_public_name_carries_its_module(firmware: Objects) -> None:
    modules = {path.stem for path in CORE.glob("*.h")} | {"vec2", "pose2"}
    found = symbols(firmware.toolchain, *firmware.of("core")).values()
    public = {symbol.name for of_one in found for symbol in of_one if symbol.letter in "TR"}
    assert {name for name in public if name.split("_")[0] not in modules} == set()


def test_there_is_enough_to_judge(firmware: Objects) -> None:
    assert len(call_graph(firmware.folder)) > 150
    _, way = gates.deepest(call_graph(firmware.folder))
    assert {"appMain", "nav_step"} <= set(way)


def test_every_file_includes_only_the_core_and_the_standard() -> None:
    own = {header.name for header in CORE.glob("*.h")}
    for path in CORE.glob("*.[ch]"):
        text = path.read_text()
        assert set(re.findall(r'#include "([^"]+)"', text)) <= own, path.name
        assert set(re.findall(r"#include <([^>]+)>", text)) <= STANDARD_HEADERS, path.name


def test_every_source_file_turns_contraction_off() -> None:
    """The pragma comes first; otherwise the chip would fuse a * b + c, unlike this machine."""
    pragma = re.compile(r'#pragma GCC optimize\(("O[23]", )?"fp-contract=off"\)')
    for path in CORE.glob("*.c"):
        lines = [line for line in path.read_text().splitlines() if not line.startswith("//")]
        assert pragma.fullmatch(lines[0]), path.name


def test_every_source_file_is_in_the_firmware_build() -> None:
    listed = re.findall(r"(\w+)\.o", (CORE / "Kbuild").read_text())
    assert sorted(listed) == sorted(path.stem for path in CORE.glob("*.c"))


def test_no_header_is_called_like_one_of_the_firmware() -> None:
    ours = {path.name for path in (ROOT / "firmware_app").glob("core/*.h")}
    assert ours & FIRMWARE_HEADERS == set()


def test_every_header_stands_alone(tmp_path: Path) -> None:
    sources = []
    for path in sorted(CORE.glob("*.h")):
        sources.append(tmp_path / f"{path.stem}.c")
        sources[-1].write_text(f'#include "{path.name}"\n#include "{path.name}"\n')
    command = ["gcc", "-std=c11", "-Wall", "-Wextra", "-fsyntax-only", f"-I{CORE}", *sources]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
