# SPDX-License-Identifier: GPL-3.0-or-later
"""Every fault of the table shows in the drone's inputs, and is gone when it is over."""

import math
from collections.abc import Callable

import pytest

from ground.sim.broken import Broken
from ground.sim.crtp import Port, encode
from ground.sim.faults import FaultSpec
from ground.sim.model import RANGE_NONE_MM
from ground.sim.supervisor import Info
from tests.sim.faultbench import CLIENT, PING, Bench


@pytest.fixture
def bench() -> Bench:
    return Bench().fly(2.0)


def begin(bench: Bench, name: str, seconds: float | None = None) -> None:
    bench.simulator.faults.begin(name, seconds)
    bench.fly(0.2)


def end(bench: Bench, name: str) -> None:
    assert bench.simulator.faults.end(name)


@pytest.mark.parametrize("beam", range(5))
@pytest.mark.parametrize("kind", ["frozen", "dead", "short"])
def test_one_beam_goes_wrong_and_comes_back(bench: Bench, beam: int, kind: str) -> None:
    name = f"{('front', 'back', 'left', 'right', 'up')[beam]}-{kind}"
    begin(bench, name)
    spoilt = [ranges[beam] for ranges in bench.ranges(1.5)]
    if kind == "frozen":
        assert len(set(spoilt)) == 1
    elif kind == "dead":
        assert set(spoilt) == {RANGE_NONE_MM}
    else:
        assert max(spoilt) <= 1500
    end(bench, name)
    assert bench.simulator.faults.bench.plant.broken == Broken()


def test_all_ranges_go_wrong_together(bench: Bench) -> None:
    begin(bench, "ranges-frozen", 1.0)
    assert len(set(bench.ranges(0.7))) == 1
    bench.fly(0.5)
    assert len(set(bench.ranges(1.0))) > 5
    begin(bench, "ranges-dead", 1.0)
    assert set(bench.ranges(0.7)) == {(RANGE_NONE_MM,) * 5}
    bench.fly(0.5)
    begin(bench, "map-full", 5.0)
    assert all(600 <= mm <= 3500 for ranges in bench.ranges(2.0) for mm in ranges)


def test_without_flow_the_sensor_says_so(bench: Bench) -> None:
    begin(bench, "flow-lost")
    assert bench.seen.motion_quality == 0
    height_mm = bench.seen.zrange_mm
    bench.fly(4.0)
    assert bench.seen.var_velocity_m2ps2[0] > 0.02
    assert abs(bench.seen.zrange_mm - height_mm) < 50
    end(bench, "flow-lost")
    bench.fly(3.0)
    assert bench.seen.var_velocity_m2ps2[0] < 1e-3


def test_without_its_deck_the_height_drifts(bench: Bench) -> None:
    begin(bench, "flow-gone")
    height_mm = bench.seen.zrange_mm
    bench.fly(4.0)
    assert bench.seen.motion_quality == 0
    assert bench.seen.zrange_mm == height_mm
    assert abs(bench.truth_m[2] - bench.seen.z_m) > 0.1


def test_over_a_box_the_height_seems_less_for_a_while(bench: Bench) -> None:
    begin(bench, "box")
    bench.fly(1.5)
    assert bench.truth_m[2] - bench.seen.z_m == pytest.approx(0.15, abs=0.04)
    bench.fly(2.5)
    assert bench.truth_m[2] - bench.seen.z_m == pytest.approx(0.0, abs=0.04)


def test_the_estimate_jumps_or_runs_away(bench: Bench) -> None:
    x_m = bench.seen.x_m
    bench.simulator.faults.begin("estimate-jumps")
    bench.fly(0.01)
    assert bench.seen.x_m - x_m == pytest.approx(1.0, abs=0.05)
    begin(bench, "estimate-diverges")
    bench.fly(2.0)
    vx_mps = bench.simulator.faults.bench.plant.truth.velocity_mps[0]
    assert abs(bench.seen.vx_mps - vx_mps) > 0.3
    assert bench.seen.var_velocity_m2ps2[0] > 0.1


def test_a_hand_carries_it_and_the_odometry_has_not_noticed(bench: Bench) -> None:
    before, believed = bench.truth_m, (bench.seen.x_m, bench.seen.y_m)
    begin(bench, "kidnapped")
    assert bench.truth_m[2] == pytest.approx(0.6)
    bench.fly(2.2)
    assert math.dist(bench.truth_m[:2], before[:2]) > 0.7
    assert math.dist((bench.seen.x_m, bench.seen.y_m), believed) < 0.3
    bench.fly(2.0)
    assert bench.truth_m[2] == pytest.approx(0.4, abs=0.1)
    assert bench.simulator.status()["collisions"] == 0


