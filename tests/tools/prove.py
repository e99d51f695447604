# SPDX-License-Identifier: GPL-3.0-or-later
"""Let Frama-C/Eva prove the absence of run-time errors: `python -m tests.tools.prove [NAME...]`.

Every harness in tests/proof/ calls its module with all values that there are. An alarm that is not
in explained.txt, or an explanation that is no longer needed, fails.
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROOF = ROOT / "tests" / "proof"
CORE = ROOT / "firmware_app" / "core"
SOURCES = {
    "geometry": ("geometry",),
    "wire": ("wire", "wire_map", "geometry"),
    "ray": ("ray", "geometry"),
    "scan": ("scan", "geometry"),
    "grid": ("grid", "grid_points", "scan", "ray", "geometry"),
}
OPTIONS = (
    "-eva", "-eva-precision", "2", "-eva-split-return", "auto", "-warn-special-float", "none",
    "-eva-msg-key=-initial-state,-final-states",
)  # fmt: skip
ALARM = re.compile(r"^\[eva:alarm\] (\S+):(\d+): Warning: ?\n  ([^\n.]+)", re.MULTILINE)
DONE = "ANALYSIS SUMMARY"


def alarms(target: str) -> set[str]:
    """File, line of code and possible error of each alarm."""
    command = ["frama-c", *OPTIONS, f"-cpp-extra-args=-I{CORE} -include {PROOF}/model.h"]
    files = [PROOF / f"prove_{target}.c", *(CORE / f"{name}.c" for name in SOURCES[target])]
    done = subprocess.run([*command, *files], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0 or DONE not in done.stdout:
        raise RuntimeError(f"frama-c did not finish:\n{done.stdout[-2000:]}{done.stderr}")
    found = set()
    for name, line, what in ALARM.findall(done.stdout):
        code = (ROOT / name).read_text().splitlines()[int(line) - 1].strip()
        found.add(f"{Path(name).name} | {code} | {what.strip()}")
    return found


def explained(target: str) -> set[str]:
    """The alarms of this target that explained.txt lists."""
    text = (PROOF / "explained.txt").read_text()
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    of_target = [line.partition(": ") for line in lines]
    return {alarm for names, _, alarm in of_target if target in names.split(", ")}


def complaints(target: str) -> str:
    found, known = alarms(target), explained(target)
    lines = [f"not explained: {alarm}" for alarm in sorted(found - known)]
    lines += [f"explained, but not met: {alarm}" for alarm in sorted(known - found)]
    return "".join(f"{line}\n" for line in lines)


def main() -> int:
    failed = False
    for target in sys.argv[1:] or SOURCES:
        said = complaints(target)
        print(f"{target}:\n{said}" if said else f"{target}: proven", flush=True)
        failed = failed or bool(said)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
