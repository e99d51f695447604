# SPDX-License-Identifier: GPL-3.0-or-later
"""Datagrams get lost, duplicated and reordered, but only once a client has connected."""

import struct
from collections import Counter
from itertools import pairwise
from pathlib import Path
from random import Random

from ground.sim.pace import Pace
from ground.sim.process import SimulatorProcess
from ground.sim.trouble import Trouble, TroubleSpec
from tests.sim.crtp_client import PATIENT, RawClient, connect

COUNT = 4000


def carried(spec: TroubleSpec) -> list[int]:
    trouble = Trouble(spec, Random(5))
    numbers = (number.to_bytes(2, "little") for number in range(COUNT))
    return [
        int.from_bytes(arrived, "little") for sent in numbers for arrived in trouble.carry(sent)
    ]


def test_no_trouble_changes_nothing() -> None:
    assert carried(TroubleSpec()) == list(range(COUNT))


def test_loss_duplication_and_reordering_have_the_given_rates() -> None:
    lossy = carried(TroubleSpec(loss=0.1))
    assert lossy == sorted(lossy) and 0.08 < 1 - len(lossy) / COUNT < 0.12
    doubled = Counter(carried(TroubleSpec(duplication=0.1)))
    assert set(doubled) == set(range(COUNT))
    assert 0.08 < sum(n == 2 for n in doubled.values()) / COUNT < 0.12
    mixed = carried(TroubleSpec(reorder=0.1))
    late = sum(b < a for a, b in pairwise(mixed))
    assert set(mixed) >= set(range(COUNT - 1)) and 0.06 < late / COUNT < 0.12


def test_clients_connect_whole_and_then_lose_datagrams_both_ways(tmp_path: Path) -> None:
    arguments = ("--world", "empty", "--profile", "perfect", "--loss", "0.5", *PATIENT)
    with SimulatorProcess(*arguments) as simulator:
        with connect(simulator.uri, tmp_path) as cf:
            assert float(cf.param.get_value("way.height")) > 0
        with RawClient(simulator.uri) as client:
            battery, _ = client.toc(5)["pm.vbat"]
            client.fetch_params()
            for _ in range(20):
                client.send(5, 1, b"\6\1" + struct.pack("<BH", 7, battery))
                client.send(5, 1, b"\3\1\1")
            stamps = []
            for _ in range(100):
                client.send(15, 3)
                stamps.append(int.from_bytes(client.receive(5, 2)[1:4], "little"))
        status = simulator.stop()
    assert stamps == sorted(stamps)
    assert 140 < (stamps[-1] - stamps[0]) / 10 < 280
    assert status["datagrams_lost_down"] > 40 and status["datagrams_lost_up"] > 5


def test_pace_keeps_real_time_speed_and_the_limit_on_datagrams() -> None:
    real = Pace(1.0, 0.01, now_s=0.0)
    assert [round(real.next_due_s(True, 0.0), 3) for _ in range(3)] == [0.01, 0.02, 0.03]
    assert real.next_due_s(True, 5.0) <= 5.0, "late: at once"
    assert real.next_due_s(True, 5.0) > 4.9, "but the past is not made up for"
    double = Pace(2.0, 0.01, now_s=0.0)
    assert double.next_due_s(True, 0.0) == 0.005
    assert round(double.next_due_s(False, 0.0), 3) == 0.015, "no hurry: as in reality"
    endless = Pace(float("inf"), 0.01, now_s=0.0)
    assert endless.next_due_s(True, 1.0) <= 1.0
    endless.sent(10_000, now_s=1.0, seen=True)
    assert endless.next_due_s(True, 1.0) > 1.5, "ten thousand datagrams need their time"
    blind = Pace(float("inf"), 0.01, now_s=0.0)
    blind.sent(1000, now_s=1.0, seen=False)
    assert blind.next_due_s(True, 1.0) > 1.5, "more of it where nobody can see them being read"
    assert endless.waits and double.waits and not real.waits
