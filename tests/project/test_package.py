# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed package: the command, the versions, the data, the scripts."""

import importlib
import re
import subprocess
import tomllib
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.metadata import entry_points, version

import yaml

import ground
from tests.project.files import ROOT, sources

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
TARGETS = {
    "setup", "dev", "demo", "sim", "ground", "test", "test-cfclient", "check", "firmware", "flash",
    "sizes", "analyse", "fuzz", "prove", "docs", "wheel", "clean", "help",
}  # fmt: skip


def test_one_version() -> None:
    assert PROJECT["project"]["dynamic"] == ["version"], "it stands in ground/__init__.py only"
    assert ground.__version__ == version("wayflie")


def test_each_hook_before_a_commit_is_a_step_of_make_check() -> None:
    (local,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    steps = (ROOT / "Makefile").read_text().replace("$(BIN)", ".venv/bin")
    assert len(local["hooks"]) == 4
    for hook in local["hooks"]:
        assert f"\t{hook['entry']}" in steps


def test_the_command_is_there() -> None:
    (command,) = entry_points(group="console_scripts", name="wayflie")
    assert command.value == PROJECT["project"]["scripts"]["wayflie"]
    assert callable(command.load())


def test_both_extensions_are_compiled_by_the_scripts_that_setuptools_asks() -> None:
    names = {extension["name"] for extension in PROJECT["tool"]["setuptools"]["ext-modules"]}
    scripts = (ROOT / "ground" / "build_extensions.py").read_text()
    assert names == {"ground._core", "ground.sim._firmware"}
    for name in names:
        assert importlib.import_module(name).lib
        assert f'"{name}"' in scripts


def test_what_is_compiled_is_no_older_than_its_sources() -> None:
    """Otherwise the tests test other code: `make setup` compiles it."""
    sources_of = {"ground._core": ("core",), "ground.sim._firmware": ("core", "app", "host")}
    for name, parts in sources_of.items():
        module = ROOT / f"{name.replace('.', '/')}{EXTENSION_SUFFIXES[0]}"
        built_s = module.stat().st_mtime
        for path in sources(".c", ".h"):
            if path.parts[0] == "firmware_app" and path.parts[1] in parts:
                assert (ROOT / path).stat().st_mtime <= built_s, f"{name} is older than {path}"


def test_the_data_of_the_package_is_named() -> None:
    patterns = PROJECT["tool"]["setuptools"]["package-data"]["ground"]
    held = {path for pattern in patterns for path in (ROOT / "ground").glob(pattern)}
    wanted = {
        path for path in sources(".toml", ".js", ".css", ".html") if path.parts[0] == "ground"
    }
    assert {ROOT / path for path in wanted} <= held
    assert (ROOT / "ground" / "py.typed") in held


def test_every_dependency_has_both_bounds() -> None:
    project = PROJECT["project"]
    lists = [project["dependencies"], *project["optional-dependencies"].values()]
    open_ended = [
        name
        for names in lists
        for name in names
        if not re.search(r"==|>=[\d.]+,<", name) and not name.startswith("dask")
    ]
    assert open_ended == []


def test_make_helps_with_every_target() -> None:
    make = ["make", "--no-print-directory"]
    printed = subprocess.run(make, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert set(re.findall(r"^  make (\S+) +\S", printed, re.MULTILINE)) >= TARGETS


def test_firmware_without_a_checkout_says_what_is_missing() -> None:
    done = subprocess.run(
        ["make", "--no-print-directory", "firmware"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode != 0
    assert "CRAZYFLIE_BASE must be a checkout of crazyflie-firmware" in done.stderr


def test_the_scripts_are_scripts() -> None:
    for script in (ROOT / ".ci" / "run", *(ROOT / "tests" / "tools").glob("*.sh")):
        subprocess.run(["bash", "-n", script], check=True)
        assert script.stat().st_mode & 0o111
        assert "set -euo pipefail" in script.read_text()
