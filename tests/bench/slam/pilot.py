# SPDX-License-Identifier: GPL-3.0-or-later
"""A ground station without a clock of its own, in one process with the simulated Crazyflie.

It says and hears what a radio would carry, at simulated times: same seed, same flight.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

from ground.core import EventCode, MissionCmd, MissionReason, MissionState
from ground.errors import NoAnswer
from ground.logblocks import LogBlock, log_blocks
from ground.model import (
    Ack,
    AppRequest,
    Command,
    Event,
    Heartbeat,
    HelloRequest,
    Incoming,
    Point,
    Telemetry,
)
from ground.picture import Picture
from ground.sim.crtp import Port, decode, encode
from ground.sim.firmware import Entry, Firmware
from ground.sim.runtime import Options, Simulator
from ground.sim.world import World
from ground.wire import SEQUENCES, decode_message, encode_request
from ground.words import REASON_WORDS

_CLIENT: Final = ("client", 1)
_APP: Final = (Port.PLATFORM, 2)
_LOG_CONTROL, _LOG_DATA, _PARAM_WRITE = 1, 2, 2
_CREATE_BLOCK, _START_BLOCK = 6, 3
_TYPES: Final = {"uint8_t": (1, "B"), "uint16_t": (2, "H"), "uint32_t": (3, "I"),
                 "float": (7, "f"), "FP16": (8, "e")}  # fmt: skip
_MAP_PERIOD_MS: Final = 30
_BEAT_EVERY_STEPS: Final = 25
_ANSWER_S: Final = 2.0
_LIMIT_S: Final = 120.0
_RESTING_S: Final = 5.0
_RESTING: Final = (MissionState.IDLE, MissionState.HOVER, MissionState.FAULT)


class _Stream:
    """One log block: asked for, and read."""

    def __init__(self, block: LogBlock, numbers: dict[str, int]) -> None:
        self._block = block
        self._values = struct.Struct("<" + "".join(_TYPES[kind][1] for _, kind in block.variables))
        self.request = b"".join(
            struct.pack("<BH", _TYPES[kind][0], numbers[name]) for name, kind in block.variables
        )
        self.period = block.period_ms // 10

    def message(self, data: bytes) -> Incoming | None:
        names = (name for name, _ in self._block.variables)
        values = dict(zip(names, self._values.unpack(data[4:]), strict=True))
        return self._block.decode(int.from_bytes(data[1:4], "little"), values)


class Pilot:
    """Commands one drone; every call lets simulated time pass until it is done."""

    def __init__(self, world: World, options: Options) -> None:
        self.picture = Picture()
        self.believed: list[tuple[float, float, float]] = []
        """Poses (s, x, y) in the air, as the drone tells them at that moment."""
        self._firmware = Firmware()
        self._simulator = Simulator(world, options, self._firmware)
        self._streams: list[_Stream] = []
        self._ack: Ack | None = None
        self._end: Event | None = None
        self._moving_s = 0.0
        self._steps = self._sequence = 0
        self._simulator.warm_up()
        self._say(HelloRequest())
        self._ask_for_logs()

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self._simulator.time_s

    def set_byte(self, name: str, value: int) -> None:
        """Write a parameter of one byte."""
        number = _numbers(self._firmware.param_entries())[name]
        self._deliver(Port.PARAM, _PARAM_WRITE, struct.pack("<HB", number, value))

    def truth(self) -> dict[str, Any]:
        """The simulator's figures of the flight."""
        return self._simulator.status()

    def take_off(self) -> MissionReason:
        """As soon as the position estimate has settled; until it hovers."""
        while (reason := self._command(MissionCmd.TAKE_OFF)) is MissionReason.ESTIMATOR:
            self._step()
        if reason is MissionReason.OK:
            self._step_until(lambda: self.picture.state is MissionState.HOVER)
        return reason

    def go_to(self, goal: Point) -> tuple[bool, MissionReason, str]:
        """Arrived by its own account? why not? in words"""
        self._end, self._moving_s = None, self.time_s
        reason = self._command(MissionCmd.GOTO, goal)
        if reason is not MissionReason.OK:
            return False, reason, REASON_WORDS[reason]
        self._step_until(self._ended)
        if self._end is None:
            return False, MissionReason.STUCK, "it did not arrive, and did not say why"
        if self._end.code is EventCode.ARRIVED:
            return True, MissionReason.OK, "arrived"
        return False, self._end.reason, REASON_WORDS[self._end.reason]

    def land(self) -> None:
        """And stay there until the map has come down."""
        if self._command(MissionCmd.LAND) is MissionReason.OK:
            self._step_until(lambda: not self.picture.state.airborne)
        self._step_until(lambda: self.picture.map.completeness == 1)

    def rest(self, seconds: float) -> None:
        """Let time pass."""
        self._step_until(lambda: False, seconds)

    def _command(self, cmd: MissionCmd, goal: Point | None = None) -> MissionReason:
        self._sequence = (self._sequence + 1) % SEQUENCES
        self._say(Command(self._sequence, cmd, goal or Point(0.0, 0.0)))
        self._ack = None
        self._step_until(lambda: self._ack is not None, _ANSWER_S)
        if self._ack is None:
            raise NoAnswer("the drone does not answer: has its app stopped?")
        return self._ack.reason

    def _ended(self) -> bool:
        """It has said so, or it rests without a word."""
        return self._end is not None or self.time_s - self._moving_s > _RESTING_S

    def _step_until(self, done: Callable[[], bool], limit_s: float = _LIMIT_S) -> None:
        end_s = self.time_s + limit_s
        while not done() and self.time_s < end_s:
            self._step()

    def _step(self) -> None:
        self._simulator.step()
        for _, datagram in self._simulator.outgoing():
            packet = decode(datagram)
            message: Incoming | None = None
            if (packet.port, packet.channel) == _APP:
                message = decode_message(packet.data)
            elif (packet.port, packet.channel) == (Port.LOG, _LOG_DATA):
                message = self._streams[packet.data[0]].message(packet.data)
            if message is not None:
                self._hear(message)
        self._steps += 1
        if self._steps % _BEAT_EVERY_STEPS == 0:
            self._say(Heartbeat(self._steps % SEQUENCES))

    def _hear(self, message: Incoming) -> None:
        self.picture.take(message, self.time_s)
        match message:
            case Ack() if message.sequence == self._sequence:
                self._ack = message
            case Event(code=EventCode.ARRIVED | EventCode.REFUSED | EventCode.FAULT):
                self._end = message
            case Telemetry(drone_ms, pose, _, state):
                if state not in _RESTING:
                    self._moving_s = self.time_s
                if state.airborne:
                    self.believed.append((drone_ms / 1000, pose.x_m, pose.y_m))

    def _ask_for_logs(self) -> None:
        """The first two blocks of a ground station: its state and the map."""
        numbers = _numbers(self._firmware.log_entries())
        for number, block in enumerate(log_blocks(_MAP_PERIOD_MS)[:2]):
            stream = _Stream(block, numbers)
            self._streams.append(stream)
            asked = bytes((_CREATE_BLOCK, number)) + stream.request
            self._deliver(Port.LOG, _LOG_CONTROL, asked)
            started = bytes((_START_BLOCK, number, stream.period))
            self._deliver(Port.LOG, _LOG_CONTROL, started)

    def _say(self, request: AppRequest) -> None:
        self._deliver(*_APP, encode_request(request))

    def _deliver(self, port: int, channel: int, data: bytes) -> None:
        self._simulator.deliver(_CLIENT, encode(port, channel, data))


def _numbers(entries: list[Entry]) -> dict[str, int]:
    return {f"{entry.group}.{entry.name}": number for number, entry in enumerate(entries)}
