# SPDX-License-Identifier: GPL-3.0-or-later
"""A ground station without a clock of its own, in one process with the simulated Crazyflie.

It says and hears what a radio would carry, at simulated times: same seed, same flight.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

from ground.core import MissionCmd, MissionReason
from ground.errors import NoAnswer
from ground.flight import Outcome, Watch
from ground.logblocks import LogBlock, log_blocks
from ground.missing import History
from ground.model import (
    Ack,
    AppRequest,
    Command,
    Heartbeat,
    HelloRequest,
    Incoming,
    Point,
    Telemetry,
)
from ground.picture import Picture
from ground.recovery import Recovery
from ground.sim.crtp import APP, Port, decode, encode
from ground.sim.faults import Faults
from ground.sim.firmware import Entry, Firmware
from ground.sim.plant import PLANT_STEP_S
from ground.sim.runtime import Options, Simulator
from ground.sim.world import World
from ground.wire import SEQUENCES, decode_message, encode_request
from ground.words import REASON_WORDS

TIME_IS_UP: Final = "the time was up"
_CLIENT: Final = ("client", 1)
_FLOAT: Final = 7
_LOG_CONTROL, _LOG_DATA, _PARAM_READ, _PARAM_WRITE = 1, 2, 1, 2
_CREATE_BLOCK, _START_BLOCK = 6, 3
_LOG_TYPES: Final = {"uint8_t": (1, "B"), "uint16_t": (2, "H"), "uint32_t": (3, "I"),
                     "float": (7, "f"), "FP16": (8, "e")}  # fmt: skip
_PARAM_LAYOUTS: Final = {0x6: "<f", 0x8: "<B", 0x9: "<H", 0xA: "<I"}
_TYPE_MASK: Final = 0x0F
_MAP_PERIOD_MS: Final = 30
_BEAT_EVERY_STEPS: Final = 25
_SECOND_STEPS: Final = round(1.0 / PLANT_STEP_S)
_REPEAT_S: Final = 0.2
_REPEATS: Final = 10
_LIMIT_S: Final = 120.0


class _Stream:
    """One log block: asked for, and read."""

    def __init__(self, block: LogBlock, numbers: dict[str, int]) -> None:
        self._block = block
        layout = "".join(_LOG_TYPES[kind][1] for _, kind in block.variables)
        self._values = struct.Struct("<" + layout)
        self.request = b"".join(
            struct.pack("<BH", _LOG_TYPES[kind][0], numbers[name]) for name, kind in block.variables
        )
        self.period = block.period_ms // 10

    def message(self, data: bytes) -> Incoming | None:
        """What one packet says."""
        names = (name for name, _ in self._block.variables)
        values = dict(zip(names, self._values.unpack(data[4:]), strict=True))
        return self._block.decode(int.from_bytes(data[1:4], "little"), values)


class Pilot:
    """Commands one drone; every call lets simulated time pass until it is done."""

    def __init__(self, world: World, options: Options) -> None:
        self.picture = Picture()
        self.recovery = Recovery()
        self.believed: list[tuple[float, float, float]] = []
        """Poses (s, x, y) in the air, as the drone tells them at that moment."""
        self.every_second: Callable[[], None] = lambda: None
        """Called when a whole second of simulated time has passed."""
        self._firmware = Firmware()
        self._simulator = Simulator(world, options, self._firmware)
        if unknown := self._simulator.unknown_eeprom_names:
            raise ValueError("no persistent parameter " + ", ".join(unknown))
        self._log_numbers = _numbers(self._firmware.log_entries())
        self._streams: list[_Stream] = []
        self._ack: Ack | None = None
        self._watch: Watch | None = None
        self._outcome: Outcome | None = None
        self._steps = self._sequence = 0
        self._simulator.warm_up()
        self._ask_for_logs()
        self._say(HelloRequest())
        self._read_parameters()

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self._simulator.time_s

    def set_parameter(self, name: str, value: float) -> None:
        """Write a parameter, until it has come through."""
        entries = self._firmware.param_entries()
        number = _numbers(entries)[name]
        layout = _PARAM_LAYOUTS[entries[number].type & _TYPE_MASK]
        data = struct.pack(layout, value if layout == "<f" else int(value))
        for _ in range(_REPEATS):
            self._deliver(Port.PARAM, _PARAM_WRITE, struct.pack("<H", number) + data)
            self._step()
            if self._firmware.param_read(number) == data:
                return
        raise NoAnswer(f"parameter {name} was not taken")

    @property
    def faults(self) -> Faults:
        """To let something go wrong."""
        return self._simulator.faults

    def onboard(self, name: str) -> float:
        """What a log variable says on board, whatever comes through."""
        number = self._log_numbers[name]
        data = self._firmware.log_read(number, _FLOAT, self._firmware.now_ms())
        return float(struct.unpack("<f", data)[0])

    def truth(self) -> dict[str, Any]:
        """The simulator's figures of the flight."""
        return self._simulator.status()

    def take_off(self) -> MissionReason:
        """As soon as the position estimate has settled; until it hovers."""
        return self.fly(MissionCmd.TAKE_OFF).reason

    def go_to(self, goal: Point) -> tuple[bool, MissionReason, str]:
        """Arrived by its own account? why not? in words"""
        outcome = self.fly(MissionCmd.GOTO, goal)
        return outcome.reached, outcome.reason, outcome.sentence

    def fly(
        self,
        cmd: MissionCmd,
        goal: Point | None = None,
        limit_s: float = _LIMIT_S,
        enough: Callable[[], bool] = lambda: False,
    ) -> Outcome:
        """Command, as soon as the position estimate has settled, and see it through, or until
        one has seen enough."""
        end_s = self.time_s + limit_s
        while True:
            watch = self._watch = Watch(cmd, goal, self.picture.drone_ms)
            self._outcome = None
            reason = self.command(cmd, goal)
            settled = self.picture.state.airborne or reason is not MissionReason.ESTIMATOR
            if settled or self.time_s >= end_s:
                break
            self._step()
        watch.acknowledged_ms = self.picture.drone_ms
        if reason is MissionReason.OK:
            self._step_until(lambda: self._outcome is not None or enough(), end_s - self.time_s)
        else:
            self._outcome = Outcome(False, REASON_WORDS[reason], reason)
        self._watch = None
        return self._outcome or Outcome(False, TIME_IS_UP)

    def land(self) -> None:
        """If it flies."""
        if self.command(MissionCmd.LAND) is MissionReason.OK:
            self._step_until(lambda: not self.picture.state.airborne)

    def fetch_map(self) -> None:
        """Wait until the whole map has come down."""
        self._step_until(lambda: self.picture.map.completeness == 1)

    def rest(self, seconds: float) -> None:
        """Let time pass."""
        self._step_until(lambda: False, seconds)

    def command(self, cmd: MissionCmd, goal: Point | None = None) -> MissionReason:
        """Say it until it is acknowledged."""
        self._sequence = (self._sequence + 1) % SEQUENCES
        self._ack = None
        for _ in range(_REPEATS):
            self._say(Command(self._sequence, cmd, goal or Point(0.0, 0.0)))
            self._step_until(lambda: self._ack is not None, _REPEAT_S)
            if self._ack is not None:
                return self._ack.reason
        raise NoAnswer("the drone does not answer: has its app stopped?")

    def _step_until(self, done: Callable[[], bool], limit_s: float = _LIMIT_S) -> None:
        end_s = self.time_s + limit_s
        while not done() and self.time_s < end_s:
            self._step()

    def _step(self) -> None:
        self._simulator.step()
        for _, datagram in self._simulator.outgoing():
            packet = decode(datagram)
            message: Incoming | None = None
            if (packet.port, packet.channel) == APP:
                message = decode_message(packet.data)
            elif (packet.port, packet.channel) == (Port.LOG, _LOG_DATA):
                message = self._streams[packet.data[0]].message(packet.data)
            if message is not None:
                self._hear(message)
        picture = self.picture
        for request in self.recovery.requests(picture.map, picture.route_known, picture.drone_ms):
            self._say(request)
        self._steps += 1
        if self._steps % _BEAT_EVERY_STEPS == 0:
            self._beat()
        if self._steps % _SECOND_STEPS == 0:
            self.every_second()

    def _hear(self, message: Incoming) -> None:
        if not self.recovery.take(message):
            return
        self.picture.take(message, self.time_s)
        if isinstance(message, History):
            self.picture.take_history(message, self.recovery.records.first_missing or 0)
        if self._watch is not None and self._outcome is None:
            self._outcome = self._watch.judge(message)
        match message:
            case Ack() if message.sequence == self._sequence:
                self._ack = message
            case Telemetry(drone_ms, pose, _, state) if state.airborne:
                self.believed.append((drone_ms / 1000, pose.x_m, pose.y_m))

    def _beat(self) -> None:
        self._say(Heartbeat(self._steps % SEQUENCES))
        hello = self.picture.hello
        if hello is None or hello.epoch != self.picture.map.epoch:
            self._say(HelloRequest())

    def _ask_for_logs(self) -> None:
        """The first two blocks of a ground station: its state and the map."""
        numbers = self._log_numbers
        for number, block in enumerate(log_blocks(_MAP_PERIOD_MS)[:2]):
            stream = _Stream(block, numbers)
            self._streams.append(stream)
            asked = bytes((_CREATE_BLOCK, number)) + stream.request
            self._deliver(Port.LOG, _LOG_CONTROL, asked)
            started = bytes((_START_BLOCK, number, stream.period))
            self._deliver(Port.LOG, _LOG_CONTROL, started)

    def _read_parameters(self) -> None:
        """As clients do when they connect; only from then on packets get lost."""
        for number in range(len(self._firmware.param_entries())):
            self._deliver(Port.PARAM, _PARAM_READ, struct.pack("<H", number))

    def _say(self, request: AppRequest) -> None:
        self._deliver(*APP, encode_request(request))

    def _deliver(self, port: int, channel: int, data: bytes) -> None:
        self._simulator.deliver(_CLIENT, encode(port, channel, data))


def _numbers(entries: list[Entry]) -> dict[str, int]:
    return {f"{entry.group}.{entry.name}": number for number, entry in enumerate(entries)}
