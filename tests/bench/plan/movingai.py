# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of computer games in the MovingAI format, cropped to the bench's size.

Source: Sturtevant, Benchmarks for Grid-Based Pathfinding, IEEE TCIAIG 4(2), 2012.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ground.errors import GroundError
from tests.bench.plan.drawing import SIDE, inflated
from tests.bench.plan.exact import Bits
from tests.bench.plan.families import Draw, worth_planning

PASSABLE = (".", "G", "S")
SCALE_MAX = 6


def load_map(path: Path) -> Bits:
    """True where the map is blocked; rows from its top."""
    lines = path.read_text(encoding="latin-1").replace("\r", "").split("\n")
    at = lines.index("map") if "map" in lines else 0
    head = dict(line.split(maxsplit=1) for line in lines[:at] if " " in line)
    if not head.keys() >= {"height", "width"}:
        raise GroundError(f"{path} is no map in the MovingAI format")
    height, width = int(head["height"]), int(head["width"])
    rows = lines[at + 1 : at + 1 + height]
    if len(rows) != height or any(len(row) < width for row in rows):
        raise GroundError(f"{path} ends before its {height} rows of {width} cells do")
    cells = np.array([list(row[:width]) for row in rows])
    return ~np.isin(cells, PASSABLE)


def crop(cells: Bits, rng: np.random.Generator) -> Bits:
    """Crop a square of a map, with up to 6 cells as one: blocked if at least half of them are."""
    largest = min(max(cells.shape) // SIDE, SCALE_MAX)
    scale = int(rng.integers(1, largest + 1)) if largest > 1 else 1
    side = scale * SIDE
    height, width = cells.shape
    framed = np.ones((max(height, side), max(width, side)), bool)
    framed[:height, :width] = cells
    y, x = (int(rng.integers(length - side + 1)) for length in framed.shape)
    square = framed[y : y + side, x : x + side].reshape(SIDE, scale, SIDE, scale)
    return np.asarray(square.mean(axis=(1, 3)) >= 0.5)


def crops_of(folder: Path) -> Draw:
    """Draws crops of the .map files in a folder and below it."""
    paths: Sequence[Path] = sorted(folder.rglob("*.map"))
    if not paths:
        raise GroundError(f"there are no .map files in {folder}")

    def movingai(rng: np.random.Generator) -> Bits:
        while True:
            cells = crop(load_map(paths[int(rng.integers(len(paths)))]), rng)
            if worth_planning(inflated(cells)):
                return cells

    return movingai
