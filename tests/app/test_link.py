# SPDX-License-Identifier: GPL-3.0-or-later
"""The app channel: each command acts once, nonsense is counted, nothing blocks."""

import math
import random

import pytest

from ground.core import (
    PACKET_BYTES,
    PATH_POINTS,
    WIRE_VERSION,
    Capability,
    MissionCmd,
    MissionReason,
    MissionState,
    WireType,
    lib,
)
from ground.link.wire import encode_request
from ground.model import Ack, Beat, Event, Hello, Point, RoutePiece
from ground.requests import Command, Heartbeat, HelloRequest, SnapshotRequest
from tests.app.drone import Drone


def take_off(sequence: int) -> Command:
    return Command(sequence, MissionCmd.TAKE_OFF, Point(0.0, 0.0))


def go_to(sequence: int, x_m: float, y_m: float) -> Command:
    return Command(sequence, MissionCmd.GOTO, Point(x_m, y_m))


def test_hello_is_answered_with_the_geometry_of_the_map(drone: Drone) -> None:
    drone.messages()
    drone.send(HelloRequest())
    drone.run(0.1)
    (hello,) = drone.messages()
    assert isinstance(hello, Hello)
    assert hello.side_cells == 128
    assert hello.cell_m == pytest.approx(0.05)


@pytest.mark.parametrize("slam", [lib.NAV_SLAM_OFF, lib.NAV_SLAM_MAP])
def test_hello_names_what_the_drone_can_do_whatever_it_is_set_to(drone: Drone, slam: int) -> None:
    drone.write("way.slam", slam)
    drone.run(0.1)
    drone.messages()
    drone.send(HelloRequest())
    drone.run(0.1)
    (hello,) = drone.messages()
    assert isinstance(hello, Hello)
    assert hello.capabilities == (
        Capability.RRTSTAR | Capability.GRID_SEARCH | Capability.SLAM | Capability.EXPLORE
    )


def test_a_command_is_acknowledged(drone: Drone) -> None:
    drone.send(take_off(7))
    drone.run(0.1)
    assert Ack(7, MissionCmd.TAKE_OFF, MissionReason.OK) in drone.messages()
    assert drone.state is MissionState.TAKEOFF


def test_a_refusal_carries_its_reason(drone: Drone) -> None:
    drone.send(go_to(1, float("nan"), 0.0))
    drone.run(0.1)
    assert Ack(1, MissionCmd.GOTO, MissionReason.BAD_VALUE) in drone.messages()
    assert drone.refused is MissionReason.BAD_VALUE
    assert "command 2 refused" in drone.console()


def test_a_repeated_sequence_acts_once_and_is_acknowledged_again(drone: Drone) -> None:
    drone.send(take_off(1))
    drone.run_until(MissionState.HOVER)
    drone.command(MissionCmd.LAND)
    drone.run_until(MissionState.IDLE)
    drone.messages()
    drone.send(take_off(1))
    drone.run(1.0)
    assert Ack(1, MissionCmd.TAKE_OFF, MissionReason.OK) in drone.messages()
    assert drone.state is MissionState.IDLE
    drone.send(take_off(2))
    drone.run(0.1)
    assert drone.state is MissionState.TAKEOFF


def test_a_heartbeat_comes_back_with_time_and_state(drone: Drone) -> None:
    drone.messages()
    drone.send(Heartbeat(513))
    drone.run(0.1)
    (beat,) = drone.messages()
    assert isinstance(beat, Beat)
    assert (beat.sequence, beat.state) == (513, MissionState.IDLE)
    assert 0 < drone.firmware.now_ms() - beat.drone_ms <= 100


def routes(drone: Drone) -> list[RoutePiece]:
    return [m for m in drone.messages() if isinstance(m, RoutePiece)]


def test_a_new_route_is_sent_and_a_snapshot_sends_it_again(drone: Drone) -> None:
    drone.messages()
    drone.send(go_to(1, 1.4, 1.0))
    drone.run_until(MissionState.FOLLOW)
    drone.run(0.5)
    sent = routes(drone)
    last = sent[-1].revision
    points = [p for piece in sent if piece.revision == last for p in piece.points]
    assert len(points) == sent[-1].total >= 2
    assert (points[-1].x_m, points[-1].y_m) == pytest.approx((1.4, 1.0), abs=0.1)
    drone.run_until(MissionState.HOVER)
    drone.messages()
    drone.send(SnapshotRequest())
    drone.run(0.5)
    messages = drone.messages()
    assert any(isinstance(m, Hello) for m in messages)
    again = [m for m in messages if isinstance(m, RoutePiece)]
    assert sum(len(m.points) for m in again) == again[-1].total
    assert all(len(m.points) <= PATH_POINTS for m in again)


