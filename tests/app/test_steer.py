# SPDX-License-Identifier: GPL-3.0-or-later
"""Flying by hand through the app: packets, refusals and the drone's own dead-man timer."""

import itertools
import math

import pytest

from ground.core import MissionCmd, MissionReason, MissionState
from ground.model import Ack
from ground.requests import REST, Steer, Stick
from tests.app.drone import Drone

PERIOD_S = 0.06
NUMBERS = itertools.count(1)


def steer(drone: Drone, stick: Stick, seconds: float) -> list[Ack]:
    """Send a stick as a ground station does; return the answers."""
    drone.messages()
    for _ in range(round(seconds / PERIOD_S)):
        drone.send(Steer(next(NUMBERS), stick))
        drone.run(PERIOD_S)
    return [message for message in drone.messages() if isinstance(message, Ack)]


def speed_mps(drone: Drone) -> float:
    return math.hypot(drone.readings.vx_mps, drone.readings.vy_mps)


@pytest.fixture
def flying() -> Drone:
    drone = Drone().boot()
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK
    drone.run_until(MissionState.HOVER)
    drone.send(Steer(next(NUMBERS), REST))
    steer(drone, REST, 1.0)
    return drone


def test_a_stick_moves_it_and_nobody_answers(flying: Drone) -> None:
    x_m, yaw = flying.readings.x_m, math.radians(flying.readings.yaw_deg)
    assert steer(flying, Stick(ahead_mps=0.3), 2.0) == []
    assert flying.readings.x_m - x_m == pytest.approx(0.6 * math.cos(yaw), abs=0.1)


def test_silence_of_the_ground_is_letting_go(flying: Drone) -> None:
    steer(flying, Stick(ahead_mps=0.3), 1.0)
    flying.run(0.4)
    assert speed_mps(flying) == pytest.approx(0.3, abs=0.05)
    flying.run(0.2)
    assert speed_mps(flying) < 0.05
    assert flying.state is MissionState.HOVER


def test_it_keeps_off_the_wall(flying: Drone) -> None:
    steer(flying, Stick(ahead_mps=0.5), 12.0)
    assert max(abs(flying.readings.x_m), abs(flying.readings.y_m)) < 2.0 - 0.12
    assert flying.state in (MissionState.HOVER, MissionState.AVOID)


@pytest.mark.parametrize("stick", [Stick(ahead_mps=math.nan), Stick(climb_mps=9.0)])
def test_what_makes_no_sense_is_refused_with_a_reason(flying: Drone, stick: Stick) -> None:
    answers = steer(flying, stick, 0.5)
    assert {ack.reason for ack in answers} == {MissionReason.BAD_VALUE}
    assert speed_mps(flying) < 0.05


def test_on_the_ground_and_on_a_task_it_is_refused() -> None:
    drone = Drone().boot()
    reasons = {ack.reason for ack in steer(drone, Stick(ahead_mps=0.3), 0.3)}
    assert reasons == {MissionReason.NOT_FLYING}
    drone.command(MissionCmd.TAKE_OFF)
    reasons = {ack.reason for ack in steer(drone, Stick(ahead_mps=0.3), 0.3)}
    assert reasons == {MissionReason.BUSY}
