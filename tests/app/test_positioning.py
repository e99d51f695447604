# SPDX-License-Identifier: GPL-3.0-or-later
"""What gives the estimator the position: SLAM, Lighthouse, Loco, a client, or nothing."""

import statistics
import threading
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import pytest
from cflib.crazyflie import Crazyflie

from ground.core import MissionCmd
from ground.sim.positioning import Shadow
from ground.sim.process import SimulatorProcess
from ground.sim.runtime import Options
from tests.app.positioned import Sample, Watched
from tests.sim.crtp_client import PATIENT, connect, samples

ODOMETRY, SLAM, SLAM_ESTIMATOR, LIGHTHOUSE, LOCO, EXTERNAL = range(6)
STEP_M = 0.1
"""The app moves the estimate by no more at once."""
SAMPLE_M = 0.06
"""And the drone flies no farther in 50 ms."""
NO_FAULT = 0.0

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


def explore(slam: int, end_s: float, **options: object) -> tuple[Watched, list[Sample]]:
    """The samples of one flight, without the take-off."""
    sim = Watched(Options(**options))  # type: ignore[arg-type]
    sim.fly(slam)
    return sim, [seen for seen in sim.until(end_s) if seen.time_s > 6.0]


def median_m(values: Iterable[float]) -> float:
    return statistics.median(values)


def jumps_m(flight: list[Sample]) -> list[float]:
    """How far the map pose moved between two samples."""
    return [abs(after.pose - before.pose) for before, after in pairwise(flight)]


def test_slam_keeps_the_estimate_where_odometry_loses_it() -> None:
    drifted, kept = [], []
    for seed in (2, 3, 6):
        for slam, into in ((ODOMETRY, drifted), (SLAM_ESTIMATOR, kept)):
            _, flight = explore(slam, 120.0, profile="hard", seed=seed)
            into.append(median_m(seen.estimate_m for seen in flight))
            assert {seen.source for seen in flight} == {slam}
    print(f"estimate's error, medians: odometry {drifted}, way.slam 2 {kept}")
    assert statistics.mean(kept) < 0.6 * statistics.mean(drifted)


def test_the_estimate_follows_the_map_and_does_not_swing() -> None:
    """It is corrected in small steps and never beyond the map pose."""
    sim = Watched(Options(profile="hard", seed=4))
    sim.fly(SLAM_ESTIMATOR)
    apart_m, before = [], None
    for seen in sim.until(90.0):
        estimate = complex(sim.log("stateEstimate.x"), sim.log("stateEstimate.y"))
        if seen.time_s > 6.0:
            apart_m.append(abs(estimate - seen.pose))
            assert before is None or abs(estimate - before) < STEP_M + SAMPLE_M
        before = estimate
    assert median_m(apart_m) < 0.05
    assert max(apart_m) < 0.25


def test_the_map_is_as_good_when_the_estimator_is_fed() -> None:
    """Corrections of the estimator are not counted as motion."""
    errors = {
        slam: [
            median_m(seen.pose_m for seen in explore(slam, 90.0, profile="real", seed=seed)[1])
            for seed in (3, 5, 7)
        ]
        for slam in (SLAM, SLAM_ESTIMATOR)
    }
    fed, alone = (statistics.mean(errors[slam]) for slam in (SLAM_ESTIMATOR, SLAM))
    assert fed < alone + 0.06


def test_the_way_may_change_in_flight() -> None:
    """Neither the drone nor its map pose jumps, whatever the change."""
    sim = Watched(Options(profile="hard", seed=2))
    sim.fly(ODOMETRY)
    flight: list[Sample] = []
    ways = (SLAM_ESTIMATOR, SLAM, SLAM_ESTIMATOR, ODOMETRY, SLAM, ODOMETRY, SLAM_ESTIMATOR)
    for number, slam in enumerate(ways):
        flight += sim.until(20.0 + 10.0 * number)
        sim.set("way.slam", slam)
    flight += sim.until(100.0)
    assert {seen.source for seen in flight} == {ODOMETRY, SLAM, SLAM_ESTIMATOR}
    in_flight = [seen for seen in flight if seen.time_s > 6.0]
    assert max(jumps_m(in_flight)) < 0.25  # a match may correct it by so much
    assert sim.collisions == 0
    assert sim.log("way.fault") == NO_FAULT


@pytest.mark.parametrize(
    ("positioning", "source", "error_m"), [("lighthouse", LIGHTHOUSE, 0.03), ("loco", LOCO, 0.2)]
)
@pytest.mark.parametrize("slam", [ODOMETRY, SLAM, SLAM_ESTIMATOR])
def test_slam_stands_aside(positioning: str, source: int, error_m: float, slam: int) -> None:
    sim, flight = explore(slam, 40.0, profile="real", positioning=positioning)
    assert {seen.source for seen in flight} == {source}
    assert sim.log("way.conf") == 100
    assert median_m(seen.estimate_m for seen in flight) < error_m
    assert median_m(seen.pose_m for seen in flight) < error_m + 0.02
    assert sim.log("way.known") > 1000  # mapping goes on


