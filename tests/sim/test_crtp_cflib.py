# SPDX-License-Identifier: GPL-3.0-or-later
"""The real cflib, over real UDP, flies the simulated Crazyflie without knowing Wayflie."""

import struct
import threading
import time
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import cflib.crtp
import pytest
from cflib.crazyflie import Crazyflie
from cflib.positioning.motion_commander import MotionCommander
from cflib.utils.multiranger import Multiranger
from cflib.utils.reset_estimator import reset_estimator

from ground.sim.process import SimulatorProcess
from tests.sim.crtp_client import PATIENT, RawClient, connect, samples, wait_until

SCANNED_PORT = 19857
PERFECT = ("--world", "empty", "--profile", "perfect", *PATIENT)

# cflib leaves the sockets of its scan, and of a link that failed, to the garbage collector.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.fixture
def simulator() -> Iterator[SimulatorProcess]:
    with SimulatorProcess(*PERFECT) as running:
        yield running


@pytest.fixture(scope="module")
def tables(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of cflib's table cache: the tables are the same for all, so they are read once."""
    return tmp_path_factory.mktemp("tables")


@pytest.fixture
def cf(simulator: SimulatorProcess, tables: Path) -> Iterator[Crazyflie]:
    with connect(simulator.uri, tables) as connected:
        yield connected


def states(cf: Crazyflie) -> list[str]:
    """The supervisor's present state: cflib may give an old answer, or none that comes late."""
    cf.supervisor._bitfield = None
    while cf.supervisor._bitfield is None:
        cf.supervisor._last_fetch_time = 0
        found = list(cf.supervisor.read_state_list())
    return found


def height_m(cf: Crazyflie) -> float:
    return next(samples(cf, 10, ["stateEstimate.z"]))[1]["stateEstimate.z"]


def x_m(cf: Crazyflie) -> float:
    return next(samples(cf, 10, ["stateEstimate.x"]))[1]["stateEstimate.x"]


def ended(cf: Crazyflie) -> bool:
    return "Finished HL trajectory" in states(cf)


def _front_m(ranger: Multiranger) -> float:
    """The front range, measured again while there is none."""
    wait_until(lambda: ranger.front is not None, "a range was measured")
    return float(ranger.front or 0.0)


def test_scan_finds_it() -> None:
    cflib.crtp.init_drivers()

    def found() -> bool:
        return simulator.uri in [uri for uri, _ in cflib.crtp.scan_interfaces()]

    with SimulatorProcess(*PERFECT, port=SCANNED_PORT) as simulator:
        wait_until(found, "it answered within the tenth of a second that a scan listens")


def test_parameters(cf: Crazyflie) -> None:
    assert float(cf.param.get_value("way.height")) > 0
    heard: list[str] = []
    cf.param.add_update_callback("way", "goalX", lambda name, value: heard.append(value))
    cf.param.set_value("way.goalX", 1.5)
    wait_until(lambda: heard[-1:] == ["1.5"], "goalX was written")

    def ask(request: Callable[..., None]) -> list[Any]:
        answers: list[Any] = []
        request("way.height", lambda name, answer: answers.append(answer))
        wait_until(lambda: bool(answers), "it was answered")
        return answers

    (default,) = ask(cf.param.get_default_value)
    assert ask(cf.param.persistent_store) == [True]
    (state,) = ask(cf.param.persistent_get_state)
    assert state.is_stored and state.stored_value == pytest.approx(default)
    assert ask(cf.param.persistent_clear) == [True]
    (state,) = ask(cf.param.persistent_get_state)
    assert not state.is_stored


def test_logging_half_floats_and_many_variables(cf: Crazyflie) -> None:
    names = [f"range.{side}" for side in ("front", "back", "left", "right", "up", "zrange")]
    names += ["stateEstimate.x", "stateEstimate.y", "pm.vbat", "pm.state", "sys.canfly"]
    _, exact = next(samples(cf, 20, ["pm.vbat"]))
    _, halves = next(samples(cf, 20, names, "FP16"))
    assert halves.keys() == set(names)
    assert halves["pm.vbat"] == pytest.approx(exact["pm.vbat"], abs=0.01)
    times = [time_ms for time_ms, _ in islice(samples(cf, 30, names, "FP16"), 10)]
    assert times == list(range(times[0], times[0] + 300, 30))


def test_two_clients_at_once(cf: Crazyflie, simulator: SimulatorProcess, tables: Path) -> None:
    first = samples(cf, 20, ["stateEstimate.x"])
    next(first)
    with connect(simulator.uri, tables) as other:
        assert "stateEstimate.y" in next(samples(other, 20, ["stateEstimate.y"]))[1]
        cf.param.set_value("way.goalY", -0.75)
        wait_until(lambda: other.param.get_value("way.goalY") == "-0.75", "the other was told")
        other.param.set_value("way.goalY", 0.25)
        wait_until(lambda: cf.param.get_value("way.goalY") == "0.25", "the first was told")
    assert "stateEstimate.x" in next(first)[1]


def test_console_reaches_clients(cf: Crazyflie, simulator: SimulatorProcess) -> None:
    text: list[str] = []
    cf.console.receivedChar.add_callback(text.append)
    cf.supervisor.send_emergency_stop()
    wait_until(lambda: "Locked, reboot required\n" in "".join(text), "it was said")
    assert "Is locked" in states(cf)
    assert "".join(text).count("Locked, reboot required\n") == 1


def test_motion_commander_takes_off_flies_and_lands(
    cf: Crazyflie, simulator: SimulatorProcess
) -> None:
    reset_estimator(cf)
    with Multiranger(cf) as ranger, MotionCommander(cf, default_height=0.4) as commander:
        wait_until(lambda: abs(height_m(cf) - 0.4) < 0.1, "it hovers")
        assert "Is flying" in states(cf)
        front_m = _front_m(ranger)
        commander.start_forward()
        wait_until(lambda: front_m - _front_m(ranger) > 0.4, "the wall is nearer")
        commander.stop()
        assert "Is flying" in states(cf)
    wait_until(lambda: "Is flying" not in states(cf), "it stood still for a while")
    assert "Is locked" not in states(cf)
    cf.close_link()
    status = simulator.stop()
    assert status["collisions"] == 0
    assert 0.5 < status["path_m"] < 2.5 and status["true_pose"][2] < 0.05


def test_high_level_commander_flies_and_lands(
    cf: Crazyflie, simulator: SimulatorProcess, tables: Path
) -> None:
    commander = cf.high_level_commander
    commander.takeoff(0.5, 1.5)
    wait_until(lambda: height_m(cf) > 0.4 and ended(cf), "it was up")
    commander.go_to(0.4, 0.2, 0.1, 0.5, 1.5, relative=True)
    wait_until(lambda: x_m(cf) > 0.3 and ended(cf), "it arrived")
    place = next(samples(cf, 10, ["stateEstimate.x", "stateEstimate.y", "stateEstimate.yaw"]))[1]
    assert place["stateEstimate.x"] == pytest.approx(0.4, abs=0.12)
    assert place["stateEstimate.y"] == pytest.approx(0.2, abs=0.12)
    assert place["stateEstimate.yaw"] == pytest.approx(28.6, abs=5)
    commander.land(0.0, 1.5)
    wait_until(lambda: "Is flying" not in states(cf), "it had landed and stood still")
    # Closing sends a zero setpoint, which nobody follows up: harmless now.
    cf.close_link()
    with connect(simulator.uri, tables) as again:
        time.sleep(2.5)
        assert "Is locked" not in states(again)
        wait_until(lambda: "Can fly" in states(again), "it is ready again")


def test_disconnecting_from_a_flying_drone_brings_it_down(
    cf: Crazyflie, simulator: SimulatorProcess, tables: Path
) -> None:
    cf.high_level_commander.takeoff(0.5, 1.0)
    wait_until(lambda: height_m(cf) > 0.3, "it was up")
    cf.close_link()
    with connect(simulator.uri, tables) as again:
        wait_until(lambda: height_m(again) < 0.1, "it fell")
        wait_until(lambda: "Is locked" in states(again), "two seconds had passed")
        assert "Is flying" not in states(again)
        assert height_m(again) < 0.1


def test_silence_in_the_air_levels_out_and_then_locks(cf: Crazyflie) -> None:
    for _ in range(20):
        cf.commander.send_hover_setpoint(0, 0, 0, 0.4)
        height_m(cf)
    assert "Is flying" in states(cf)
    wait_until(lambda: "Is locked" in states(cf), "two seconds had passed")
    wait_until(lambda: height_m(cf) < 0.1, "it fell")
    cf.high_level_commander.takeoff(0.5, 1.0)
    assert "Can fly" not in states(cf)


def test_emergency_stop_latches_for_all(
    cf: Crazyflie, simulator: SimulatorProcess, tables: Path
) -> None:
    cf.high_level_commander.takeoff(0.5, 1.0)
    wait_until(lambda: height_m(cf) > 0.3, "it was up")
    cf.supervisor.send_emergency_stop()
    wait_until(lambda: "Is locked" in states(cf), "it was locked")
    wait_until(lambda: height_m(cf) < 0.1, "it fell")
    cf.supervisor.send_crash_recovery_request()
    cf.supervisor.send_arming_request(True)
    cf.close_link()
    with connect(simulator.uri, tables) as again:
        assert "Is locked" in states(again) and "Is armed" not in states(again)


def test_emergency_stop_watchdog_must_be_fed(cf: Crazyflie) -> None:
    cf.supervisor.send_emergency_stop_watchdog()
    assert "Is locked" not in states(cf)
    wait_until(lambda: "Is locked" in states(cf), "a second had passed")


def test_arming_where_it_is_needed(tables: Path) -> None:
    with (
        SimulatorProcess(*PERFECT, "--needs-arming") as simulator,
        connect(simulator.uri, tables) as cf,
    ):
        assert "Can be armed" in states(cf) and "Can fly" not in states(cf)
        with RawClient(simulator.uri) as raw:
            refused = raw.ask(8, 0, struct.pack("<BBff?f", 7, 0, 0.5, 0, True, 1.0))
        assert refused[3] == 16
        cf.supervisor.send_arming_request(True)
        wait_until(lambda: "Can fly" in states(cf), "it was armed")
        cf.supervisor.send_arming_request(False)
        wait_until(lambda: "Is armed" not in states(cf), "it was disarmed")


def test_a_dead_simulator_ends_the_connection(simulator: SimulatorProcess, tables: Path) -> None:
    lost = threading.Event()
    with connect(simulator.uri, tables) as cf:
        cf.connection_lost.add_callback(lambda uri, reason: lost.set())
        simulator.stop()
        assert lost.wait(20)
