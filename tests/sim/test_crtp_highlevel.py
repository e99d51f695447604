# SPDX-License-Identifier: GPL-3.0-or-later
"""High-level commands: smooth paths that end where and when they should."""

import struct
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.sim.crtp import BadPacket, Errno
from ground.sim.highlevel import HighLevel
from ground.sim.model import Mode, Readings, Setpoint
from ground.sim.supervisor import Info
from ground.sim.trajectory import Motion, Trajectory

HERE = Readings(x_m=1.0, y_m=2.0, z_m=0.0, yaw_deg=90.0)
places = st.tuples(*[st.floats(-3, 3)] * 4)
STEP_S = 1e-4


def ready(readings: Readings = HERE) -> HighLevel:
    commander = HighLevel()
    commander.block(False)
    commander.setpoint(0, readings)
    return commander


def take_off(commander: HighLevel, now_ms: int = 0, mask: int = 0) -> int:
    packet = struct.pack("<BBff?f", 7, mask, 0.5, 0.0, True, 2.0)
    return commander.command(packet, now_ms)


@given(begin=places, velocity=places, acceleration=places, goal=places, seconds=st.floats(0.5, 9))
def test_trajectory_joins_both_ends(
    begin: tuple[float, ...],
    velocity: tuple[float, ...],
    acceleration: tuple[float, ...],
    goal: tuple[float, ...],
    seconds: float,
) -> None:
    start = Motion(begin, velocity, acceleration)  # type: ignore[arg-type]
    way = Trajectory(start, goal, 5.0, seconds)  # type: ignore[arg-type]
    first, last = way.at(5.0), way.at(5.0 + seconds)
    assert first.position == pytest.approx(begin)
    assert first.velocity == pytest.approx(velocity, abs=1e-6)
    assert first.acceleration == pytest.approx(acceleration, abs=1e-6)
    assert last.position == pytest.approx(goal, abs=1e-6)
    assert last.velocity + last.acceleration == pytest.approx([0] * 8, abs=1e-4)
    # The velocity is the derivative of the position all along.
    for part in (0.25, 0.5, 0.75):
        time_s = 5.0 + part * seconds
        before, after = way.at(time_s - STEP_S).position, way.at(time_s + STEP_S).position
        slope = [(b - a) / (2 * STEP_S) for a, b in zip(before, after, strict=True)]
        assert way.at(time_s).velocity == pytest.approx(slope, abs=1e-2)


def test_takes_off_holds_and_lands() -> None:
    commander = ready()
    assert commander.setpoint(0, HERE) == Setpoint()
    assert take_off(commander) == Errno.OK
    half = commander.setpoint(1000, HERE)
    assert half.z_m == pytest.approx(0.25) and half.mode_z == Mode.ABSOLUTE
    up = commander.setpoint(5000, HERE)
    assert (up.x_m, up.y_m, up.z_m, up.yaw_deg) == pytest.approx((1.0, 2.0, 0.5, 90.0))
    assert commander.info(5000) == Info.HIGH_LEVEL_FLYING | Info.HIGH_LEVEL_FINISHED
    assert take_off(commander, 5000) == 1, "already up"
    land = struct.pack("<BBff?f", 8, 0, 0.0, 0.0, True, 1.0)
    assert commander.command(land, 5000) == Errno.OK
    assert commander.setpoint(5500, HERE).z_m == pytest.approx(0.25)
    assert commander.setpoint(6000, HERE) == Setpoint(), "motors off after landing"


@pytest.mark.parametrize("linear", [0, 1])
def test_goes_relative_and_turns_the_short_way(linear: int) -> None:
    commander = ready()
    take_off(commander)
    commander.setpoint(2000, HERE)
    go = struct.pack("<BBBB5f", 12, 0, 1, linear, 1.0, -1.0, 0.5, 1.5 * pi, 2.0)
    assert commander.command(go, 2000) == Errno.OK
    half, there = commander.setpoint(3000, HERE), commander.setpoint(4000, HERE)
    assert (half.x_m, half.y_m, half.z_m) == pytest.approx((1.5, 1.5, 0.75))
    assert (there.x_m, there.y_m, there.z_m) == pytest.approx((2.0, 1.0, 1.0))
    assert half.yaw_deg == pytest.approx(45.0) and there.yaw_deg == pytest.approx(0.0, abs=1e-4)


def test_groups_blocking_stop_and_the_unknown() -> None:
    commander = ready()
    assert take_off(commander, mask=2) == Errno.OK
    assert commander.setpoint(500, HERE) == Setpoint(), "another group was meant"
    commander.command(b"\0\2", 500)
    assert take_off(commander, 500, mask=2) == Errno.OK
    assert commander.setpoint(1500, HERE) != Setpoint()
    assert commander.command(b"\3\0", 1500) == Errno.OK
    assert commander.setpoint(1600, HERE) == Setpoint()
    assert commander.command(b"\x0b" + bytes(23), 1600) == Errno.ENOEXEC
    commander.block(True)
    assert take_off(commander, 1700) == Errno.EBUSY
    for broken in (b"", b"\7", b"\7" + bytes(30), struct.pack("<BB5f", 12, 0, *[float("nan")] * 5)):
        with pytest.raises(BadPacket):
            commander.command(broken, 1800)
