# SPDX-License-Identifier: GPL-3.0-or-later
"""Fuzz everything that takes outside data: `python -m tests.tools.fuzz [SECONDS]`, two at a time.

What is learnt stays in build/fuzz/ and is where the next run begins.
"""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.fuzz.seeds import NAV

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "tests" / "fuzz"
FIRMWARE = ROOT / "firmware_app"
BUILD = ROOT / "build" / "fuzz"
PARTS = ("core", "app", "host")
OF_THE_APP = ("link",)
"""Targets that need more than the core."""
TARGETS = sorted(path.stem.removeprefix("fuzz_") for path in SOURCES.glob("fuzz_*.c"))
SANITIZERS = "address,undefined,float-cast-overflow,float-divide-by-zero"
FLAGS = (
    "-std=gnu11", "-O1", "-g", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror",
    "-Wno-unknown-pragmas", "-fno-sanitize-recover=all",
)  # fmt: skip
LONGEST_BYTES = 256
SLOWEST_S = 60


def objects(folder: Path) -> dict[str, list[Path]]:
    """Compile core, app and host once for all targets. @return the objects of each"""
    found = {}
    for part in PARTS:
        place = folder / part
        place.mkdir(parents=True, exist_ok=True)
        code = sorted((FIRMWARE / part).glob("*.c"))
        _clang("fuzzer-no-link", "-c", *code, cwd=place)
        found[part] = [place / f"{path.stem}.o" for path in code]
    return found


def _build(target: str, compiled: dict[str, list[Path]], folder: Path) -> Path:
    parts = PARTS if target in OF_THE_APP else PARTS[:1]
    program = folder / f"fuzz_{target}"
    linked = [path for part in parts for path in compiled[part]]
    _clang("fuzzer", SOURCES / f"fuzz_{target}.c", *linked, "-lm", "-o", program, cwd=folder)
    return program


def _clang(kind: str, *arguments: str | Path, cwd: Path) -> None:
    includes = [f"-I{FIRMWARE / part}" for part in PARTS]
    sanitizers = f"-fsanitize={kind},{SANITIZERS}"
    subprocess.run(["clang", *FLAGS, sanitizers, *includes, *arguments], cwd=cwd, check=True)


def fuzz(target: str, seconds: int, compiled: dict[str, list[Path]], folder: Path = BUILD) -> str:
    """Link and run one target for a while. @return what it found, nothing if all is well"""
    corpus = folder / target
    corpus.mkdir(parents=True, exist_ok=True)
    for name, seed in NAV.items() if target == "nav" else ():
        (corpus / name).write_bytes(seed)
    program = _build(target, compiled, folder)
    command = [
        program, f"-max_total_time={seconds}", f"-max_len={LONGEST_BYTES}", "-len_control=0",
        f"-timeout={SLOWEST_S}", f"-artifact_prefix={folder}/{target}-", corpus,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, errors="replace")
    if done.returncode == 0:
        print(f"{target}: {done.stderr.splitlines()[-1]}", flush=True)
        return ""
    lines = [line for line in done.stderr.splitlines() if "\tcov:" not in line]
    return "\n".join(lines[-60:])


def main() -> int:
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    compiled = objects(BUILD)
    with ThreadPoolExecutor(2) as pool:
        runs = pool.map(lambda name: fuzz(name, seconds, compiled), TARGETS)
        found = dict(zip(TARGETS, runs, strict=True))
    for target, text in found.items():
        if text:
            print(f"{target}:\n{text}")
    return int(any(found.values()))


if __name__ == "__main__":
    sys.exit(main())
