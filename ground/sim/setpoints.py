# SPDX-License-Identifier: GPL-3.0-or-later
"""Setpoints as clients send them, decoded as crtp_commander_rpyt.c and _generic.c do.

Roll and pitch rates are not simulated: the drone flies level where they are commanded.
"""

import struct
from collections.abc import Callable
from math import atan2, degrees, sqrt

from ground.sim.crtp import BadPacket, unpack
from ground.sim.model import Mode, Setpoint

_RPYT = struct.Struct("<fffH")
_FOUR = struct.Struct("<4f")
_MANUAL = struct.Struct("<fffHB")
_FULL_STATE = struct.Struct("<9hI3h")
_MIN_THRUST, _MAX_THRUST = 1000, 60000
_QUATERNION_MASK = (1 << 9) - 1


class ThrustLock:
    """After a start, thrust of port 3 stays zero until a setpoint with zero thrust was seen."""

    def __init__(self) -> None:
        self._locked = True

    def decode(self, data: bytes) -> Setpoint:
        """Decode a packet of port 3, whose yaw rate is positive clockwise."""
        roll_deg, pitch_deg, clockwise_dps, thrust = unpack(_RPYT, data)
        if thrust == 0:
            self._locked = False
        if self._locked or thrust < _MIN_THRUST:
            thrust = 0
        setpoint = _attitude(roll_deg, pitch_deg, -clockwise_dps)
        setpoint.thrust = float(min(thrust, _MAX_THRUST))
        return setpoint


def decode_generic(data: bytes) -> Setpoint:
    """Decode a packet of port 7, channel 0."""
    if not data or data[0] not in _DECODERS:
        raise BadPacket("generic setpoint type")
    return _DECODERS[data[0]](data[1:])


def _attitude(roll_deg: float, pitch_deg: float, yaw_rate_dps: float) -> Setpoint:
    return Setpoint(
        mode_roll=Mode.ABSOLUTE,
        mode_pitch=Mode.ABSOLUTE,
        mode_yaw=Mode.VELOCITY,
        roll_deg=roll_deg,
        pitch_deg=pitch_deg,
        yaw_rate_dps=yaw_rate_dps,
    )


def _stop(data: bytes) -> Setpoint:
    return Setpoint()


def _velocity(vx_mps: float, vy_mps: float, yaw_rate_dps: float) -> Setpoint:
    return Setpoint(
        mode_x=Mode.VELOCITY,
        mode_y=Mode.VELOCITY,
        mode_yaw=Mode.VELOCITY,
        vx_mps=vx_mps,
        vy_mps=vy_mps,
        yaw_rate_dps=yaw_rate_dps,
    )


def _velocity_world(data: bytes) -> Setpoint:
    vx_mps, vy_mps, vz_mps, yaw_rate_dps = unpack(_FOUR, data)
    setpoint = _velocity(vx_mps, vy_mps, yaw_rate_dps)
    setpoint.mode_z, setpoint.vz_mps = Mode.VELOCITY, vz_mps
    return setpoint


def _z_distance(data: bytes) -> Setpoint:
    roll_deg, pitch_deg, yaw_rate_dps, z_m = unpack(_FOUR, data)
    setpoint = _attitude(roll_deg, pitch_deg, yaw_rate_dps)
    setpoint.mode_z, setpoint.z_m = Mode.ABSOLUTE, z_m
    return setpoint


def _altitude_hold(data: bytes) -> Setpoint:
    roll_deg, pitch_deg, yaw_rate_dps, vz_mps = unpack(_FOUR, data)
    setpoint = _attitude(roll_deg, pitch_deg, yaw_rate_dps)
    setpoint.mode_z, setpoint.vz_mps = Mode.VELOCITY, vz_mps
    return setpoint


def _hover(data: bytes) -> Setpoint:
    vx_mps, vy_mps, yaw_rate_dps, z_m = unpack(_FOUR, data)
    setpoint = _velocity(vx_mps, vy_mps, yaw_rate_dps)
    setpoint.velocity_body = True
    setpoint.mode_z, setpoint.z_m = Mode.ABSOLUTE, z_m
    return setpoint


def _position(data: bytes) -> Setpoint:
    return Setpoint.at(*unpack(_FOUR, data))


def _full_state(data: bytes) -> Setpoint:
    values = unpack(_FULL_STATE, data)
    x_m, y_m, z_m, vx_mps, vy_mps, vz_mps = (value / 1000 for value in values[:6])
    setpoint = Setpoint.at(x_m, y_m, z_m, _yaw_of_compressed_deg(values[9]))
    setpoint.vx_mps, setpoint.vy_mps, setpoint.vz_mps = vx_mps, vy_mps, vz_mps
    setpoint.yaw_rate_dps = degrees(values[12] / 1000)
    return setpoint


def _manual(data: bytes) -> Setpoint:
    roll, pitch, yaw_rate_dps, thrust, rates = unpack(_MANUAL, data)
    setpoint = _attitude(0.0 if rates else roll, 0.0 if rates else pitch, yaw_rate_dps)
    setpoint.thrust = float(thrust)
    return setpoint


def _clockwise(decoder: Callable[[bytes], Setpoint]) -> Callable[[bytes], Setpoint]:
    """Decoder of a legacy type, which differs only in the sign of the yaw rate."""

    def decode(data: bytes) -> Setpoint:
        setpoint = decoder(data)
        setpoint.yaw_rate_dps = -setpoint.yaw_rate_dps
        return setpoint

    return decode


def _yaw_of_compressed_deg(word: int) -> float:
    """Yaw of a quaternion packed as in quatcompress.h, which omits the largest component."""
    largest = word >> 30
    quaternion = [0.0] * 4
    rest = 1.0
    for index in (3, 2, 1, 0):
        if index != largest:
            magnitude = (word & _QUATERNION_MASK) / _QUATERNION_MASK * sqrt(0.5)
            quaternion[index] = -magnitude if word >> 9 & 1 else magnitude
            rest -= magnitude * magnitude
            word >>= 10
    quaternion[largest] = sqrt(max(rest, 0.0))
    x, y, z, w = quaternion
    return degrees(atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


_DECODERS: dict[int, Callable[[bytes], Setpoint]] = {
    0: _stop,
    1: _clockwise(_velocity_world),
    2: _clockwise(_z_distance),
    4: _altitude_hold,
    5: _clockwise(_hover),
    6: _full_state,
    7: _position,
    8: _velocity_world,
    9: _z_distance,
    10: _hover,
    11: _manual,
}