@pytest.mark.parametrize("slam", [SLAM, SLAM_ESTIMATOR])
def test_slam_takes_over_while_lighthouse_is_shadowed(slam: int) -> None:
    in_the_dark_m, worst_m = [], []
    for seed in (3, 4, 5):
        sim, flight = explore(
            slam,
            75.0,
            profile="real",
            seed=seed,
            positioning="lighthouse",
            shadows=(Shadow(40.0, 60.0),),
        )
        dark = [seen for seen in flight if 41.0 < seen.time_s < 60.0]
        back = [seen for seen in flight if seen.time_s > 62.0]
        assert {seen.source for seen in dark} == {slam}
        assert {seen.source for seen in back} == {LIGHTHOUSE}
        in_the_dark_m.append(median_m(seen.pose_m for seen in dark))
        worst_m.append(max(seen.pose_m for seen in dark))
        assert median_m(seen.pose_m for seen in back) < 0.05
        assert median_m(seen.estimate_m for seen in back) < 0.03
        assert max(jumps_m(flight)) < 0.3
        assert sim.log("way.fault") == NO_FAULT
    assert statistics.mean(in_the_dark_m) < 0.1
    assert statistics.median(worst_m) < 0.25


def test_without_slam_a_shadow_is_drift() -> None:
    _, flight = explore(
        ODOMETRY, 58.0, profile="hard", seed=3, positioning="lighthouse", shadows=(Shadow(30, 60),)
    )
    assert max(seen.pose_m for seen in flight if seen.time_s < 30.0) < 0.1
    assert flight[-1].pose_m == pytest.approx(flight[-1].estimate_m, abs=0.08)


def test_turned_on_the_ground_the_estimate_creeps_but_not_the_pose() -> None:
    """The firmware turns its yaw estimate back to the initial value while the drone stands."""
    sim = Watched(Options(profile="perfect"))
    sim.fly(SLAM, MissionCmd.SCAN)
    sim.set("way.cmd", int(MissionCmd.TAKE_OFF))
    list(sim.until(9.0))
    sim.set("way.yawMode", 2)
    list(sim.until(13.0))
    sim.set("way.cmd", int(MissionCmd.LAND))
    list(sim.until(19.0))
    turned, held = sim.log("stateEstimate.yaw"), sim.log("way.yaw")
    list(sim.until(34.0))
    assert abs(turned) > 20.0
    assert abs(sim.log("stateEstimate.yaw")) < 0.5 * abs(turned)
    assert sim.log("way.yaw") == pytest.approx(held, abs=0.5)


def test_cflib_sends_positions_and_the_drone_uses_them(tmp_path: Path) -> None:
    """Motion capture, through the real cflib."""
    arguments = ("--world", "empty", "--positioning", "mocap", *PATIENT)
    with SimulatorProcess(*arguments) as simulator, connect(simulator.uri, tmp_path) as cf:
        seen = samples(cf, 50, ["way.source", "stateEstimate.x", "stateEstimate.y"])
        assert next(seen)[1]["way.source"] == SLAM
        stop = threading.Event()
        sender = threading.Thread(target=_send_positions, args=(cf, stop))
        sender.start()
        try:
            values = next(values for _, values in seen if values["way.source"] == EXTERNAL)
        finally:
            stop.set()
            sender.join()
        assert values["stateEstimate.x"] == pytest.approx(1.25, abs=0.02)
        assert values["stateEstimate.y"] == pytest.approx(-0.5, abs=0.02)
        assert next(values for _, values in seen if values["way.source"] == SLAM)


def _send_positions(cf: Crazyflie, stop: threading.Event) -> None:
    while not stop.wait(0.02):
        cf.extpos.send_extpos(1.25, -0.5, 0.0)


def test_cflib_sees_the_estimate_in_the_map(tmp_path: Path) -> None:
    """A client that knows nothing of Wayflie flies in the map's frame."""
    arguments = ("--world", "flat", "--profile", "hard", "--seed", "3", "--speed", "max", *PATIENT)
    names = ["way.x", "way.y", "stateEstimate.x", "stateEstimate.y", "way.source"]
    with SimulatorProcess(*arguments) as simulator, connect(simulator.uri, tmp_path) as cf:
        cf.param.set_value("way.slam", SLAM_ESTIMATOR)
        cf.param.set_value("way.cmd", int(MissionCmd.EXPLORE))
        apart_m = []
        for time_ms, values in samples(cf, 100, names):
            estimate = complex(values["stateEstimate.x"], values["stateEstimate.y"])
            apart_m.append(abs(estimate - complex(values["way.x"], values["way.y"])))
            if time_ms > 60_000:
                break
        assert values["way.source"] == SLAM_ESTIMATOR
        assert median_m(apart_m) < 0.06
        assert max(apart_m) < 0.3
