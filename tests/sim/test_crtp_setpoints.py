# SPDX-License-Identifier: GPL-3.0-or-later
"""Setpoints as the real cflib packs them arrive as they were meant."""

import struct
from math import cos, radians, sin

import pytest
from cflib.crazyflie.commander import Commander
from hypothesis import given
from hypothesis import strategies as st

from ground.sim.crtp import BadPacket
from ground.sim.model import Mode, Setpoint
from ground.sim.setpoints import ThrustLock, decode_generic

numbers = st.floats(-10, 10, width=32)
OLD_PROTOCOL, NEW_PROTOCOL = 8, 12


class Recorder:
    """Stands in for cflib's Crazyflie; keeps the last packet."""

    def __init__(self, protocol: int = NEW_PROTOCOL) -> None:
        self.platform = self
        self.data = b""
        self.protocol = protocol

    def get_protocol_version(self) -> int:
        return self.protocol

    def send_packet(self, packet: object) -> None:
        self.data = bytes(packet.data)  # type: ignore[attr-defined]


@pytest.mark.filterwarnings("ignore:Using legacy:DeprecationWarning")
@pytest.mark.parametrize("protocol", [OLD_PROTOCOL, NEW_PROTOCOL])
@given(a=numbers, b=numbers, c=numbers, d=numbers)
def test_velocity_height_and_hover(protocol: int, a: float, b: float, c: float, d: float) -> None:
    recorder = Recorder(protocol)
    commander = Commander(recorder)
    commander.send_velocity_world_setpoint(a, b, c, d)
    velocity = decode_generic(recorder.data)
    assert (velocity.vx_mps, velocity.vy_mps, velocity.vz_mps, velocity.yaw_rate_dps) == (
        a,
        b,
        c,
        d,
    )
    assert (velocity.mode_x, velocity.mode_z, velocity.velocity_body) == (Mode.VELOCITY,) * 2 + (
        False,
    )
    commander.send_hover_setpoint(a, b, c, d)
    hover = decode_generic(recorder.data)
    assert (hover.vx_mps, hover.vy_mps, hover.yaw_rate_dps, hover.z_m) == (a, b, c, d)
    assert hover.velocity_body and (hover.mode_x, hover.mode_z) == (Mode.VELOCITY, Mode.ABSOLUTE)
    commander.send_zdistance_setpoint(a, b, c, d)
    height = decode_generic(recorder.data)
    assert (height.roll_deg, height.pitch_deg, height.yaw_rate_dps, height.z_m) == (a, b, c, d)
    assert (height.mode_roll, height.mode_x) == (Mode.ABSOLUTE, Mode.OFF)


@given(x=numbers, y=numbers, z=numbers, yaw_deg=st.floats(-179, 179))
def test_position_and_full_state_agree(x: float, y: float, z: float, yaw_deg: float) -> None:
    recorder = Recorder()
    commander = Commander(recorder)
    commander.send_position_setpoint(x, y, z, yaw_deg)
    position = decode_generic(recorder.data)
    half_rad = radians(yaw_deg) / 2
    quaternion = (0.0, 0.0, sin(half_rad), cos(half_rad))
    commander.send_full_state_setpoint((x, y, z), (1, 2, 3), (0, 0, 0), quaternion, 0, 0, 1)
    full = decode_generic(recorder.data)
    assert (full.x_m, full.y_m, full.z_m) == pytest.approx(
        (position.x_m, position.y_m, position.z_m), abs=1e-3
    )
    assert full.yaw_deg == pytest.approx(position.yaw_deg, abs=0.3)
    assert (full.vx_mps, full.vy_mps, full.vz_mps) == pytest.approx((1, 2, 3))
    assert position.mode_x == position.mode_yaw == full.mode_yaw == Mode.ABSOLUTE


def test_thrust_is_locked_until_a_zero_and_limited() -> None:
    recorder = Recorder()
    commander, lock = Commander(recorder), ThrustLock()

    def thrust_of(thrust: int) -> float:
        commander.send_setpoint(1.0, 2.0, 3.0, thrust)
        setpoint = lock.decode(recorder.data)
        assert (setpoint.roll_deg, setpoint.pitch_deg) == (1.0, -2.0)
        assert setpoint.yaw_rate_dps == -3.0
        return setpoint.thrust

    assert thrust_of(40000) == 0
    assert thrust_of(0) == 0
    assert [thrust_of(t) for t in (999, 1000, 40000, 65535)] == [0, 1000, 40000, 60000]


def test_stop_means_motors_off() -> None:
    recorder = Recorder()
    Commander(recorder).send_stop_setpoint()
    assert decode_generic(recorder.data) == Setpoint()


@given(kind=st.integers(0, 255), body=st.binary(max_size=29))
def test_other_lengths_types_and_numbers_are_refused(kind: int, body: bytes) -> None:
    try:
        setpoint = decode_generic(bytes((kind,)) + body)
    except BadPacket:
        return
    assert kind == 0 or len(body) in (15, 16, 28)
    assert abs(setpoint.vx_mps) < float("inf") and setpoint.z_m == setpoint.z_m


def test_not_a_number_is_refused() -> None:
    with pytest.raises(BadPacket):
        decode_generic(struct.pack("<B4f", 10, float("nan"), 0, 0, 0.5))
    with pytest.raises(BadPacket):
        decode_generic(b"")
