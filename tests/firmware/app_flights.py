# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole simulated flights of the app, with a client on the radio, and all inputs of the app.

It is the simulator that users fly, with the app compiled for this machine; the recording is what
the app compiled for the chip must repeat.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import cache
from typing import Final

from ground.core import MissionCmd, MissionState, lib
from ground.link.logblocks import log_blocks
from ground.link.wire import decode_message, encode_request
from ground.model import AppMessage, Beat, Event, Point
from ground.requests import AppRequest, Command, Heartbeat, HelloRequest, SnapshotRequest
from ground.sim.calls import RecordedFirmware, Recording
from ground.sim.crtp import Port, decode, encode
from ground.sim.firmware import Entry
from ground.sim.runtime import Options, Simulator
from ground.sim.world import load_world
from tests.firmware.flights import ALL, Flight

REFUSED_AT_S: Final = 2.0
TOO_HIGH: Final = struct.pack("<f", 9.0)
OUTSIDE: Final = (99.0, 0.0)
COMMAND_AT_S: Final = 3.0
SNAPSHOT_AT_S: Final = 8.0
BEAT_EVERY_STEPS: Final = 25
REST_S: Final = 4.0
MAP_PERIOD_MS: Final = 30
FEW: Final = (ALL[4],)
MANY: Final = (ALL[0], ALL[2], ALL[4], ALL[6], ALL[8], ALL[14], ALL[18], ALL[19])
"""Every room, exploring, the other planner, no SLAM."""

_CLIENT: Final = ("client", 1)
_TYPES: Final = ("", "uint8_t", "uint16_t", "uint32_t", "int8_t", "int16_t", "int32_t", "float",
                 "FP16")  # fmt: skip
_APP: Final = (Port.PLATFORM, 2)
_CREATE_BLOCK, _START_BLOCK = 6, 3
_LOG_CONTROL, _PARAM_WRITE = 1, 2


class _Client:
    """A ground station on simulated time."""

    def __init__(self, flight: Flight) -> None:
        self.firmware = RecordedFirmware()
        self.state = MissionState.IDLE
        self.states: set[int] = set()
        self.events: set[int] = set()
        self._simulator = Simulator(load_world(flight.world), Options(flight.seed), self.firmware)
        self._steps = 0
        self._sequence = 0
        self._simulator.warm_up()

    @property
    def time_s(self) -> float:
        return self._simulator.time_s

    def say(self, request: AppRequest) -> None:
        self._deliver(*_APP, encode_request(request))

    def command(self, cmd: MissionCmd, goal: tuple[float, float]) -> None:
        self._sequence += 1
        self.say(Command(self._sequence, cmd, Point(*goal)))
        self.state = MissionState.PLAN  # until it is heard again

    def ask_for_logs(self) -> None:
        """Request the log blocks that the ground station requests."""
        ids = _numbers(self.firmware.log_entries())
        for number, block in enumerate(log_blocks(MAP_PERIOD_MS)):
            pairs = [(_TYPES.index(kind), ids[name]) for name, kind in block.variables]
            asked = b"".join(struct.pack("<BH", *pair) for pair in pairs)
            self._deliver(Port.LOG, _LOG_CONTROL, bytes((_CREATE_BLOCK, number)) + asked)
            period = block.period_ms // 10
            self._deliver(Port.LOG, _LOG_CONTROL, bytes((_START_BLOCK, number, period)))

    def set_param(self, name: str, value: bytes) -> None:
        number = _numbers(self.firmware.param_entries())[name]
        self._deliver(Port.PARAM, _PARAM_WRITE, struct.pack("<H", number) + value)

    def step(self) -> None:
        """Advance the simulator by a step and receive what the drone sends."""
        self._simulator.step()
        for _, datagram in self._simulator.outgoing():
            packet = decode(datagram)
            if (packet.port, packet.channel) == _APP:
                self._hear(decode_message(packet.data))
        self._steps += 1
        if self._steps % BEAT_EVERY_STEPS == 0:
            self.say(Heartbeat(self._steps))

    def step_until(self, time_s: float) -> None:
        while self.time_s < time_s:
            self.step()

    def _hear(self, message: AppMessage | None) -> None:
        if isinstance(message, Beat):
            self.state = message.state
            self.states.add(message.state)
        elif isinstance(message, Event):
            self.events.add(message.code)

    def _deliver(self, port: int, channel: int, data: bytes) -> None:
        self._simulator.deliver(_CLIENT, encode(port, channel, data))


def _numbers(entries: list[Entry]) -> dict[str, int]:
    return {f"{entry.group}.{entry.name}": number for number, entry in enumerate(entries)}


def _choices(flight: Flight) -> dict[str, int]:
    """Parameters that differ from the app's defaults."""
    chosen = {"planner": flight.planner, "slam": flight.slam, "yawMode": flight.yaw_mode}
    usual = {"planner": lib.NAV_PLANNER_RRTSTAR, "slam": lib.NAV_SLAM_MAP, "yawMode": 0}
    return {f"way.{name}": value for name, value in chosen.items() if value != usual[name]}


@dataclass(frozen=True)
class Flown:
    """A flight, and what the drone has reported of it."""

    recording: Recording
    states: set[int]
    events: set[int]


@cache
def record(flight: Flight) -> Flown:
    """Fly until the drone rests on the floor again, or the time is over."""
    client = _Client(flight)
    goal = load_world(flight.world).spec.demo_goal_m or (2.0, 1.0)
    client.say(HelloRequest())
    client.ask_for_logs()
    for name, value in _choices(flight).items():
        client.set_param(name, bytes((value,)))
    client.set_param("way.height", TOO_HIGH)
    client.step_until(REFUSED_AT_S)
    client.command(MissionCmd.GOTO, OUTSIDE)
    client.step_until(COMMAND_AT_S)
    client.command(flight.task, goal)
    client.step_until(SNAPSHOT_AT_S)
    client.say(SnapshotRequest())
    busy_s, home_due = client.time_s, flight.home
    while client.time_s < min(flight.limit_s, busy_s + REST_S):
        client.step()
        if client.state.airborne:
            busy_s = client.time_s
        if client.state == MissionState.HOVER:
            client.command(MissionCmd.HOME if home_due else MissionCmd.LAND, goal)
            home_due = False
    return Flown(client.firmware.recording, client.states, client.events)
