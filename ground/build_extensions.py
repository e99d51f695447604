# SPDX-License-Identifier: GPL-3.0-or-later
"""How the package is built: what setuptools asks to compile, and what it copies besides."""

import importlib
import shutil
import sys
import sysconfig
from pathlib import Path

from setuptools import Extension
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = {
    "ground._core": "ground.core_build",
    "ground.sim._firmware": "ground.sim.firmware_build",
}
TABLES = ("app_params.c", "app_status.c", "app_map.c")
"""Sources whose doc comments ground.docparams reads."""
MISSING = (
    "wayflie: {} is missing, and two modules of C must be compiled. Debian: "
    "sudo apt install gcc libc6-dev python3-dev"
)


class BuildExtensions(build_ext):
    """Compiles what a build script describes under the name of the extension."""

    def build_extension(self, ext: Extension) -> None:
        """Fill in the sources of the extension, then compile it."""
        compiler = self.compiler.compiler_so[0]
        if shutil.which(compiler) is None:
            sys.exit(MISSING.format(compiler))
        if not Path(sysconfig.get_path("include"), "Python.h").exists():
            sys.exit(MISSING.format("Python.h"))
        sys.path.insert(0, str(ROOT))
        script = importlib.import_module(SCRIPTS[ext.name])
        filled = script.make_ffibuilder().distutils_extension(tmpdir=self.build_temp)
        for what in ("sources", "include_dirs", "define_macros", "extra_compile_args"):
            setattr(ext, what, getattr(filled, what))
        super().build_extension(ext)


class BuildPython(build_py):
    """Puts the sources with doc comments beside the modules that read them."""

    def run(self) -> None:
        """Copy the package, then those."""
        super().run()
        if not self.editable_mode:
            for name in TABLES:
                source = ROOT / "firmware_app" / "app" / name
                self.copy_file(str(source), str(Path(self.build_lib, "ground", name)))