def test_on_the_ground_it_is_set_down_elsewhere() -> None:
    bench = Bench()
    before = bench.truth_m
    bench.simulator.faults.begin("kidnapped", 1.0)
    for _ in range(200):
        bench.simulator.step()
    assert math.dist(bench.truth_m[:2], before[:2]) > 0.7
    assert bench.truth_m[2] == 0.0


@pytest.mark.parametrize(("name", "bit"), [("tumbled", Info.CRASHED), ("e-stop", Info.LOCKED)])
def test_what_ends_a_flight_shows_in_the_supervisor(bench: Bench, name: str, bit: Info) -> None:
    begin(bench, name)
    bench.fly(2.0)
    assert bench.seen.supervisor_info & bit
    assert bench.truth_m[2] < 0.1


@pytest.mark.parametrize(
    ("name", "most_v"), [("battery-sag", 3.45), ("battery-low", 3.3), ("battery-empty", 3.1)]
)
def test_the_battery_gives_less(bench: Bench, name: str, most_v: float) -> None:
    assert bench.seen.battery_v > 3.6
    begin(bench, name)
    bench.fly(2.5)
    assert bench.seen.battery_v < most_v


def settled(bench: Bench) -> Bench:
    """A client whose handshake is over, since only then is the link bad."""
    assert bench.answers(1) == 1
    for client in bench.radio._clients.values():
        client.settled = True
    return bench


@pytest.mark.parametrize(
    ("name", "share"),
    [
        ("ground-silent", lambda n: n == 0),
        ("packets-lost", lambda n: 10 < n < 80),
        ("packets-doubled", lambda n: n > 130),
        ("packets-late", lambda n: n == 100),
    ],
)
def test_the_way_is_bad_for_a_while(bench: Bench, name: str, share: Callable[[int], bool]) -> None:
    settled(bench)
    begin(bench, name, 2.0)
    assert share(bench.answers(100))
    bench.fly(2.0)
    list(bench.simulator.outgoing())
    assert bench.answers(100) == 100


def test_packets_overtake_others(bench: Bench) -> None:
    settled(bench)
    begin(bench, "packets-reordered")
    said = [encode(Port.LINK, 0, bytes((i,))) for i in range(50)]
    for ping in said:
        bench.simulator.deliver(CLIENT, ping)
    bench.fly(0.1)
    heard = [datagram for _, datagram in bench.simulator.outgoing() if datagram in said]
    assert len(heard) >= 48
    assert heard != sorted(heard)


def test_late_packets_are_late(bench: Bench) -> None:
    settled(bench)
    begin(bench, "packets-late")
    bench.simulator.deliver(CLIENT, PING)
    bench.fly(0.5)
    assert PING not in [datagram for _, datagram in bench.simulator.outgoing()]
    bench.fly(0.3)
    assert PING in [datagram for _, datagram in bench.simulator.outgoing()]


def test_the_app_stands_still_while_it_gets_no_time(bench: Bench) -> None:
    firmware = bench.simulator.faults.bench.firmware
    numbers = {f"{e.group}.{e.name}": i for i, e in enumerate(firmware.param_entries())}
    bench.simulator.faults.begin("time-jump", 0.8)
    firmware.param_write(numbers["way.cmd"], b"\5")
    bench.fly(0.7)
    assert firmware.param_read(numbers["way.cmd"]) == b"\5"
    bench.fly(0.2)
    assert firmware.param_read(numbers["way.cmd"]) == b"\0"


def test_walls_are_put_up_around_it_and_taken_away() -> None:
    bench = Bench(world="hall").fly(2.0)
    begin(bench, "walled-in")
    assert all(min(ranges[:4]) < 700 for ranges in bench.ranges(1.0)[3:])
    assert max(bench.seen.range_mm[:4]) < 700
    end(bench, "walled-in")
    bench.fly(0.5)
    assert max(bench.seen.range_mm[:4]) > 700
    assert bench.simulator.status()["collisions"] == 0


@pytest.mark.parametrize(
    ("name", "parameter"), [("ranger-gone", "bcMultiranger"), ("flow-gone", "bcFlow2")]
)
def test_a_deck_that_is_gone_at_the_start_is_not_found(name: str, parameter: str) -> None:
    for spec, found in ((FaultSpec(name), 0), (FaultSpec(name, at_s=0.5), 1)):
        params = Bench(spec).simulator.faults.bench.params
        identity = params.find(f"deck.{parameter}")
        assert identity is not None
        assert params.value(identity) == found
