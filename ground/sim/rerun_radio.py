# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the C code again on what came over a radio: close to the flight, but not bit for bit.

Log blocks sample the firmware's variables at their own times, packets are lost, and some inputs
(variances, flow quality) are not sent at all and assumed to be good. Missing values are held. A
command that was refused is not given again: what it was refused for may not be in the recording.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from typing import Any, Final, TypeVar

import numpy as np

from ground.checks import Check
from ground.core import MissionState
from ground.errors import GroundError
from ground.link.wire import decode_message, encode_request
from ground.map.groundmap import GroundMap
from ground.model import (
    Ack,
    Health,
    Hello,
    Incoming,
    MapPacket,
    Odometry,
    ParameterValue,
    Ranges,
    Telemetry,
)
from ground.record.reader import Spoken
from ground.requests import AppRequest, Command, EmergencyStop, HelloRequest, Outgoing, SetParameter
from ground.sim.firmware import Firmware
from ground.sim.hearing import Keeper, blocks_of, numbers_of
from ground.sim.model import RANGE_NONE_MM, Readings
from ground.sim.params import pack_value

M = TypeVar("M", Telemetry, Odometry, Ranges, Health)

TICK_MS: Final = 20
ON_GROUND_M: Final = 0.2
WARM_UP_MS: Final = 2000
RANGES_MS: Final = 100
TX_PACKETS: Final = 100
_NOISE_MM: Final = (0, 3, -5, 6, -2, 4, -7, 2, -4)
_GOOD_QUALITY: Final = 100
_GOOD_VARIANCE: Final = 1e-3
_ACTING: Final = ("way.cmd", "way.goalX", "way.goalY", "way.selftest")


