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
TARGETS = sorted(path.stem.removeprefix("fuzz_") for path in SOURCES.glob("fuzz_*.c"))
SANITIZERS = "address,undefined,float-cast-overflow,float-divide-by-zero"
FLAGS = (
    "-std=gnu11", "-O1", "-g", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror",
    "-Wno-unknown-pragmas", f"-fsanitize=fuzzer,{SANITIZERS}", "-fno-sanitize-recover=all",
)  # fmt: skip
LONGEST_BYTES = 256
SLOWEST_S = 60


def parts_of(target: str) -> tuple[str, ...]:
    """The link is the app's; all else is core."""
    return ("core", "app", "host") if target == "link" else ("core",)


def build(target: str, folder: Path) -> Path:
    parts = parts_of(target)
    code = [path for part in parts for path in sorted((FIRMWARE / part).glob("*.c"))]
    includes = [f"-I{FIRMWARE / part}" for part in parts]
    program = folder / f"fuzz_{target}"
    main = SOURCES / f"fuzz_{target}.c"
    subprocess.run(["clang", *FLAGS, *includes, main, *code, "-lm", "-o", program], check=True)
    return program


def fuzz(target: str, seconds: int, folder: Path = BUILD) -> str:
    """Build and run one target for a while. @return what it found, nothing if all is well"""
    corpus = folder / target
    corpus.mkdir(parents=True, exist_ok=True)
    for name, seed in NAV.items() if target == "nav" else ():
        (corpus / name).write_bytes(seed)
    program = build(target, folder)
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
    with ThreadPoolExecutor(2) as pool:
        found = dict(zip(TARGETS, pool.map(lambda name: fuzz(name, seconds), TARGETS), strict=True))
    for target, text in found.items():
        if text:
            print(f"{target}:\n{text}")
    return int(any(found.values()))


if __name__ == "__main__":
    sys.exit(main())
