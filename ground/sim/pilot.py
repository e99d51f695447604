# SPDX-License-Identifier: GPL-3.0-or-later
"""A ground station in one process with the simulated Crazyflie, on simulated time alone.

It sends and receives what a radio would carry, so the same seed gives the same flight.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

from ground.core import MissionCmd, MissionReason
from ground.errors import NoAnswer
from ground.link.wire import SEQUENCES, decode_message, encode_request
from ground.model import Ack, History, Incoming, Point, Telemetry
from ground.requests import AppRequest, Command, Heartbeat, HelloRequest
from ground.sim.crtp import APP, Port, decode, encode
from ground.sim.faults import Faults
from ground.sim.firmware import Firmware
from ground.sim.hearing import blocks_of, numbers_of
from ground.sim.params import pack_value
from ground.sim.plant import PLANT_STEP_S
from ground.sim.runtime import Options, Simulator
from ground.sim.world import World
from ground.station.flight import Outcome, Watch
from ground.station.picture import Picture
from ground.station.recovery import Recovery
from ground.words import REASON_WORDS

TIME_IS_UP: Final = "the time was up"
_CLIENT: Final = ("client", 1)
_FLOAT: Final = 7
_LOG_CONTROL, _LOG_DATA, _PARAM_READ, _PARAM_WRITE = 1, 2, 1, 2
_CREATE_BLOCK, _START_BLOCK = 6, 3
_MAP_PERIOD_MS: Final = 30
_BEAT_EVERY_STEPS: Final = 25
_SECOND_STEPS: Final = round(1.0 / PLANT_STEP_S)
_REPEAT_S: Final = 0.2
_REPEATS: Final = 10
_LIMIT_S: Final = 120.0


class Pilot:
    """Commands one drone; every call advances simulated time until it is done."""

    def __init__(self, world: World, options: Options) -> None:
        self.picture = Picture()
        self.recovery = Recovery()
        self.believed: list[tuple[float, float, float]] = []
        """Poses (time [s], x, y [m]) in the air, as the drone reported them."""
        self.every_second: Callable[[], None] = lambda: None
        """Called after each second of simulated time."""
        self._firmware = Firmware()
        self._simulator = Simulator(world, options, self._firmware)
        if unknown := self._simulator.unknown_eeprom_names:
            raise ValueError("no persistent parameter " + ", ".join(unknown))
        self._log_numbers = numbers_of(self._firmware.log_entries())
        self._blocks = blocks_of(self._firmware, _MAP_PERIOD_MS)[:2]  # the state and the map
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
        """Write a parameter, repeatedly until it has arrived."""
        entries = self._firmware.param_entries()
        number = numbers_of(entries)[name]
        data = pack_value(entries[number].type, value)
        for _ in range(_REPEATS):
            self._deliver(Port.PARAM, _PARAM_WRITE, struct.pack("<H", number) + data)
            self._step()
            if self._firmware.param_read(number) == data:
                return
        raise NoAnswer(f"parameter {name} was not taken")

    @property
    def faults(self) -> Faults:
        """The simulator's faults, to begin or end one."""
        return self._simulator.faults

    def onboard(self, name: str) -> float:
        """A log variable's value on board, independent of the radio."""
        number = self._log_numbers[name]
        data = self._firmware.log_read(number, _FLOAT, self._firmware.now_ms())
        return float(struct.unpack("<f", data)[0])

    def truth(self) -> dict[str, Any]:
        """The simulator's figures of the flight."""
        return self._simulator.status()

    def fly(
        self,
        cmd: MissionCmd,
        goal: Point | None = None,
        limit_s: float = _LIMIT_S,
        enough: Callable[[], bool] = lambda: False,
    ) -> Outcome:
        """Give a command once the position estimate has settled, and wait for its outcome, or until
        enough() is true."""
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
        """Land if the drone flies."""
        if self.command(MissionCmd.LAND) is MissionReason.OK:
            self._step_until(lambda: not self.picture.state.airborne)

    def fetch_map(self) -> None:
        """Wait until the whole map has come down."""
        self._step_until(lambda: self.picture.map.completeness == 1)

    def rest(self, seconds: float) -> None:
        """Let simulated time pass."""
        self._step_until(lambda: False, seconds)

    def command(self, cmd: MissionCmd, goal: Point | None = None) -> MissionReason:
        """Send a command until it is acknowledged. Raises NoAnswer."""
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
                time_ms = int.from_bytes(packet.data[1:4], "little")
                message = self._blocks[packet.data[0]].message(time_ms, packet.data[4:])
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
        for number, block in enumerate(self._blocks):
            pairs = zip(block.types, block.ids, strict=True)
            variables = b"".join(struct.pack("<BH", *pair) for pair in pairs)
            self._deliver(Port.LOG, _LOG_CONTROL, bytes((_CREATE_BLOCK, number)) + variables)
            started = bytes((_START_BLOCK, number, block.period_ms // 10))
            self._deliver(Port.LOG, _LOG_CONTROL, started)

    def _read_parameters(self) -> None:
        """Read all parameters, as a connecting client does; packet loss begins only afterwards."""
        for number in range(len(self._firmware.param_entries())):
            self._deliver(Port.PARAM, _PARAM_READ, struct.pack("<H", number))

    def _say(self, request: AppRequest) -> None:
        self._deliver(*APP, encode_request(request))

    def _deliver(self, port: int, channel: int, data: bytes) -> None:
        self._simulator.deliver(_CLIENT, encode(port, channel, data))
