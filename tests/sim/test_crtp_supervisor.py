# SPDX-License-Identifier: GPL-3.0-or-later
"""The supervisor's rules: when motors may run, and what stops them."""

from dataclasses import replace

import pytest

from ground.sim.model import Mode, Setpoint
from ground.sim.supervisor import PERIOD_MS, Info, Inputs, Supervisor

HEALTHY = Inputs(
    now_ms=0,
    motors_run=False,
    acc_z_g=1.0,
    setpoint_age_ms=0,
    stop_parameter=False,
    high_level=Info(0),
)
FLYING = Setpoint(
    mode_x=Mode.VELOCITY, mode_y=Mode.VELOCITY, mode_z=Mode.ABSOLUTE, vx_mps=1.0, z_m=0.5
)


class Bench:
    """A supervisor with a clock."""

    def __init__(self, auto_arm: bool = True) -> None:
        self.said: list[str] = []
        self.supervisor = Supervisor(auto_arm, self.said.append)
        self.now_ms = 0

    def run(self, ms: int, **inputs: object) -> Info:
        for _ in range(0, ms, PERIOD_MS):
            self.now_ms += PERIOD_MS
            self.supervisor.update(replace(HEALTHY, now_ms=self.now_ms, **inputs))  # type: ignore[arg-type]
        return self.supervisor.info


def fly(bench: Bench) -> None:
    bench.run(200)
    assert Info.FLYING in bench.run(200, motors_run=True)


def test_arms_itself_and_knows_that_it_flies() -> None:
    bench = Bench()
    assert {Info.ARMED, Info.AUTO_ARM, Info.CAN_FLY} <= set(bench.run(200))
    fly(bench)
    assert Info.FLYING in bench.run(1900)
    assert Info.FLYING not in bench.run(200)
    assert Info.CAN_FLY in bench.run(10000)


def test_waits_for_arming_where_it_is_needed() -> None:
    bench = Bench(auto_arm=False)
    assert bench.run(1000) == Info.CAN_BE_ARMED
    assert bench.supervisor.request_arming(True)
    assert Info.CAN_FLY in bench.run(200)
    assert Info.CAN_FLY not in bench.run(31000), "armed but not flown for too long"
    assert bench.supervisor.request_arming(True)
    fly(bench)
    assert Info.ARMED not in bench.run(7000), "disarmed some seconds after landing"


def test_disarming_in_the_air_stops_without_locking() -> None:
    bench = Bench(auto_arm=False)
    bench.run(200)
    bench.supervisor.request_arming(True)
    fly(bench)
    bench.supervisor.request_arming(False)
    info = bench.run(80, motors_run=True)
    assert Info.CAN_FLY not in info and Info.LOCKED not in info


def test_old_setpoints_level_out_and_then_lock_for_good() -> None:
    bench = Bench()
    fly(bench)
    bench.run(80, motors_run=True, setpoint_age_ms=600)
    level = bench.supervisor.override(FLYING)
    assert (level.mode_x, level.mode_z, level.z_m) == (Mode.OFF, Mode.ABSOLUTE, 0.5)
    assert level.roll_deg == level.pitch_deg == level.yaw_rate_dps == 0
    bench.run(80, motors_run=True)
    assert bench.supervisor.override(FLYING) is FLYING
    assert Info.LOCKED in bench.run(160, motors_run=True, setpoint_age_ms=2100)
    assert bench.supervisor.override(FLYING) == Setpoint()
    assert bench.said == ["SUP: Locked, reboot required"]
    assert Info.LOCKED in bench.run(60000)


def test_tumbling_is_a_crash_that_can_be_recovered_from() -> None:
    bench = Bench()
    fly(bench)
    assert Info.CRASHED not in bench.run(900, motors_run=True, acc_z_g=0.4)
    info = bench.run(400, motors_run=True, acc_z_g=0.4)
    assert {Info.CRASHED, Info.TUMBLED} <= set(info) and Info.CAN_FLY not in info
    assert not bench.supervisor.request_recovery()
    bench.run(2000)
    assert Info.CAN_FLY not in bench.run(2000)
    assert bench.supervisor.request_recovery()
    assert Info.CAN_FLY in bench.run(400)


def test_upside_down_is_noticed_soon() -> None:
    bench = Bench()
    fly(bench)
    assert Info.CRASHED in bench.run(240, motors_run=True, acc_z_g=-1.0)


@pytest.mark.parametrize("flying", [False, True])
def test_emergency_stop_from_any_state(flying: bool) -> None:
    bench = Bench()
    bench.run(200, motors_run=flying)
    bench.supervisor.emergency_stop()
    assert Info.LOCKED in bench.run(120, motors_run=flying)
    assert not bench.supervisor.request_arming(True)
    assert Info.LOCKED in bench.run(60000)


def test_stop_parameter_and_watchdog_stop_too() -> None:
    stopped = Bench()
    fly(stopped)
    assert Info.LOCKED in stopped.run(120, motors_run=True, stop_parameter=True)
    watched = Bench()
    fly(watched)
    for _ in range(5):
        watched.supervisor.feed_watchdog(watched.now_ms)
        assert Info.LOCKED not in watched.run(800, motors_run=True)
    assert Info.LOCKED in watched.run(400, motors_run=True)
