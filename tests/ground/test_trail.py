# SPDX-License-Identifier: GPL-3.0-or-later
"""The trail follows the drone's corrections, whatever the order of its records."""

import math
import random

import pytest

from ground.core import MissionState, RecordKind
from ground.model import History, Point, Record
from ground.station.trail import Trail

FLYING = MissionState.FOLLOW


def line(trail: Trail, first_ms: int, last_ms: int) -> None:
    """Telemetry of a motion along x, a millimetre per millisecond."""
    for ms in range(first_ms, last_ms, 100):
        trail.put(ms, Point(ms / 1000, 0.0))


def told(trail: Trail, record: Record, number: int = 0) -> None:
    trail.take_history(History(number, (record,)), number + 1, record.drone_ms)


def test_what_had_drifted_is_taken_back_by_its_share() -> None:
    trail = Trail()
    told(trail, Record(1000, RecordKind.MATCHED, 0.0, 0.0, 0.0), 0)
    line(trail, 1000, 2000)
    told(trail, Record(2000, RecordKind.MATCHED, 0.0, 0.5, 0.0), 1)
    for point in trail.points[1:]:
        assert point.y_m == pytest.approx(0.5 * (point.x_m - 1.0))


def test_after_it_was_found_only_what_was_flown_while_lost_moves() -> None:
    trail = Trail()
    line(trail, 0, 1000)
    told(trail, Record(1000, RecordKind.LOST, 1.0, 0.0, 0.0), 0)
    line(trail, 1100, 2000)
    before = trail.points
    told(trail, Record(2000, RecordKind.FOUND, 3.0, 0.0, math.pi / 2), 1)
    assert trail.points[:10] == before[:10]
    for was, now in zip(before[10:], trail.points[10:], strict=True):
        assert (now.x_m, now.y_m) == pytest.approx((3.0, was.x_m))


@pytest.mark.parametrize("seed", range(10))
def test_the_order_in_which_records_come_does_not_matter(seed: int) -> None:
    dice = random.Random(seed)
    records = [
        Record(
            100 * i,
            RecordKind.POSE if i % 3 else RecordKind.MATCHED,
            *((i / 10, 0.0, 0.0) if i % 3 else (0.01, 0.02, 0.01)),
        )
        for i in range(60)
    ]
    straight, shuffled = Trail(), Trail()
    for i, record in enumerate(records):
        straight.take_history(History(65_500 + i, (record,)), (65_501 + i) % 65536, 100 * i)
    order = sorted(range(60), key=lambda i: i + dice.random() * 8)
    come: set[int] = set()
    for i in order:
        come.add(i)
        missing = next(n for n in range(61) if n not in come)
        number = (65_500 + i) % 65536
        shuffled.take_history(
            History(number, (records[i],)), (65_500 + missing) % 65536, 100 * max(come)
        )
    assert shuffled.points == straight.points
    assert len(straight.points) == 40


def test_a_page_is_sent_again_what_has_moved() -> None:
    trail = Trail()
    line(trail, 0, 1000)
    first, points, mark = trail.since((0, 0))
    shown = points
    line(trail, 1000, 2000)
    told(trail, Record(2000, RecordKind.MATCHED, 0.2, 0.0, 0.0))
    first, points, mark = trail.since(mark)
    shown = [*shown[:first], *points]
    assert tuple(shown) == trail.points
    assert trail.since(mark) == (len(shown), [], mark)
    assert shown[0] == Point(0.2, 0.0), "no correction before it: all of it moves"
