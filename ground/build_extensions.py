# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the package: the C extensions that setuptools compiles, and the sources that it copies.

In a checkout, `python -m ground.build_extensions` compiles what is older than its sources.
"""

import importlib
import os
import shutil
import sys
import sysconfig
import tempfile
import warnings
from copy import copy
from pathlib import Path
from types import ModuleType

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = {
    "ground._core": "ground.core_build",
    "ground.sim._firmware": "ground.sim.firmware_build",
}
TABLES = ("app_params.c", "app_status.c", "app_map.c")
"""C sources whose doc comments ground.docparams reads."""
MISSING = (
    "wayflie: {} is missing, and two modules of C must be compiled. Debian: "
    "sudo apt install gcc libc6-dev python3-dev"
)
ELSEWHERE = "wayflie: runs on Linux only; Windows has WSL 2, macOS a virtual machine (README.md)"


class BuildExtensions(build_ext):
    """Compiles each extension as the build script of its name describes it."""

    extensions: list[Extension]
    parallel: int | None

    def finalize_options(self) -> None:
        """Compile both extensions in parallel."""
        super().finalize_options()
        self.parallel = self.parallel or os.cpu_count()

    def run(self) -> None:
        """Compile everything, or only what is outdated if main() asks."""
        if self.inplace and not self.editable_mode:
            self.extensions = [ext for ext in self.extensions if self._is_old(ext)]
        super().run()

    def build_extension(self, ext: Extension) -> None:
        """Fill in the sources of the extension, then compile it."""
        if sys.platform in ("darwin", "win32"):
            sys.exit(ELSEWHERE)
        compiler = self.compiler.compiler_so[0]
        if shutil.which(compiler) is None:
            sys.exit(MISSING.format(compiler))
        if not Path(sysconfig.get_path("include"), "Python.h").exists():
            sys.exit(MISSING.format("Python.h"))
        script, generated = _script(ext), Path(self.build_temp, f"{ext.name}.c")
        generated.parent.mkdir(parents=True, exist_ok=True)
        script.make_ffibuilder().emit_c_code(str(generated))
        code = [path for part in script.PARTS for path in sorted(part.glob("*.c"))]
        ext.sources = [str(path) for path in (generated, *code)]
        ext.include_dirs = [str(part) for part in script.PARTS]
        ext.extra_compile_args, ext.libraries = script.FLAGS, ["m"]
        # Both extensions compile the core, with different flags: keep their object files apart.
        apart = copy(self)
        apart.build_temp = str(Path(self.build_temp, ext.name))
        build_ext.build_extension(apart, ext)

    def get_source_files(self) -> list[str]:
        """The C files that belong into a source archive, relative to the root."""
        parts = {part for ext in self.extensions for part in _script(ext).PARTS}
        return sorted(str(path.relative_to(ROOT)) for part in parts for path in part.glob("*.[ch]"))

    def _is_old(self, ext: Extension) -> bool:
        built, script = Path(self.get_ext_fullpath(ext.name)), _script(ext)
        sources = [path for part in script.PARTS for path in part.glob("*.[ch]")]
        sources += (ROOT / "ground").glob("**/*build*.py")
        newest_s = max(path.stat().st_mtime for path in sources)
        return not built.exists() or built.stat().st_mtime < newest_s


def _script(ext: Extension) -> ModuleType:
    sys.path.insert(0, str(ROOT))
    return importlib.import_module(SCRIPTS[ext.name])


class BuildPython(build_py):
    """Copies C sources with doc comments beside the modules that read them."""

    def run(self) -> None:
        """Copy the package, then those sources."""
        super().run()
        if not self.editable_mode:
            for name in TABLES:
                source = ROOT / "firmware_app" / "app" / name
                self.copy_file(str(source), str(Path(self.build_lib, "ground", name)))


def main() -> None:
    """Compile in place, beside the Python modules that use the extensions."""
    os.chdir(ROOT)
    with tempfile.TemporaryDirectory(prefix="wayflie-build-") as folder:
        steps = ["build_ext", "--inplace", "--build-temp", folder, "--build-lib", folder]
        warnings.simplefilter("ignore")  # ext-modules is a new table of pyproject.toml
        setup(script_args=["--quiet", "egg_info", "--egg-base", folder, *steps])


if __name__ == "__main__":
    main()
