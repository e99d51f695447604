# SPDX-License-Identifier: GPL-3.0-or-later
"""A client asks the drone whether it computes the same as a PC."""

from pathlib import Path

from ground.core import MissionCmd, MissionReason, MissionState, lib
from ground.model import Ack, Beat, Point
from ground.requests import Command, Heartbeat
from ground.sim.process import SimulatorProcess
from tests.app.drone import UINT8, UINT32, Drone
from tests.sim.crtp_client import PATIENT, connect, samples

NOT_RUN, RUNNING, AGREES = lib.SELFTEST_NOT_RUN, lib.SELFTEST_RUNNING, lib.SELFTEST_AGREES
LONGEST_S = 4.0


def state(drone: Drone) -> int:
    return int(drone.log("way.selfState", UINT8))


def test_it_runs_only_when_asked(drone: Drone) -> None:
    assert state(drone) == NOT_RUN
    drone.write("way.selftest", 0)
    drone.run(LONGEST_S)
    assert (state(drone), drone.console()) == (NOT_RUN, "")


def test_a_write_runs_it_and_the_log_tells_the_result(drone: Drone) -> None:
    drone.write("way.selftest", 1)
    drone.run(0.1)
    assert state(drone) == RUNNING
    drone.run(LONGEST_S)
    assert state(drone) == AGREES
    assert drone.log("way.selfHash", UINT32) == lib.selftest_golden()
    assert "self-test: computes what a PC does" in drone.console()
    drone.run(LONGEST_S)
    assert drone.console() == ""  # once


def test_a_stored_value_runs_it_at_the_start() -> None:
    drone = Drone()
    drone.force("way.selftest", 1)
    drone.boot(settle_s=0.1)
    assert state(drone) == RUNNING
    drone.run(LONGEST_S)
    assert state(drone) == AGREES


def test_nothing_of_its_flight_is_seen_outside(drone: Drone) -> None:
    drone.packets()
    drone.setpoints.clear()
    drone.write("way.selftest", 1)
    for beat in range(20):
        drone.send(Heartbeat(beat))
        drone.run(0.1)
        assert drone.state is MissionState.IDLE
    assert state(drone) == RUNNING or state(drone) == AGREES
    messages = drone.messages()
    assert {m.state for m in messages if isinstance(m, Beat)} == {MissionState.IDLE}
    assert all(isinstance(m, Beat) for m in messages)
    assert {s.mode_z for s in drone.setpoints} == {0}
    assert drone.log("way.known") == 0


def test_commands_are_refused_meanwhile_with_the_reason(drone: Drone) -> None:
    drone.write("way.selftest", 1)
    drone.run(0.1)
    drone.packets()
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.SELF_TEST
    assert "self-test is running" in drone.console()
    drone.send(Command(9, MissionCmd.GOTO, Point(1.0, 0.0)))
    drone.run(0.1)
    assert drone.messages() == [Ack(9, MissionCmd.GOTO, MissionReason.SELF_TEST)]
    drone.run(LONGEST_S)
    assert (state(drone), drone.state) == (AGREES, MissionState.IDLE)


def test_the_estimator_is_watched_meanwhile(drone: Drone) -> None:
    quiet = drone.readings.var_velocity_m2ps2
    drone.write("way.selftest", 1)
    drone.readings.var_velocity_m2ps2 = (1.0, 1.0, 1.0)
    drone.run(1.5)
    drone.readings.var_velocity_m2ps2 = quiet
    while state(drone) == RUNNING:
        drone.run(0.02)
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.ESTIMATOR
    drone.run(1.0)
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK


def test_afterwards_it_flies_with_the_values_it_had(drone: Drone) -> None:
    drone.write("way.height", 0.6)
    drone.run(0.1)
    drone.write("way.selftest", 1)
    drone.run(0.1)
    drone.write("way.speed", 0.3)
    drone.run(LONGEST_S)
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK
    drone.run_until(MissionState.HOVER)
    assert abs(drone.setpoints[-1].z_m - 0.6) < 1e-6
    assert (drone.param("way.height"), drone.param("way.speed")) != (0.4, 0.4)
    assert "refused" not in drone.console()


def test_it_is_refused_in_flight_and_once_there_is_a_map(drone: Drone) -> None:
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK
    drone.run_until(MissionState.HOVER)
    drone.console()
    drone.write("way.selftest", 1)
    drone.run(0.1)
    assert (state(drone), drone.state) == (NOT_RUN, MissionState.HOVER)
    assert "self-test refused" in drone.console()
    drone.command(MissionCmd.LAND)
    drone.run_until(MissionState.IDLE)
    known = drone.log("way.known")
    drone.write("way.selftest", 1)
    drone.run(0.1)
    assert "self-test refused" in drone.console()
    assert (state(drone), drone.log("way.known")) == (NOT_RUN, known)
    drone.command(MissionCmd.FORGET)
    drone.write("way.selftest", 1)
    drone.run(LONGEST_S)
    assert state(drone) == AGREES


def test_any_cflib_script_can_ask_for_it(tmp_path: Path) -> None:
    with (
        SimulatorProcess("--world", "empty", "--profile", "perfect", *PATIENT) as simulator,
        connect(simulator.uri, tmp_path) as cf,
    ):
        told = samples(cf, 20, ["way.selfState", "way.selfHash"])
        _, before = next(told)
        cf.param.set_value("way.selftest", 1)
        seen = [before["way.selfState"]]
        while seen[-1] in (NOT_RUN, RUNNING):
            _, after = next(told)
            seen.append(after["way.selfState"])
    assert set(seen) == {NOT_RUN, RUNNING, AGREES}
    assert seen == sorted(seen)
    assert after["way.selfHash"] == lib.selftest_golden()
