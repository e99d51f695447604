# SPDX-License-Identifier: GPL-3.0-or-later
"""The history: past poses, each correction, being lost and found; the latest records are kept."""

import cmath
import itertools
from typing import NamedTuple

import pytest

from ground.core import ffi, lib

POSE, MATCHED, LOST, FOUND = (
    lib.WIRE_RECORD_POSE,
    lib.WIRE_RECORD_MATCHED,
    lib.WIRE_RECORD_LOST,
    lib.WIRE_RECORD_FOUND,
)
Pose = tuple[float, float, float]


class Record(NamedTuple):
    kind: int
    place: complex
    yaw_rad: float


class Drone:
    """A nav that is nothing but a pose in the map and one of odometry, in the air."""

    def __init__(self) -> None:
        self.nav, self.history = ffi.new("nav_t *"), ffi.new("history_t *")
        self.nav.mission.state = lib.MISSION_HOVER

    def tick(self, pose: Pose, odometry: Pose, lost: bool = False) -> list[Record]:
        """The records that a tick adds."""
        self.nav.pose, self.nav.input.odometry.pose = pose, odometry
        self.nav.input.odometry.time_ms += 20
        self.nav.mission.lost = lost
        before = self.history.next
        lib.history_step(self.history, self.nav)
        return [self.record(sequence) for sequence in range(before, self.history.next)]

    def record(self, sequence: int) -> Record:
        found = ffi.new("wire_history_t *")
        assert lib.history_get(self.history, sequence, found) and found.first == sequence
        told = found.records[0]
        assert told.time_ms == self.nav.input.odometry.time_ms
        return Record(told.kind, complex(told.x_mm, told.y_mm) / 1000, told.yaw_1e4_rad / 1e4)


def test_on_its_way_it_leaves_a_pose_each_fifteen_centimetres() -> None:
    drone = Drone()
    told = [drone.tick((0.01 * i, 0.0, 0.5), (0.01 * i, 0.0, 0.5)) for i in range(101)]
    poses = [record for records in told for record in records if record.kind == POSE]
    assert len(poses) == 6
    assert all(record.yaw_rad == pytest.approx(0.5, abs=1e-4) for record in poses)
    way = [0j, *(record.place for record in poses)]
    assert all(0.148 < abs(b - a) < 0.172 for a, b in itertools.pairwise(way))


@pytest.mark.parametrize("off", [(0.02, -0.01, 0.0), (0.0, 0.0, 0.01), (-0.3, 0.2, -0.4)])
def test_a_correction_takes_what_was_believed_to_what_is(off: Pose) -> None:
    drone = Drone()
    drone.tick((0.1, 0.05, 0.3), (0.0, 0.0, 0.3))
    believed = complex(0.11, 0.05)  # a centimetre on, by odometry
    now = (believed.real + off[0], believed.imag + off[1], 0.3 + off[2])
    (matched, *rest) = drone.tick(now, (0.01, 0.0, 0.3))
    assert matched.kind == MATCHED
    assert {record.kind for record in rest} <= {POSE}
    assert matched.yaw_rad == pytest.approx(off[2], abs=1e-4)
    corrected = matched.place + cmath.rect(1.0, matched.yaw_rad) * believed
    assert corrected == pytest.approx(complex(*now[:2]), abs=2e-3)


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (0.003, 0.002, 0.0), (0.0, 0.0, 0.003)])
def test_what_odometry_explains_but_for_millimetres_is_none(off: Pose) -> None:
    drone = Drone()
    drone.tick((0.0, 0.0, 0.0), (5.0, 5.0, 0.0))
    assert drone.tick(off, (5.0, 5.0, 0.0)) == []


def test_on_the_ground_the_frames_may_be_tied_anew() -> None:
    drone = Drone()
    drone.nav.mission.state = lib.MISSION_IDLE
    assert drone.tick((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)) == []


def test_lost_and_found_are_told_even_where_nothing_is_corrected() -> None:
    drone = Drone()
    here: Pose = (0.0, 0.0, 0.0)
    kinds = [
        [record.kind for record in drone.tick(here, here, lost)]
        for lost in (False, True, True, False, False)
    ]
    assert kinds == [[], [LOST], [], [FOUND], []]


def test_the_last_are_kept_and_those_that_are_gone_are_skipped() -> None:
    drone, found = Drone(), ffi.new("wire_history_t *")
    assert not lib.history_get(drone.history, 0, found)
    for i in range(40):
        drone.tick((0.2 * (i + 1), 0.0, 0.0), (0.2 * (i + 1), 0.0, 0.0))
    oldest = 40 - lib.HISTORY_RECORDS
    for asked in range(41, -1, -1):
        there = lib.history_get(drone.history, asked, found)
        assert there == (asked < 40)
        if there:
            assert found.first == max(asked, oldest)
            assert found.count == min(lib.WIRE_RECORDS_A_PACKET, 40 - found.first)
            told = [found.records[i].x_mm for i in range(found.count)]
            assert told == [200 * (found.first + i + 1) for i in range(found.count)]
