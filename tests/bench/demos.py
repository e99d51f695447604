# SPDX-License-Identifier: GPL-3.0-or-later
"""Fly the demo of every world over several seeds and print a table.

`python -m tests.bench.demos [SEEDS] [FIRST_SEED]`: whole flights through real cflib, headless.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

WORLDS = ("flat", "clutter", "door", "hall", "person", "empty")
FIGURES = ("goal_error_m", "map_error_m", "path_m", "sim_s", "realtime_factor")


def fly(world: str, seed: int, folder: Path) -> dict[str, Any]:
    """Fly one demo and return its figures."""
    report = folder / f"{world}-{seed}.json"
    command = [sys.executable, "-m", "ground", "demo", "--headless", "--world", world]
    command += ["--seed", str(seed), "--json", str(report)]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
    figures: dict[str, Any] = json.loads(report.read_text())
    return figures


def row(world: str, flights: list[dict[str, Any]]) -> str:
    """Reached, collisions, then median and worst of each figure."""
    reached = sum(flight["reached"] for flight in flights)
    collisions = sum(flight["collisions"] for flight in flights)
    cells = [f"{world:8}", f"{reached:3}/{len(flights)}", f"{collisions:4}"]
    for name in FIGURES:
        values = [flight[name] for flight in flights if flight[name] is not None]
        worst = min(values) if name == "realtime_factor" else max(values)
        cells.append(f"{statistics.median(values):8.2f} {worst:7.2f}")
    return "  ".join(cells)


def main() -> None:
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    heads = "  ".join(f"{name:>16}" for name in FIGURES)
    print(f"world    reached  hits  {heads}   (median, worst)")
    with tempfile.TemporaryDirectory() as folder:
        for world in WORLDS:
            flights = [fly(world, seed, Path(folder)) for seed in range(first, first + seeds)]
            print(row(world, flights), flush=True)


if __name__ == "__main__":
    main()
