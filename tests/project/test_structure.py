# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands where, and who may use whom."""

import ast
import re
from pathlib import Path

import pytest

from tests.project.files import ROOT, sources, tracked

TOP_LEVEL = {
    "firmware_app",
    "ground",
    "tests",
    "Makefile",
    "README.md",
    "CHANGELOG.md",
    "pyproject.toml",
    "LICENSE",
}
LINES_MAX = {".py": 300, ".c": 450, ".h": 450, ".js": 450}
COLUMNS_MAX = {".js": 120, ".sh": 100}  # ruff and clang-format see to the others
LICENCE = "SPDX-License-Identifier: GPL-3.0-or-later"
PYTHON = sources(".py")
C = sources(".c", ".h")
GROUND = [path for path in PYTHON if path.parts[0] == "ground"]


def imports(path: Path) -> set[str]:
    """Names of all modules that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def uses(path: Path, package: str) -> bool:
    return any(name == package or name.startswith(f"{package}.") for name in imports(path))


def test_nothing_new_stands_at_the_top() -> None:
    top = {path.parts[0] for path in tracked()}
    assert {name for name in top if not name.startswith(".")} <= TOP_LEVEL


@pytest.mark.parametrize("path", [*PYTHON, *C, *sources(".sh", ".js")], ids=str)
def test_a_source_file_names_its_licence_and_stays_readable(path: Path) -> None:
    lines = (ROOT / path).read_text().splitlines()
    assert any(LICENCE in line for line in lines[:2])
    assert len(lines) <= LINES_MAX.get(path.suffix, 300)
    if path.suffix in COLUMNS_MAX:
        assert max(map(len, lines)) <= COLUMNS_MAX[path.suffix]


def test_only_the_radio_link_imports_cflib() -> None:
    users = [str(path) for path in GROUND if uses(path, "cflib")]
    assert users == ["ground/link_drivers.py", "ground/link_radio.py"]


def test_only_the_simulator_imports_mujoco() -> None:
    users = [path for path in GROUND if uses(path, "mujoco")]
    assert users
    assert all(path.parts[1] == "sim" for path in users)


def test_the_ground_station_does_not_need_the_simulator() -> None:
    """But for the commands that start it, and what installs it."""
    users = {
        path.name for path in GROUND if path.parts[1] not in ("sim",) and uses(path, "ground.sim")
    }
    assert users <= {"cli_campaign.py", "cli_records.py", "cli_start.py", "demo.py"}


def test_the_page_and_the_station_know_no_radio() -> None:
    for name in ("ground/station.py", *(str(p) for p in GROUND if p.parts[1] == "web")):
        assert not uses(Path(name), "ground.link_radio"), name


@pytest.mark.parametrize(
    "path", [p for p in C if p.parts[1] == "app" and p.parts[0] == "firmware_app"], ids=str
)
def test_the_app_includes_core_and_firmware_headers_only(path: Path) -> None:
    """Never the host's own: the same lines are compiled for the drone."""
    host_only = {"coroutine.h", "port.h", "sim_port.h", "toc.h"}
    included = set(re.findall(r'#include ["<]([^">]+)[">]', (ROOT / path).read_text()))
    assert included & host_only == set()


@pytest.mark.parametrize(
    "path", [p for p in tracked() if p.suffix not in (".png", ".webp")], ids=str
)
def test_a_file_leaves_no_work_behind(path: Path) -> None:
    text = (ROOT / path).read_text()
    marks = "|".join(("TO" + "DO", "FIX" + "ME", "XX" + "X"))
    assert re.findall(rf"\b(?:{marks})\b", text) == []
    assert "\t\n" not in text
    assert not text or text.endswith("\n")
