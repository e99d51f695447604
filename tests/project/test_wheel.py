# SPDX-License-Identifier: GPL-3.0-or-later
"""The contents of a wheel, without compiling one: `make wheel` compiles, installs and flies it."""

import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

from ground import build_extensions, docparams
from tests.project.files import ROOT, sources, tracked

BUILD = "import setuptools; setuptools.setup()"
PICTURES = {".png", ".webp"}  # of the README


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tree that is packed into a wheel, without the compiled parts."""
    folder = tmp_path_factory.mktemp("wheel")
    steps = ["-q", "egg_info", "--egg-base", str(folder), "build_py", "--build-lib"]
    command = [sys.executable, "-W", "ignore", "-c", BUILD, *steps, str(folder / "lib")]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return folder / "lib"


def test_it_holds_the_whole_package_and_nothing_else(built: Path) -> None:
    held = {path.relative_to(built) for path in built.rglob("*") if path.is_file()}
    ours = {path for path in tracked() if path.parts[0] == "ground" and path.suffix not in PICTURES}
    tables = {Path("ground", name) for name in build_extensions.TABLES}
    assert held == ours | tables


def test_the_sources_with_doc_comments_are_read_from_it(
    built: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert set(build_extensions.TABLES) == {docparams.PARAMS, docparams.LOGS, docparams.MAP}
    checkout = [docparams.source_text(name) for name in build_extensions.TABLES]
    monkeypatch.setattr(docparams, "SOURCES", built / "nowhere")
    monkeypatch.setattr(docparams, "GROUND", built / "ground")
    assert [docparams.source_text(name) for name in build_extensions.TABLES] == checkout


@pytest.mark.parametrize("lacking", ["cc", "Python.h"])
def test_without_a_compiler_it_says_what_to_install(lacking: str, tmp_path: Path) -> None:
    headers = "" if lacking == "cc" else "import sysconfig; sysconfig.get_path = lambda *_: '/no';"
    environment = {"PATH": "/usr/bin:/bin", **({"CC": "no-such-cc"} if lacking == "cc" else {})}
    steps = ["-q", "egg_info", "--egg-base", str(tmp_path), "build_ext", "--build-temp"]
    command = [sys.executable, "-W", "ignore", "-c", headers + BUILD, *steps, str(tmp_path / "t")]
    command += ["--build-lib", str(tmp_path / "lib"), "--force"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode != 0
    last = done.stderr.splitlines()[-1]
    assert last.startswith("wayflie: ") and "is missing" in last
    assert "sudo apt install gcc libc6-dev python3-dev" in last


def test_an_archive_of_the_sources_holds_all_that_is_compiled(tmp_path: Path) -> None:
    for path in tracked():  # in a copy, since it is made beside the sources
        (tmp_path / "tree" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "tree" / path).write_bytes((ROOT / path).read_bytes())
    steps = ["-q", "egg_info", "--egg-base", str(tmp_path), "sdist", "--dist-dir", str(tmp_path)]
    command = [sys.executable, "-W", "ignore", "-c", BUILD, *steps]
    subprocess.run(command, cwd=tmp_path / "tree", check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as held:
        names = {Path(*Path(name).parts[1:]) for name in held.getnames()}
    packed = [Path("firmware_app", part) for part in ("core", "app", "host")]
    assert names >= {path for path in sources(".c", ".h") if path.parent in packed}
    assert names >= {path for path in sources(".py") if path.parts[0] == "ground"}
