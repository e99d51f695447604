# SPDX-License-Identifier: GPL-3.0-or-later
"""The stock firmware between setpoints and stabilizer: commander, high level, supervisor."""

import struct
from math import cos, radians

from ground.sim.crtp import BadPacket, Port, encode, unpack
from ground.sim.firmware import Firmware
from ground.sim.highlevel import HighLevel
from ground.sim.model import Readings, Setpoint
from ground.sim.setpoints import ThrustLock, decode_generic
from ground.sim.supervisor import PERIOD_MS, Inputs, Supervisor

_PRIORITY_HIGH_LEVEL, _PRIORITY_CRTP = 1, 2
_NOTIFY_STOP = struct.Struct("<BI")
_ANSWER = 0x80
_HIGH_LEVEL_ANSWER_BYTES = 4
_INFO_BITFIELD = 0x0C
_ARM, _RECOVER, _EMERGENCY_STOP, _WATCHDOG = 1, 2, 3, 4
_LEGACY_EMERGENCY_STOP, _LEGACY_WATCHDOG = 3, 4
_DISARM_REQUEST, _ARM_REQUEST = 1, 2


class FlightStack:
    """Commands of clients and the app in, the setpoint that the body shall follow out."""

    def __init__(self, firmware: Firmware, auto_arm: bool) -> None:
        self.console: list[str] = []
        self._firmware = firmware
        self._supervisor = Supervisor(auto_arm, self.console.append)
        self._high_level = HighLevel()
        self._thrust_lock = ThrustLock()
        self._supervisor_due_ms = 0

    @property
    def info(self) -> int:
        """The bits of supervisor.info."""
        return int(self._supervisor.info)

    def step(self, readings: Readings, stop_parameter: bool) -> tuple[Setpoint, bool]:
        """Return the setpoint for the stabilizer and whether the motors may run."""
        now_ms = self._firmware.now_ms()
        wanted = self._high_level.setpoint(now_ms, readings)
        if self._firmware.active_priority() <= _PRIORITY_HIGH_LEVEL:
            self._firmware.put_setpoint(wanted, _PRIORITY_HIGH_LEVEL)
        else:
            self._high_level.stop()
        setpoint = self._firmware.get_setpoint()
        self._take_arming_request()
        if not self._firmware.alive():
            self._supervisor.emergency_stop()
        if now_ms >= self._supervisor_due_ms:
            self._supervisor_due_ms = now_ms + PERIOD_MS
            self._supervise(now_ms, readings, setpoint, stop_parameter)
        return self._supervisor.override(setpoint), self._supervisor.can_fly

    def emergency_stop(self) -> None:
        """Cut the motors, as an emergency stop command does."""
        self._supervisor.emergency_stop()

    def roll_pitch_yaw_thrust(self, data: bytes) -> None:
        """Take a setpoint of port 3."""
        self._firmware.put_setpoint(self._thrust_lock.decode(data), _PRIORITY_CRTP)

    def generic(self, data: bytes) -> None:
        """Take a setpoint of port 7, channel 0."""
        self._firmware.put_setpoint(decode_generic(data), _PRIORITY_CRTP)

    def notify_stop(self, readings: Readings, data: bytes) -> None:
        """Port 7, channel 1: setpoints will stop; the high-level commander goes on from here."""
        command, _remaining_ms = unpack(_NOTIFY_STOP, data)
        if command != 0:
            raise BadPacket("meta command")
        self._high_level.tell_state(readings)
        self._firmware.relax_priority()

    def high_level(self, data: bytes) -> bytes:
        """Port 8: the answer repeats three bytes and appends an error number."""
        error = self._high_level.command(data, self._firmware.now_ms())
        head = data[: _HIGH_LEVEL_ANSWER_BYTES - 1].ljust(_HIGH_LEVEL_ANSWER_BYTES - 1, b"\0")
        return encode(Port.SETPOINT_HIGH_LEVEL, 0, head + bytes((error,)))

    def supervisor_info(self, data: bytes) -> bytes:
        """Port 9, channel 0: answer with one bit of supervisor.info, or with all of them."""
        if len(data) != 1 or not 1 <= data[0] <= _INFO_BITFIELD:
            raise BadPacket("supervisor request")
        command = data[0]
        if command == _INFO_BITFIELD:
            value = self.info.to_bytes(2, "little")
        else:
            value = bytes((self.info >> (command - 1) & 1,))
        return encode(Port.SUPERVISOR, 0, bytes((command | _ANSWER,)) + value)

    def supervisor_command(self, data: bytes) -> bytes | None:
        """Port 9, channel 1: arming, recovery, emergency stop and its watchdog."""
        if data[:1] == bytes((_EMERGENCY_STOP,)):
            self._supervisor.emergency_stop()
            return None
        if data[:1] == bytes((_WATCHDOG,)):
            self._supervisor.feed_watchdog(self._firmware.now_ms())
            return None
        result = self._arm_or_recover(data)
        return encode(Port.SUPERVISOR, 1, bytes((data[0] | _ANSWER,)) + result)

    def legacy_command(self, data: bytes) -> bytes:
        """Port 13, channel 0: arming and recovery as older clients request them."""
        return encode(Port.PLATFORM, 0, data[:1] + self._arm_or_recover(data))

    def legacy_emergency(self, data: bytes) -> None:
        """Port 6, channel 1: the emergency stop of older clients."""
        if data[:1] == bytes((_LEGACY_EMERGENCY_STOP,)):
            self._supervisor.emergency_stop()
        elif data[:1] == bytes((_LEGACY_WATCHDOG,)):
            self._supervisor.feed_watchdog(self._firmware.now_ms())

    def _arm_or_recover(self, data: bytes) -> bytes:
        if len(data) == 2 and data[0] == _ARM:
            success = self._supervisor.request_arming(data[1] != 0)
            return bytes((success, self._supervisor.armed))
        if len(data) == 1 and data[0] == _RECOVER:
            success = self._supervisor.request_recovery()
            return bytes((success, not self._supervisor.crashed))
        raise BadPacket("supervisor command")

    def _take_arming_request(self) -> None:
        request = self._firmware.take_arming_request()
        if request in (_DISARM_REQUEST, _ARM_REQUEST):
            self._supervisor.request_arming(request == _ARM_REQUEST)

    def _supervise(
        self, now_ms: int, readings: Readings, setpoint: Setpoint, stop_parameter: bool
    ) -> None:
        upright = cos(radians(readings.roll_deg)) * cos(radians(readings.pitch_deg))
        inputs = Inputs(
            now_ms=now_ms,
            motors_run=any(readings.motor_pwm),
            acc_z_g=(1.0 + readings.az_g) * upright,
            setpoint_age_ms=setpoint.age_ms,
            stop_parameter=stop_parameter,
            high_level=self._high_level.info(now_ms),
        )
        self._supervisor.update(inputs)
        self._high_level.block(not self._supervisor.can_fly)
