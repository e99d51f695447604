# SPDX-License-Identifier: GPL-3.0-or-later
"""The exact geometry of exact.h, for Python."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from tests.bench.plan.compiled import HERE, exact_library

Bits = NDArray[np.bool_]
"""Cells by [row, column], True where blocked."""
Place = tuple[float, float]
"""x and y in cells."""

_WAY_POINTS = 4096


@cache
def _library() -> tuple[FFI, Any]:
    ffi = FFI()
    lines = (HERE / "exact.h").read_text().splitlines()
    ffi.cdef("\n".join(line for line in lines if not re.match(r"#", line)))
    return ffi, ffi.dlopen(str(exact_library()))


class ExactMap:
    """A map of blocked cells; what lies outside is blocked."""

    def __init__(self, blocked: Bits) -> None:
        self._ffi, self._lib = _library()
        self.height, self.width = blocked.shape
        cells = self._ffi.from_buffer(np.ascontiguousarray(blocked, np.uint8))
        made = self._lib.exact_map_new(cells, self.width, self.height)
        self._map = self._ffi.gc(made, self._lib.exact_map_free)

    def sees(self, a: Place, b: Place) -> bool:
        """Whether the straight line between two places is free."""
        ends = (self._lib.exact_point(*a), self._lib.exact_point(*b))
        return bool(self._lib.exact_segment_free(self._map, *ends, 0))

    def reachable(self, x: int, y: int) -> Bits:
        """The free cells connected to a place by steps to the 4 neighbours."""
        reached = np.zeros((self.height, self.width), np.uint8)
        self._lib.exact_reach(self._map, x, y, self._ffi.from_buffer(reached))
        return reached.astype(bool)

    def optimum(self, start: Place, goal: Place) -> tuple[float, list[Place]]:
        """Length in cells and corners of the shortest path; infinite and none without one."""
        count = self._ffi.new("int *")
        points = self._ffi.new("double[]", 2 * _WAY_POINTS)
        ends = (self._lib.exact_point(*start), self._lib.exact_point(*goal))
        length = self._lib.exact_optimum(self._map, *ends, points, _WAY_POINTS, count)
        if length < 0:
            return float("inf"), []
        return length, [(points[2 * i], points[2 * i + 1]) for i in range(count[0])]

    def way_length(self, way: Sequence[Place]) -> float | None:
        """Length of a path in cells; None if it is not free."""
        length = self._lib.exact_way_length(self._map, *self._way(way), 0)
        return None if length < 0 else float(length)

    def clearance(self, way: Sequence[Place]) -> float:
        """Least distance in cells between the path and a blocked cell of the map."""
        return float(self._lib.exact_way_clearance(self._map, *self._way(way)))

    def _way(self, way: Sequence[Place]) -> tuple[Any, int]:
        return self._ffi.new("double[]", [number for place in way for number in place]), len(way)
