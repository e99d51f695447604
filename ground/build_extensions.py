# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the C extensions when the package is installed: setuptools asks the build scripts."""

import importlib
import sys
from pathlib import Path

from setuptools import Extension
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = {
    "ground._core": "ground.core_build",
    "ground.sim._firmware": "ground.sim.firmware_build",
}


class BuildExtensions(build_ext):
    """Compiles what a build script describes under the name of the extension."""

    def build_extension(self, ext: Extension) -> None:
        """Fill in the sources of the extension, then compile it."""
        sys.path.insert(0, str(ROOT))
        script = importlib.import_module(SCRIPTS[ext.name])
        filled = script.make_ffibuilder().distutils_extension(tmpdir=self.build_temp)
        for what in ("sources", "include_dirs", "define_macros", "extra_compile_args"):
            setattr(ext, what, getattr(filled, what))
        super().build_extension(ext)
