# SPDX-License-Identifier: GPL-3.0-or-later
"""The structure of the tree, and which part may use which."""

import ast
import functools
import re
from pathlib import Path

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
COLUMNS_MAX = {".js": 120, ".sh": 100, ".c": 100, ".h": 100}  # ruff sees to Python
LICENCE = "SPDX-License-Identifier: GPL-3.0-or-later"
PYTHON = sources(".py")
C = sources(".c", ".h")
SOURCES = [*PYTHON, *C, *sources(".sh", ".js")]
GROUND = [path for path in PYTHON if path.parts[0] == "ground"]
MAY_USE: dict[str, set[str]] = {
    "": set(),  # the modules right in ground/: words and tools of all
    "link": set(),
    "map": {"link"},
    "station": {"link", "map"},
    "record": {"link", "map", "station"},
    "web": {"link", "map", "station"},
    "sim": {"link", "map", "station", "record"},
    "cli": {"link", "map", "station", "record", "web", "sim"},
}
"""Which rooms of the ground station use which; whatever is not named uses none."""
PROGRAMS = ("__main__.py", "api.py")
"""Entrances, which begin with any room."""


def lines_of(path: Path) -> list[str]:
    return (ROOT / path).read_text().splitlines()


@functools.cache
def imports(path: Path) -> set[str]:
    """Names of all modules that a file imports anywhere."""
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


def test_each_source_file_names_its_licence() -> None:
    unnamed = [path for path in SOURCES if LICENCE not in "".join(lines_of(path)[:2])]
    assert unnamed == []


def test_each_source_file_stays_readable() -> None:
    long = [path for path in SOURCES if len(lines_of(path)) > LINES_MAX.get(path.suffix, 300)]
    assert long == []
    wide = [
        f"{path}:{number}"
        for path in SOURCES
        if path.suffix in COLUMNS_MAX
        for number, line in enumerate(lines_of(path), 1)
        if len(line) > COLUMNS_MAX[path.suffix]
    ]
    assert wide == []


def test_only_the_radio_link_imports_cflib() -> None:
    users = [str(path) for path in GROUND if uses(path, "cflib")]
    assert users == ["ground/link/drivers.py", "ground/link/radio.py"]


def test_only_the_simulator_imports_mujoco() -> None:
    users = [path for path in GROUND if uses(path, "mujoco")]
    assert users
    assert all(path.parts[1] == "sim" for path in users)


def test_arrows_in_the_ground_station_run_one_way() -> None:
    backward = []
    for path in (path for path in GROUND if path.name not in PROGRAMS):
        room = path.parts[1] if len(path.parts) > 2 else ""
        used = {one for one in MAY_USE if one and uses(path, f"ground.{one}")}
        if room in MAY_USE and not used <= {room, *MAY_USE[room]}:
            backward.append((str(path), used))
    assert backward == []


def test_only_commands_and_scripts_choose_a_radio() -> None:
    """Page and station know nothing of the radio."""
    users = {path.parts[1] for path in GROUND if uses(path, "ground.link.radio")}
    assert users == {"api.py", "cli"}


def test_the_app_includes_core_and_firmware_headers_only() -> None:
    """Never the host's own headers: the same lines are compiled for the drone."""
    host_only = {"coroutine.h", "port.h", "sim_port.h", "toc.h"}
    app = [path for path in C if path.parts[:2] == ("firmware_app", "app")]
    assert len(app) > 5
    for path in app:
        included = set(re.findall(r'#include ["<]([^">]+)[">]', (ROOT / path).read_text()))
        assert included & host_only == set(), path


def test_no_file_leaves_work_behind() -> None:
    marks = "|".join(("TO" + "DO", "FIX" + "ME", "XX" + "X"))
    for path in tracked():
        if path.suffix not in (".png", ".webp"):
            text = (ROOT / path).read_text()
            assert re.findall(rf"\b(?:{marks})\b", text) == [], path
            assert "\t\n" not in text, path
            assert not text or text.endswith("\n"), path