def test_a_forgotten_map_takes_its_route_along(drone: Drone) -> None:
    drone.send(go_to(1, 1.4, 1.0))
    drone.run_until(MissionState.FOLLOW)
    drone.messages()
    drone.send(Command(2, MissionCmd.FORGET, Point(0.0, 0.0)))
    drone.run(0.04)
    sent = drone.messages()
    assert any(isinstance(m, Hello) and m.epoch == 2 for m in sent)
    assert any(isinstance(m, RoutePiece) and m.total == 0 for m in sent)
    assert drone.state is MissionState.SCAN
    drone.run_until(MissionState.HOVER)
    assert math.dist((drone.log("way.x"), drone.log("way.y")), (1.4, 1.0)) < 0.2


def test_the_app_goes_on_talking(drone: Drone) -> None:
    for sequence in range(500):
        drone.send(Heartbeat(sequence))
        drone.run(0.02)
        assert any(isinstance(m, Beat) and m.sequence == sequence for m in drone.messages())


def test_events_tell_the_story_without_gaps(drone: Drone) -> None:
    drone.send(take_off(1))
    drone.run_until(MissionState.HOVER)
    drone.run(0.2)
    events = [m for m in drone.messages() if isinstance(m, Event)]
    assert [e.sequence for e in events] == list(range(len(events)))
    assert [e.argument for e in events][:1] == [MissionState.TAKEOFF]
    assert events[-1].argument == MissionState.HOVER


def test_a_full_queue_loses_no_event(drone: Drone) -> None:
    drone.messages()
    drone.firmware.set_tx_free(0)
    drone.send(take_off(1))
    drone.run(0.5)
    assert drone.packets() == []
    assert drone.log("way.drops") > 0
    drone.firmware.set_tx_free(200)
    drone.run(0.5)
    events = [m for m in drone.messages() if isinstance(m, Event)]
    assert [e.sequence for e in events] == list(range(len(events)))
    assert events


def test_without_a_client_nothing_is_sent(drone: Drone) -> None:
    drone.messages()
    drone.firmware.set_connected(False)
    drone.command(MissionCmd.TAKE_OFF)
    drone.run(2.0)
    assert drone.packets() == []
    assert drone.log("way.drops") == 0


GOOD = encode_request(take_off(9))
HELLO = encode_request(HelloRequest())
NONSENSE = {
    "short": GOOD[:-1],
    "long": GOOD + b"\0",
    "version": bytes((WIRE_VERSION + 1,)) + GOOD[1:],
    "type": GOOD[:1] + b"\xee" + GOOD[2:],
    "type 0": GOOD[:1] + b"\0" + GOOD[2:],
    "one byte": b"\1",
    "full": b"\xff" * PACKET_BYTES,
    "an answer": bytes((WIRE_VERSION, WireType.ACK, 1, 0, 1, 0)),
    "a hello that answers": HELLO[:2] + b"\0" + HELLO[3:],
}


@pytest.mark.parametrize("packet", NONSENSE.values(), ids=NONSENSE.keys())
def test_nonsense_is_dropped_and_counted(drone: Drone, packet: bytes) -> None:
    drone.messages()
    assert drone.firmware.appchannel_push(packet)
    drone.run(0.1)
    assert drone.log("way.bad") == 1
    assert drone.messages() == []
    assert drone.state is MissionState.IDLE


def test_a_storm_of_noise_changes_nothing(drone: Drone) -> None:
    noise = random.Random(1)
    sent = 0
    for _ in range(200):
        for _ in range(8):
            body = noise.randbytes(noise.randint(1, PACKET_BYTES))
            sent += drone.firmware.appchannel_push(bytes((noise.choice((0, 1, 77)),)) + body[1:])
        drone.run(0.02)
    assert drone.log("way.bad") == sent == 1600
    assert drone.state is MissionState.IDLE
    drone.send(take_off(1))
    drone.run(0.1)
    assert drone.state is MissionState.TAKEOFF


def test_an_overrun_receive_queue_is_counted(drone: Drone) -> None:
    pushed = [drone.firmware.appchannel_push(encode_request(Heartbeat(i))) for i in range(12)]
    assert pushed == [True] * 10 + [False] * 2
    drone.run(0.1)
    assert drone.log("way.drops") == 1
    assert sum(isinstance(m, Beat) for m in drone.messages()) == 10
