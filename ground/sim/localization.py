# SPDX-License-Identifier: GPL-3.0-or-later
"""The localization service (port 6): positions sent by a client, as from motion capture.

Units, standard deviations and log variables are those of crtp_localization_service.c. Packed
packets, which address several drones, are ignored.
"""

import math
import struct
from collections.abc import Callable

from ground.sim.crtp import unpack
from ground.sim.model import Measured, PositionMeasured, Readings, YawMeasured
from ground.sim.params import Params

_EXT_POSE = 8
_POSITION = struct.Struct("<3f")
_POSE = struct.Struct("<7f")


class Localization:
    """Turns packets into measurements for the estimator."""

    def __init__(
        self,
        params: Params,
        readings: Readings,
        now_ms: Callable[[], int],
        tell: Callable[[Measured], None],
    ) -> None:
        self._params = params
        self._readings = readings
        self._now_ms = now_ms
        self._tell = tell

    def position(self, data: bytes) -> None:
        """Take a position (channel 0)."""
        self._take(*unpack(_POSITION, data))

    def pose(self, data: bytes) -> None:
        """Take a position and heading (channel 1); packets of other types are ignored."""
        if data[:1] != bytes((_EXT_POSE,)):
            return
        x_m, y_m, z_m, qx, qy, qz, qw = unpack(_POSE, data[1:])
        self._take(x_m, y_m, z_m)
        self._readings.external_q = (qx, qy, qz, qw)
        yaw_rad = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
        estimated_rad = math.radians(self._readings.yaw_deg)
        error_rad = math.remainder(estimated_rad - yaw_rad, math.tau)
        self._tell(YawMeasured(error_rad, self._value("locSrv.extQuatStdDev")))

    def _take(self, x_m: float, y_m: float, z_m: float) -> None:
        self._readings.external_m = (x_m, y_m, z_m)
        self._readings.external_tick = self._now_ms() & 0xFFFF
        self._tell(PositionMeasured(x_m, y_m, z_m, self._value("locSrv.extPosStdDev")))

    def _value(self, name: str) -> float:
        identity = self._params.find(name)
        assert identity is not None
        return self._params.value(identity)
