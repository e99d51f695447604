# SPDX-License-Identifier: GPL-3.0-or-later
"""Fuzz Python's decoders: `python -m tests.tools.fuzz_python [SECONDS]`, or TARGET CASE for one.

Cases are numbered: a number is all that it takes to see one again.
"""

import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor
from itertools import count
from random import Random

from tests.fuzz.garbage import TARGETS


def case(target: str, number: int) -> None:
    TARGETS[target](Random(f"{target}/{number}"))


def fuzz(target: str, seconds: float, first: int = 0) -> tuple[int, str]:
    """Run cases for a while. @return how many, and what went wrong if something did"""
    end_s = time.monotonic() + seconds
    for number in count(first):
        try:
            case(target, number)
        except Exception:
            return number - first, f"case {target} {number}:\n{traceback.format_exc()}"
        if time.monotonic() > end_s:
            return number - first + 1, ""
    raise AssertionError


def main() -> int:
    match sys.argv[1:]:
        case [target, number]:
            case_of = int(number)
            TARGETS[target](Random(f"{target}/{case_of}"))
            return 0
        case rest:
            seconds = float(rest[0]) if rest else 60.0
    first = time.time_ns() // 1_000_000_000 * 1000  # other cases in each run
    with ProcessPoolExecutor(2) as pool:
        runs = {name: pool.submit(fuzz, name, seconds, first) for name in TARGETS}
    for name, run in runs.items():
        cases, trouble = run.result()
        print(f"{name}: {cases} cases {trouble}", flush=True)
    return int(any(run.result()[1] for run in runs.values()))


if __name__ == "__main__":
    sys.exit(main())
