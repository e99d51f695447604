# SPDX-License-Identifier: GPL-3.0-or-later
"""The app's C code with a minimal body in a minimal room, enough to fly it.

The body does at once what the setpoint says; the room is an empty square. Physics, sensors that err
and the radio protocol are the simulator's.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from ground.core import MissionCmd, MissionReason, MissionState
from ground.link.wire import decode_message, encode_request
from ground.model import AppMessage
from ground.requests import AppRequest
from ground.sim.firmware import Entry, Firmware
from ground.sim.model import Readings, Setpoint

STEP_MS = 20
ROOM_HALF_M = 2.0
CAN_ARM, ARMED, CAN_FLY, FLYING, TUMBLED, LOCKED, CRASHED = (
    1 << bit for bit in (0, 1, 3, 4, 5, 6, 7)
)
READY = CAN_ARM | ARMED | CAN_FLY
UINT8, UINT16, UINT32, INT8, INT16, INT32, FLOAT, FP16 = range(1, 9)
_LOG_FORMATS = ("", "B", "H", "I", "b", "h", "i", "f", "e")
_PARAM_FORMATS = {0x0: "b", 0x1: "h", 0x2: "i", 0x6: "f", 0x8: "B", 0x9: "H", 0xA: "I"}
_BEARINGS = (0.0, math.pi, math.pi / 2, -math.pi / 2)


class Drone:
    """The app with names instead of numbers, and a body that follows its setpoints."""

    def __init__(self) -> None:
        self.firmware = Firmware()
        self.logs = {_name(e): i for i, e in enumerate(self.firmware.log_entries())}
        self.params = {_name(e): i for i, e in enumerate(self.firmware.param_entries())}
        self.readings = Readings(
            range_mm=(32767,) * 5,
            battery_v=4.1,
            supervisor_info=READY,
            var_velocity_m2ps2=(1e-3, 1e-3, 1e-3),
            motion_quality=80,
        )
        self.setpoints: list[Setpoint] = []
        self.firmware.set_connected(True)
        self._param_entries = self.firmware.param_entries()

    def boot(self, settle_s: float = 1.5) -> Drone:
        """Start the app and give the estimator time to settle."""
        self._measure()
        self.firmware.boot()
        self.run(settle_s)
        return self

    def run(self, seconds: float) -> None:
        """Advance time; the body follows the setpoint at once."""
        for _ in range(round(seconds * 1000 / STEP_MS)):
            self._move()
            if self.firmware.now_ms() % 100 < STEP_MS:
                self._measure()
            self.firmware.set_sensors(self.readings)
            self.firmware.run(STEP_MS)
            self.setpoints.append(self.firmware.get_setpoint())

    def hang(self, seconds: float, range_mm: tuple[int, int, int, int, int]) -> None:
        """Advance time without motion, with these ranges instead of the room's."""
        self.readings.range_mm = range_mm
        self.firmware.set_sensors(self.readings)
        self.firmware.run(round(seconds * 1000))

    def run_until(self, *states: MissionState, limit_s: float = 60.0) -> None:
        """Advance time until the mission is in one of these states."""
        end_ms = self.firmware.now_ms() + limit_s * 1000
        while self.state not in states:
            assert self.firmware.now_ms() < end_ms, f"still in {self.state.name}"
            self.run(STEP_MS / 1000)

    @property
    def state(self) -> MissionState:
        return MissionState(int(self.log("way.state")))

    @property
    def refused(self) -> MissionReason:
        return MissionReason(int(self.log("way.refused")))

    def log(self, name: str, kind: int = FLOAT) -> float:
        """Sample one variable now."""
        data = self.firmware.log_read(self.logs[name], kind, self.firmware.now_ms())
        return float(struct.unpack("<" + _LOG_FORMATS[kind], data)[0])

    def param(self, name: str) -> float:
        """The value of a parameter."""
        return self._unpack(name, self.firmware.param_read(self.params[name]))

    def default(self, name: str) -> float:
        """The default value that a client is told."""
        return self._unpack(name, self.firmware.param_default(self.params[name]))

    def write(self, name: str, value: float) -> int:
        """Write a parameter as a client does."""
        return self.firmware.param_write(self.params[name], self.pack(name, value))

    def force(self, name: str, value: float) -> None:
        """Set a parameter as the firmware itself does."""
        assert self.firmware.param_force(self.params[name], self.pack(name, value)) == 0

    def pack(self, name: str, value: float) -> bytes:
        """The bytes of a parameter's value."""
        kind = self._format(name)
        return struct.pack(kind, value if kind == "<f" else int(value))

    def updates(self) -> list[str]:
        """Names of the parameters that the app has changed."""
        names = list(self.params)
        return [names[i] for i in iter(self.firmware.take_param_update, -1)]

    def command(self, cmd: MissionCmd, goal: Sequence[float] = ()) -> MissionReason:
        """Give a command through the parameters; return the answer."""
        for name, value in zip(("way.goalX", "way.goalY"), goal, strict=False):
            self.write(name, value)
        self.write("way.cmd", cmd)
        self.run(2 * STEP_MS / 1000)
        return self.refused

    def send(self, request: AppRequest) -> None:
        """Send a packet to the app."""
        assert self.firmware.appchannel_push(encode_request(request))

    def packets(self) -> list[bytes]:
        """All packets that the app has sent since the last call."""
        return list(iter(self.firmware.appchannel_take, b""))

    def messages(self) -> list[AppMessage]:
        """The same packets as decoded messages; all of them must be valid."""
        messages = [decode_message(packet) for packet in self.packets()]
        assert None not in messages
        return [message for message in messages if message is not None]

    def console(self) -> str:
        """All console text since the last call."""
        return b"".join(iter(self.firmware.console_take, b"")).decode("ascii")

    def _move(self) -> None:
        setpoint, now, dt = self.firmware.get_setpoint(), self.readings, STEP_MS / 1000
        fly = setpoint.mode_z == 1
        target = setpoint.z_m if fly else 0.0
        now.z_m += max(-dt, min(dt, target - now.z_m))
        yaw = math.radians(now.yaw_deg)
        vx, vy = (setpoint.vx_mps, setpoint.vy_mps) if fly else (0.0, 0.0)
        now.vx_mps = vx * math.cos(yaw) - vy * math.sin(yaw)
        now.vy_mps = vx * math.sin(yaw) + vy * math.cos(yaw)
        now.x_m += dt * now.vx_mps
        now.y_m += dt * now.vy_mps
        turned = now.yaw_deg + (dt * setpoint.yaw_rate_dps if fly else 0.0)
        now.yaw_deg = (turned + 180.0) % 360.0 - 180.0
        in_air = FLYING if now.z_m > 0.02 else 0
        now.supervisor_info = now.supervisor_info & ~FLYING | in_air

    def _measure(self) -> None:
        """Distances to the walls; the last millimetre flickers, as with real sensors."""
        flicker_mm = self.firmware.now_ms() // 100 % 2
        yaw = math.radians(self.readings.yaw_deg)
        ranges = [_to_wall_mm(self.readings, yaw + b) + flicker_mm for b in _BEARINGS]
        self.readings.range_mm = (ranges[0], ranges[1], ranges[2], ranges[3], 2000)

    def _format(self, name: str) -> str:
        return "<" + _PARAM_FORMATS[self._param_entries[self.params[name]].type & 0x0F]

    def _unpack(self, name: str, data: bytes) -> float:
        return float(struct.unpack(self._format(name), data)[0])


def _to_wall_mm(at: Readings, bearing_rad: float) -> int:
    distances = []
    for position, slope in ((at.x_m, math.cos(bearing_rad)), (at.y_m, math.sin(bearing_rad))):
        if abs(slope) > 1e-9:
            distances.append((math.copysign(ROOM_HALF_M, slope) - position) / slope)
    return round(1000 * min(distances))


def _name(entry: Entry) -> str:
    return f"{entry.group}.{entry.name}"
