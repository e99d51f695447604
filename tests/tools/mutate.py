# SPDX-License-Identifier: GPL-3.0-or-later
"""Mutation testing of the C code: `python -m tests.tools.mutate [PART ...]`.

In a copy of the tree, some lines of each file in core and app are changed, one at a time, and the
tests of core and app run until one fails, those named after the file first. Survivors are printed.
A survivor is a needless line, an equivalent change, or a missing test. Takes hours for all files.
"""

import argparse
import itertools
import random
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from ground import core_build
from ground.sim import firmware_build

ROOT = Path(__file__).resolve().parents[2]
PARTS = [Path("firmware_app") / part for part in ("core", "app", "host")]
MODULES = {"ground/_core": (core_build, 1), "ground/sim/_firmware": (firmware_build, 3)}
FLAGS = [*firmware_build.FLAGS, "-O1", "-Wno-cast-function-type", "-fPIC", "-c"]
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")
LONGEST_S = 600  # a change may make a loop endless
# These compile the tree anew, or fail for any change without saying what is wrong.
LEFT_OUT = {"test_selftest.py", "test_gates.py", "test_purity.py"}
NO_SHRINKING = """
from hypothesis import Phase
settings.register_profile("mutants", settings(), phases=[Phase.explicit, Phase.generate])
settings.load_profile("mutants")
"""
# Patterns in a line of C, and their replacements.
CHANGES = [
    (r" < ", " >= "), (r" > ", " <= "), (r" <= ", " > "), (r" >= ", " < "), (r" == ", " != "),
    (r" != ", " == "), (r" && ", " || "), (r" \|\| ", " && "), (r" \+ ", " - "), (r" - ", " + "),
    (r" \* ", " / "), (r"\+\+", "--"), (r" \|= ", " = "), (r"\btrue\b", "false"),
    (r"\bfalse\b", "true"), (r"(?<=[(&|] )!(?=[a-z(])", ""), (r"\b0\.0f\b", "0.5f"),
    (r"\b(?!0\.0f)(\d+\.\d+(?:e-?\d+)?f)\b", r"(1.5f * \1)"), (r"(?<== )(\d+)(?=[,;u])", r"2 + \1"),
    (r"^ +[a-z]\w*\([^=]*\);$", ""), (r"^ +[\w>.\[\]-]+ [-+*|&]?= .*[;,]$", ""),
]  # fmt: skip
_NO_CODE = re.compile(r"#| *(//|/\*|\*)|[A-Z_]|static \w+ \*?\w+\(")
Change = tuple[int, str]


def changes(text: str) -> list[Change]:
    """All possible changes: line number, counted from 0, and the changed line."""
    found = []
    for number, line in enumerate(text.splitlines()):
        code = line.partition(" //")[0]
        for pattern, instead in CHANGES if not _NO_CODE.match(line) else ():
            for match in re.finditer(pattern, code):
                new = code[: match.start()] + match.expand(instead) + code[match.end() :]
                found.append((number, new))
    return found


def chosen(every: list[Change], count: int, seed: str) -> list[Change]:
    """At most so many of them, drawn at random from equal parts of the file."""
    draw = random.Random(seed)
    bounds = [len(every) * i // count for i in range(count + 1)]
    return [draw.choice(every[a:b]) for a, b in itertools.pairwise(bounds) if a < b]


def related_tests(source: Path) -> list[str]:
    """All tests of core and app: first those of the file, then those of its family."""
    stem = source.stem.removeprefix("app_")
    names = (f"test_{stem}", f"test_{stem.split('_')[0]}")
    tests = [test for part in ("core", "app") for test in (ROOT / "tests" / part).glob("test_*.py")]
    tests.sort(key=lambda test: ([not test.stem.startswith(name) for name in names], test))
    wanted = [test for test in tests if test.name not in LEFT_OUT or test.stem == names[0]]
    return [str(test.relative_to(ROOT)) for test in wanted]


class Copy:
    """A copy of the tree, with the objects of its two extension modules."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).split():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / name)
        with (folder / "tests/conftest.py").open("a") as file:
            file.write(NO_SHRINKING)
        self.sources = [path for part in PARTS for path in sorted((folder / part).glob("*.c"))]
        for module, (build, _) in MODULES.items():
            build.make_ffibuilder().emit_c_code(f"{folder / module}.c")
            self.compile(folder / f"{module}.c")
        for source in self.sources:
            self.compile(source)

    def compile(self, source: Path) -> None:
        folders = [sysconfig.get_paths()["include"], *(self.folder / part for part in PARTS)]
        includes = [f"-I{path}" for path in folders]
        subprocess.run(["gcc", *FLAGS, *includes, source, "-o", f"{source}.o"], check=True)

    def passes(self, source: Path) -> bool:
        """Compile this file as it is now and run the tests on it."""
        self.compile(source)
        for module, (_, parts) in MODULES.items():
            place = self.folder / module
            folders = {self.folder / part for part in PARTS[:parts]}
            objects = [f"{path}.o" for path in self.sources if path.parent in folders]
            command = ["gcc", "-shared", f"{place}.c.o", *objects, "-lm", "-o", f"{place}{SUFFIX}"]
            subprocess.run(command, check=True)
        command = [sys.executable, "-m", "pytest", "-qx", "-p", "no:xdist", *related_tests(source)]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, timeout=LONGEST_S)
        return done.returncode == 0

    def try_changes(self, source: Path, count: int, seed: int) -> None:
        text = source.read_text()
        tried = chosen(changes(text), count, f"{source.name} {seed}")
        let_pass = []
        for number, new in tried:
            lines = text.splitlines()
            old, lines[number] = lines[number].strip(), new
            source.write_text("\n".join(lines))
            try:
                if self.passes(source):
                    let_pass.append(f"  {number + 1}: {old}\n    -> {new.strip()}")
            except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
                pass  # it does not compile, or does not end
        source.write_text(text)
        self.compile(source)
        print(f"{source.name}: {len(tried) - len(let_pass)} of {len(tried)}", *let_pass, sep="\n",
              flush=True)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("parts", nargs="*", default=[""], help="of file names")
    parser.add_argument("--each", type=int, default=6, help="changes per file")
    parser.add_argument("--seed", type=int, default=1, help="of the random choice")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="wayflie-mutants-") as folder:
        copy = Copy(Path(folder))
        for source in copy.sources:
            if source.parent.name != "host" and any(p in source.name for p in options.parts):
                copy.try_changes(source, options.each, options.seed)


if __name__ == "__main__":
    main()
