# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone's path, as known now: a correction of its map pose also moves the path behind it."""

from __future__ import annotations

import bisect
import math
from collections import deque
from dataclasses import replace

from ground.core import RecordKind
from ground.link.logstream import near
from ground.link.wire import SEQUENCES
from ground.model import History, Point, Record

POINTS = 4000
STEP_M = 0.05
CHANGES = 64


class Trail:
    """Points in order of the drone's clock, from telemetry and from records, which fill its gaps.
    Readers of since() pass back the `mark` that the last call returned."""

    def __init__(self) -> None:
        self._times_ms: list[int] = []
        self._points: list[Point] = []
        self._changes: deque[tuple[int, int]] = deque(maxlen=CHANGES)
        self._revision = 0
        self._waiting: dict[int, Record] = {}
        self._corrected_ms: int | None = None
        self._lost_ms: int | None = None
        self.last_correction: Record | None = None

    def __len__(self) -> int:
        return len(self._points)

    @property
    def points(self) -> tuple[Point, ...]:
        """All points of the path."""
        return tuple(self._points)

    def put(self, at_ms: int, here: Point) -> None:
        """Add a position at its time, unless its neighbours are as near as STEP_M."""
        index = bisect.bisect_right(self._times_ms, at_ms)
        beside = self._points[max(0, index - 1) : index + 1]
        if any(max(abs(p.x_m - here.x_m), abs(p.y_m - here.y_m)) < STEP_M for p in beside):
            return
        if index < len(self._points):
            self._changed(index)
        self._times_ms.insert(index, at_ms)
        self._points.insert(index, here)
        if len(self._points) > POINTS:
            del self._times_ms[: POINTS // 4], self._points[: POINTS // 4]
            self._changed(0)

    def take_history(self, history: History, first_missing: int, now_ms: int) -> None:
        """Take records in any order; only those before the first missing one are used yet."""
        for offset, record in enumerate(history.records):
            self._waiting[(history.first + offset) % SEQUENCES] = record
        ready = [n for n in self._waiting if 0 < (first_missing - n) % SEQUENCES < SEQUENCES // 2]
        for number in sorted(ready, key=lambda n: (n - first_missing) % SEQUENCES):
            self._take_record(self._waiting.pop(number), now_ms)

    def since(self, mark: tuple[int, int]) -> tuple[int, list[Point], tuple[int, int]]:
        """What is new or has moved: index of its first point, the points, and the next mark."""
        revision, count = mark
        oldest = self._changes[0][0] if self._changes else 0
        if revision < oldest - 1 or revision > self._revision or count > len(self._points):
            return 0, list(self._points), (self._revision, len(self._points))
        first = min((index for at, index in self._changes if at > revision), default=count)
        first = min(first, count)
        return first, self._points[first:], (self._revision, len(self._points))

    def _take_record(self, record: Record, now_ms: int) -> None:
        at_ms = near(record.drone_ms, now_ms)
        match record.kind:
            case RecordKind.POSE:
                self.put(at_ms, Point(record.x_m, record.y_m))
            case RecordKind.LOST:
                self._lost_ms = at_ms
            case RecordKind.MATCHED:
                self._move(record, self._corrected_ms, at_ms)
                self._corrected_ms = at_ms
            case RecordKind.FOUND:
                self._move(record, None, at_ms, after_ms=self._lost_ms)
                self._corrected_ms, self._lost_ms = at_ms, None

    def _move(
        self, by: Record, since_ms: int | None, at_ms: int, after_ms: int | None = None
    ) -> None:
        """Correct points before at_ms: fully after after_ms, or growing linearly from since_ms."""
        self.last_correction = replace(by, drone_ms=at_ms)
        start_ms = since_ms if since_ms is not None else after_ms
        first = bisect.bisect_right(self._times_ms, start_ms) if start_ms is not None else 0
        last = bisect.bisect_left(self._times_ms, at_ms)
        if first >= last:
            return
        cosine, sine = math.cos(by.yaw_rad), math.sin(by.yaw_rad)
        for i in range(first, last):
            grown = 1.0
            if since_ms is not None and at_ms > since_ms:
                grown = (self._times_ms[i] - since_ms) / (at_ms - since_ms)
            p = self._points[i]
            x_m = cosine * p.x_m - sine * p.y_m + by.x_m
            y_m = sine * p.x_m + cosine * p.y_m + by.y_m
            self._points[i] = Point(p.x_m + grown * (x_m - p.x_m), p.y_m + grown * (y_m - p.y_m))
        self._changed(first)

    def _changed(self, index: int) -> None:
        self._revision += 1
        self._changes.append((self._revision, index))
