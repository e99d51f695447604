# SPDX-License-Identifier: GPL-3.0-or-later
"""Events and records that the app sends and resends by number, repeated commands, heartbeats."""

import random

import pytest

from ground.core import MissionCmd, MissionReason, MissionState, RecordKind, WireType
from ground.model import Ack, Beat, Event, Hello, History, Point, Record
from ground.requests import Ask, AskTiles, Command, Heartbeat, HelloRequest
from ground.sim.model import Setpoint
from tests.app.drone import Drone


def take_off(drone: Drone) -> None:
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK
    drone.run_until(MissionState.HOVER)


def epoch(drone: Drone) -> int:
    drone.messages()
    drone.send(HelloRequest())
    drone.run(0.1)
    return next(m.epoch for m in drone.messages() if isinstance(m, Hello))


@pytest.mark.parametrize("seed", range(5))
def test_commands_act_once_however_often_and_late_their_packets_come(
    drone: Drone, seed: int
) -> None:
    """Each command forgets the map, which the drone counts."""
    dice, before = random.Random(seed), epoch(drone)
    packets = [(i + dice.random() * 5, i) for i in range(30) for _ in range(4)]
    acks = []
    for _, number in sorted(packets):
        drone.send(Command((65_520 + number) % 65536, MissionCmd.FORGET))
        drone.run(0.02)
        acks += [m for m in drone.messages() if isinstance(m, Ack)]
    assert epoch(drone) == (before + 30) % 4
    assert len(acks) == len(packets)
    assert {ack.reason for ack in acks} == {MissionReason.OK}


def test_a_command_of_another_client_with_the_same_number_acts(drone: Drone) -> None:
    drone.send(Command(7, MissionCmd.HOLD))
    drone.send(Command(7, MissionCmd.TAKE_OFF))
    drone.run(0.1)
    reasons = [m.reason for m in drone.messages() if isinstance(m, Ack)]
    assert reasons == [MissionReason.NOT_FLYING, MissionReason.OK]


GOALS = [(1.0, 0.5), (9.0, 0.0), (99.0, 0.0), (float("nan"), 0.0)]


def flown(
    goal: tuple[float, float], by_packet: bool
) -> tuple[MissionReason, float, list[Setpoint]]:
    """The answer, the goal as it is shown, and all setpoints from then on."""
    drone = Drone().boot()
    take_off(drone)
    drone.setpoints.clear()
    if by_packet:
        drone.send(Command(1, MissionCmd.GOTO, Point(*goal)))
    else:
        drone.write("way.goalX", goal[0])
        drone.write("way.goalY", goal[1])
        drone.write("way.cmd", MissionCmd.GOTO)
    drone.run(4.0)
    return drone.refused, drone.log("way.goalX"), drone.setpoints


@pytest.mark.parametrize("goal", GOALS)
def test_a_goal_by_parameter_and_one_by_packet_are_the_same(goal: tuple[float, float]) -> None:
    reason, shown, setpoints = flown(goal, by_packet=True)
    assert (reason, shown, setpoints) == flown(goal, by_packet=False)
    assert (reason is MissionReason.OK) == (goal == GOALS[0])


def test_the_last_events_are_told_again(drone: Drone) -> None:
    take_off(drone)
    drone.command(MissionCmd.LAND)
    drone.run_until(MissionState.IDLE)
    first = [m for m in drone.messages() if isinstance(m, Event)]
    assert len(first) >= 3
    drone.send(Ask(WireType.EVENT, first[0].sequence, len(first) + 3))
    drone.run(0.5)
    assert [m for m in drone.messages() if isinstance(m, Event)] == first


def test_a_beat_says_what_there_is_to_ask_for(drone: Drone) -> None:
    take_off(drone)
    heard = drone.messages()
    drone.send(Heartbeat(5))
    drone.run(0.1)
    (beat,) = [m for m in drone.messages() if isinstance(m, Beat)]
    assert beat.next_event == [m for m in heard if isinstance(m, Event)][-1].sequence + 1
    records = [m for m in heard if isinstance(m, History)]
    told = records[-1].first + len(records[-1].records) if records else 0
    assert beat.next_record == told


def test_the_way_is_recorded_and_told_again(drone: Drone) -> None:
    take_off(drone)
    drone.command(MissionCmd.GOTO, (1.0, 0.0))
    drone.run_until(MissionState.HOVER)
    records = [m for m in drone.messages() if isinstance(m, History)]
    numbers = [m.first + i for m in records for i in range(len(m.records))]
    assert numbers == list(range(len(numbers)))
    poses = [r for m in records for r in m.records if r.kind is RecordKind.POSE]
    assert len(poses) >= 5
    assert abs(poses[-1].x_m - drone.log("way.x")) < 0.2
    drone.send(Ask(WireType.HISTORY, max(0, numbers[-1] - 7), 8))
    drone.run(0.5)
    again = numbered([m for m in drone.messages() if isinstance(m, History)])
    first = numbered(records)
    asked = range(max(0, numbers[-1] - 7), numbers[-1] + 1)
    assert {n: again[n] for n in asked} == {n: first[n] for n in asked}


def test_the_route_and_tiles_are_told_again(drone: Drone) -> None:
    drone.run(3.0)
    drone.messages()
    drone.send(Ask(WireType.PATH))
    drone.send(AskTiles((7, 200)))
    drone.send(Ask(WireType.ACK))
    drone.run(0.1)
    assert len(drone.messages()) == 1
    assert drone.log("way.bad") == 1


def numbered(told: list[History]) -> dict[int, Record]:
    return {m.first + i: record for m in told for i, record in enumerate(m.records)}


def fly_without_beats(drone: Drone, seconds: float) -> MissionState:
    for _ in range(round(seconds / 0.5)):
        drone.run(0.5)
    return drone.state


def test_a_ground_that_stops_beating_is_gone(drone: Drone) -> None:
    """Although its link is up: the program behind it hangs."""
    drone.write("way.lost", 3)
    take_off(drone)
    assert fly_without_beats(drone, 8.0) is MissionState.HOVER, "a script that never beat"
    for i in range(16):
        drone.send(Heartbeat(i))
        drone.run(0.5)
    assert drone.state is MissionState.HOVER
    fly_without_beats(drone, 5.0)
    assert drone.state is MissionState.HOVER
    drone.run_until(MissionState.LAND, limit_s=3.0)
