# SPDX-License-Identifier: GPL-3.0-or-later
"""Measurements correct the simulated estimate as they correct the firmware's."""

import math
import struct

import numpy as np
import pytest
import typer

from ground.cli.sim import parse_shadow
from ground.sim.crtp import BadPacket
from ground.sim.estimator import PLACE_START_M2, Estimator
from ground.sim.localization import Localization
from ground.sim.model import Measured, PositionMeasured, Readings, YawMeasured
from ground.sim.positioning import POSITIONINGS, Positioning, Shadow
from ground.sim.profiles import PROFILES
from ground.sim.vehicle import Vehicle

QUALITY = 1.0


def estimator() -> tuple[Estimator, Vehicle]:
    rng = np.random.default_rng(1)
    return Estimator(PROFILES["perfect"], rng), Vehicle(0.0, 0.0, 0.0, rng)


def wait(estimate: Estimator, body: Vehicle, time_s: float) -> None:
    for _ in range(round(time_s * 100)):
        estimate.step(body, None, QUALITY)


def test_the_first_position_is_believed_as_it_is() -> None:
    """Flow gives no position: its variance stands at the firmware's limit."""
    estimate, body = estimator()
    wait(estimate, body, 10.0)
    assert estimate.place_m2 == PLACE_START_M2
    estimate.take(PositionMeasured(3.0, -2.0, 0.0, 0.05))
    assert (estimate.x_m, estimate.y_m) == pytest.approx((3.0, -2.0), abs=1e-3)
    assert estimate.place_m2 == pytest.approx(0.05**2, rel=0.01)


def test_gains_are_those_of_the_firmware() -> None:
    """kalman_core.c, Flow deck at 0.4 m, a position with 0.05 m each 1.2 s: a gain of 0.30."""
    estimate, body = estimator()
    gain = 0.0
    for _ in range(30):
        wait(estimate, body, 1.2)
        before = estimate.x_m
        estimate.take(PositionMeasured(before + 0.1, 0.0, 0.0, 0.05))
        gain = (estimate.x_m - before) / 0.1
    assert gain == pytest.approx(0.30, abs=0.02)


def test_a_heading_moves_the_yaw_and_nothing_else() -> None:
    estimate, body = estimator()
    estimate.take(YawMeasured(-0.1, 0.01))
    assert estimate.yaw_rad == pytest.approx(0.05)  # as sure of itself as it is of the heading
    assert (estimate.x_m, estimate.y_m) == (0.0, 0.0)
    wait(estimate, body, 60.0)
    assert estimate.yaw_rad < 0.05 * math.exp(-5.0)  # on the ground it creeps back


@pytest.mark.parametrize("kind", POSITIONINGS)
def test_a_shadow_ends_the_measuring(kind: str) -> None:
    estimate, body = estimator()
    body.x_m = 5.0
    positioning = Positioning(kind, (Shadow(1.0, 2.0),), np.random.default_rng(2))
    readings = Readings()
    status = []
    for _ in range(300):
        positioning.step(body, estimate, readings, lost=False)
        status.append(readings.lighthouse_status)
    measures = kind in ("lighthouse", "loco")
    assert estimate.x_m == pytest.approx(5.0 if measures else 0.0, abs=0.3)
    lit = 2 if kind == "lighthouse" else 0
    assert (status[90], status[150], status[290]) == (lit, 0, lit)


def test_an_unknown_system_is_refused() -> None:
    with pytest.raises(ValueError, match="gps"):
        Positioning("gps", (), np.random.default_rng(1))


class _Values:
    """Parameters that all have the same value."""

    def find(self, name: str) -> int:
        return 0

    def value(self, identity: int) -> float:
        return 0.01


def test_a_client_sends_positions_and_poses() -> None:
    told: list[Measured] = []
    readings = Readings(yaw_deg=10.0)
    service = Localization(_Values(), readings, lambda: 70_000, told.append)  # type: ignore[arg-type]
    service.position(struct.pack("<3f", 1.0, 2.0, 3.0))
    half_rad = math.radians(15.0)
    turned = (0.0, 0.0, math.sin(half_rad), math.cos(half_rad))
    service.pose(b"\x08" + struct.pack("<7f", 4.0, 5.0, 6.0, *turned))
    assert told[:2] == [
        PositionMeasured(1.0, 2.0, 3.0, 0.01),
        PositionMeasured(4.0, 5.0, 6.0, 0.01),
    ]
    assert isinstance(told[2], YawMeasured)
    assert told[2].error_rad == pytest.approx(math.radians(-20.0), abs=1e-6)
    assert readings.external_tick == 70_000 & 0xFFFF
    for broken in (b"", struct.pack("<2f", 1.0, 2.0), struct.pack("<3f", math.nan, 0.0, 0.0)):
        with pytest.raises(BadPacket):
            service.position(broken)
    service.pose(b"\x03")  # the emergency stop of older clients is no pose
    assert len(told) == 3


@pytest.mark.parametrize("text", ["", "5", "9-3", "-1-2", "a-b", "0-inf"])
def test_a_shadow_has_a_start_and_an_end(text: str) -> None:
    assert parse_shadow("30-60.5") == Shadow(30.0, 60.5)
    with pytest.raises(typer.BadParameter):
        parse_shadow(text)
