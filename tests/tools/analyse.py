# SPDX-License-Identifier: GPL-3.0-or-later
"""Run static analysers on the C code: `python -m tests.tools.analyse [NAME...]`, else all."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("core", "app", "host")
INCLUDES = [f"-Ifirmware_app/{part}" for part in PARTS]
GCC_WARNINGS = (
    "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Wcast-qual", "-Werror",
)  # fmt: skip
# Everything that clang knows, less what contradicts the project's own rules.
CLANG_WARNINGS = (
    "-Weverything", "-Werror",
    "-Wno-atomic-implicit-seq-cst",  # the strongest order is meant
    "-Wno-bad-function-cast",  # (int)floorf(x)
    "-Wno-declaration-after-statement",
    "-Wno-float-equal",  # where it stands, "any other number" is meant
    "-Wno-gnu-zero-variadic-macro-arguments",  # the firmware's own macros
    "-Wno-missing-noreturn",  # appMain is declared by the firmware
    "-Wno-padded",
    "-Wno-reserved-identifier",  # the linker's names in host/
    "-Wno-switch-enum",  # -Wswitch stays: a default says that the rest is alike
    "-Wno-unknown-pragmas",  # GCC optimize
)  # fmt: skip
CPPCHECK = (
    "cppcheck", "--quiet", "--error-exitcode=1", "--std=c11", "--max-ctu-depth=4",
    "--enable=warning,performance,portability,style",
    "--suppressions-list=tests/analysis/cppcheck.txt",
)  # fmt: skip


def sources() -> list[str]:
    """All C files that fly or stand in for the firmware, relative to the root."""
    found = [path for part in PARTS for path in (ROOT / "firmware_app" / part).glob("*.c")]
    return sorted(str(path.relative_to(ROOT)) for path in found)


def complaints_of(command: Iterable[str]) -> str:
    """The output of a failing command; nothing if it succeeds."""
    done = subprocess.run([*command], cwd=ROOT, capture_output=True, text=True)
    return done.stdout + done.stderr if done.returncode != 0 else ""


def each(command: Callable[[str], list[str]]) -> str:
    """Run a command on every source file, on all cores."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return "".join(pool.map(lambda source: complaints_of(command(source)), sources()))


def gcc() -> str:
    flags = ["-std=gnu11", "-O2", *GCC_WARNINGS, *INCLUDES]
    with TemporaryDirectory(
        prefix="wayflie-analyse-"
    ) as folder:  # a failing gcc removes its output
        return each(lambda source: ["gcc", *flags, "-c", "-o", _object(folder, source), source])


def _object(folder: str, source: str) -> str:
    return str(Path(folder, source.replace("/", "-")).with_suffix(".o"))


def clang() -> str:
    flags = ["-std=gnu11", *CLANG_WARNINGS, *INCLUDES, "-fsyntax-only"]
    return each(lambda source: ["clang", *flags, source])


def clang_tidy() -> str:
    """Run clang-tidy with the .clang-tidy at the root."""
    return each(lambda source: ["clang-tidy", "--quiet", source, "--", "-std=gnu11", *INCLUDES])


def cppcheck() -> str:
    return complaints_of([*CPPCHECK, *INCLUDES, *sources()])


@dataclass(frozen=True, slots=True)
class Reader:
    """An analyser of C, its Debian package, and what it reports."""

    program: str
    package: str
    complaints: Callable[[], str]


READERS = {
    reader.program: reader
    for reader in (
        Reader("gcc", "gcc", gcc),
        Reader("clang", "clang", clang),
        Reader("clang-tidy", "clang-tidy", clang_tidy),
        Reader("cppcheck", "cppcheck", cppcheck),
    )
}


def main() -> int:
    failed = False
    for name in sys.argv[1:] or READERS:
        there = shutil.which(name) is not None
        said = READERS[name].complaints() if there else "is missing\n"
        print(f"{name}: {said or 'nothing to say'}", flush=True)
        failed = failed or bool(said)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