class RadioRerun:
    """One session; report() computes it again."""

    def __init__(self, session: list[Spoken], tell: Keeper) -> None:
        self._session = session
        self._tell = tell
        self._refused = {
            (word.message.sequence, word.message.cmd)
            for word in session
            if isinstance(word.message, Ack) and word.message.reason
        }
        self._drone = _Drone(_first_of_each(session))
        self._maps = GroundMap(), GroundMap()  # the drone's, and the one computed here
        self._said: Telemetry | None = None
        self._apart: list[tuple[float, float, bool]] = []  # distance [m], turn [rad], same state
        self._ticks = self._whole = 0

    def report(self) -> tuple[dict[str, Any], list[Check]]:
        """Figures without checks, since equality cannot be expected."""
        self._refuse()
        times_s = [word.time_s for word in self._session if isinstance(word.message, Odometry)]
        words = iter(self._session)
        waiting = next(words, None)
        for tick in range(round(1000 * (times_s[-1] - times_s[0])) // TICK_MS):
            until_s = times_s[0] + tick * TICK_MS / 1000
            fresh = False
            while waiting is not None and waiting.time_s <= until_s:
                fresh = fresh or isinstance(waiting.message, Odometry)
                self._take(waiting)
                waiting = next(words, None)
            self._ticks += 1
            self._whole += fresh
            for message in self._drone.tick():
                self._hear(message)
        return self._figures(), []

    def _refuse(self) -> None:
        telemetry = _first_of(self._session, Telemetry)
        odometry = _first_of(self._session, Odometry)
        if telemetry is None or odometry is None:
            raise GroundError("this recording has no odometry: it cannot be computed again")
        starts = telemetry.state in (MissionState.IDLE, MissionState.TAKEOFF)
        if not starts or max(telemetry.pose.z_m, odometry.pose.z_m) > ON_GROUND_M:
            raise GroundError("this recording begins in flight: its beginning is missing")

    def _take(self, word: Spoken) -> None:
        """Feed inputs to the app; keep what the drone said, for comparison."""
        match word.message:
            case Telemetry():
                self._said = word.message
            case Hello():
                self._maps[0].take_hello(word.message)
            case MapPacket():
                self._maps[0].take_packet(word.message, word.time_s)
            case Command(sequence, cmd) if (sequence, cmd) in self._refused:
                pass
            case _:
                self._drone.take(word.message)

    def _hear(self, message: Incoming) -> None:
        self._tell(message, self._drone.now_ms)
        match message:
            case Telemetry() if self._said:
                here, there = message.pose, self._said.pose
                turn_rad = math.remainder(here.yaw_rad - there.yaw_rad, math.tau)
                distance_m = math.hypot(here.x_m - there.x_m, here.y_m - there.y_m)
                self._apart.append((distance_m, abs(turn_rad), message.state is self._said.state))
            case Hello():
                self._maps[1].take_hello(message)
            case MapPacket():
                self._maps[1].take_packet(message, self._drone.now_ms / 1000)

    def _figures(self) -> dict[str, Any]:
        distances_m, turns_rad, same = zip(*self._apart, strict=True)
        half = (len(distances_m) + 1) // 2  # after a different decision the two drift apart
        theirs, ours = (grid.states for grid in self._maps)
        known = (theirs != 0) & (ours != 0)
        same_cells = float((theirs == ours)[known].mean()) if known.any() else 0.0
        return {
            "ticks": self._ticks,
            "ticks_with_odometry": self._whole,
            "ticks_without": self._ticks - self._whole,
            "range_sets": self._drone.range_sets,
            "commands_sent": self._drone.commands,
            "pose_apart_m_median": round(float(np.median(distances_m)), 4),
            "pose_apart_m_median_first_half": round(float(np.median(distances_m[:half])), 4),
            "pose_apart_m_worst": round(max(distances_m), 4),
            "yaw_apart_rad_median": round(float(np.median(turns_rad)), 4),
            "same_state": round(float(np.mean(same)), 3),
            "cells_known_to_both": int(known.sum()),
            "of_those_the_same": round(same_cells, 3),
        }


class _Drone:
    """The app, with the latest readings of its sensors."""

    def __init__(self, before: list[Incoming]) -> None:
        """`before` holds the sensors' readings while the app starts."""
        self.commands = self.range_sets = 0
        self._firmware = Firmware()
        self._params = numbers_of(self._firmware.param_entries())
        self._types = [entry.type for entry in self._firmware.param_entries()]
        self._blocks = [(b, b.reader(self._firmware)) for b in blocks_of(self._firmware)]
        self._unsent: deque[bytes] = deque()  # the app takes so many packets a tick, and no more
        self._readings = Readings(motion_quality=_GOOD_QUALITY)
        self._readings.var_velocity_m2ps2 = (_GOOD_VARIANCE,) * 3
        for message in before:
            self.take(message)
        self.range_sets = 0
        self._firmware.set_connected(True)
        self._firmware.boot()
        self._stand_still()
        self.take(HelloRequest())

    @property
    def now_ms(self) -> int:
        return self._firmware.now_ms()

    def take(self, message: Incoming | Outgoing) -> None:
        """Take a measurement, or a message to the drone."""
        seen = self._readings
        match message:
            case Odometry(_, pose, roll_rad, pitch_rad, vx_mps, vy_mps, yaw_rate_rps):
                seen.x_m, seen.y_m, seen.z_m = pose.x_m, pose.y_m, pose.z_m
                seen.yaw_deg, seen.roll_deg = math.degrees(pose.yaw_rad), math.degrees(roll_rad)
                seen.pitch_deg = math.degrees(pitch_rad)
                seen.vx_mps, seen.vy_mps = vx_mps, vy_mps
                seen.gyro_dps = (0.0, 0.0, math.degrees(yaw_rate_rps))
            case Ranges(_, front_m, back_m, left_m, right_m, up_m):
                front, back, left, right, up = map(_mm, (front_m, back_m, left_m, right_m, up_m))
                seen.range_mm = (front, back, left, right, up)
                self.range_sets += 1
            case Health():
                seen.battery_v, seen.supervisor_info = message.battery_v, message.supervisor
            case ParameterValue(name, value) | SetParameter(name, value):
                self._set(name, value, isinstance(message, SetParameter))
            case EmergencyStop():
                pass  # the bits of supervisor.info show it
            case _:
                self._push(message)

    def tick(self) -> Iterator[Incoming]:
        """Run one period of the app, and yield what it says."""
        self._firmware.set_sensors(self._readings)
        self._firmware.set_tx_free(TX_PACKETS)
        while self._unsent and self._firmware.appchannel_push(self._unsent[0]):
            self._unsent.popleft()
        self._firmware.run(TICK_MS)
        list(self._firmware.take_measurements())
        while packet := self._firmware.appchannel_take():
            if (message := decode_message(packet)) is not None:
                yield message
        for block, reader in self._blocks:
            if self.now_ms % block.period_ms < TICK_MS:
                said = block.message(self.now_ms, reader.read(self.now_ms))
                if said is not None:
                    yield said

    def _stand_still(self) -> None:
        """Wait until the estimate counts as settled; vary the ranges, or they count as frozen."""
        seen = self._readings.range_mm
        for number in range(WARM_UP_MS // RANGES_MS):
            front, back, left, right, up = (mm + _NOISE_MM[number % len(_NOISE_MM)] for mm in seen)
            self._readings.range_mm = (front, back, left, right, up)
            self._firmware.set_sensors(self._readings)
            self._firmware.run(RANGES_MS)
        self._readings.range_mm = seen

    def _push(self, message: Incoming | Outgoing) -> None:
        if isinstance(message, AppRequest):
            self.commands += isinstance(message, Command)
            self._unsent.append(encode_request(message))

    def _set(self, name: str, value: float, asked: bool) -> None:
        """Set a parameter; one reported by the drone is skipped if setting it would act."""
        number = self._params.get(name)
        if number is None or (name in _ACTING and not asked):
            return
        self._firmware.param_write(number, pack_value(self._types[number], value))


def _first_of(session: list[Spoken], kind: type[M]) -> M | None:
    return next((word.message for word in session if isinstance(word.message, kind)), None)


def _first_of_each(session: list[Spoken]) -> list[Incoming]:
    """The first message of each sensor."""
    found = _first_of(session, Odometry), _first_of(session, Ranges), _first_of(session, Health)
    return [message for message in found if message is not None]


def _mm(range_m: float | None) -> int:
    return RANGE_NONE_MM if range_m is None else round(1000 * range_m)
