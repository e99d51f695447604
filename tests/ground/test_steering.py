# SPDX-License-Identifier: GPL-3.0-or-later
"""Station.steer() on a simulated drone: it goes as far as commanded, stops, and refuses."""

import asyncio
import math

import pytest

from ground import Station
from ground.errors import CommandRefused
from ground.sim.process import SimulatorProcess


def test_it_flies_by_hand_for_a_time_and_stands() -> None:
    async def run(uri: str) -> None:
        async with Station.connect(uri) as drone:
            with pytest.raises(CommandRefused, match="not flying"):
                await drone.steer(ahead_mps=0.3)
            await drone.take_off()
            await drone.steer(seconds=1.0)
            before, begin_ms = drone.pose, drone.picture.drone_ms
            await drone.steer(ahead_mps=0.4, seconds=1.5)
            held_s = (drone.picture.drone_ms - begin_ms) / 1000  # with the rest at the end
            after, odometry = drone.pose, drone.picture.odometry
            assert before and after and odometry
            went = complex(after.x_m - before.x_m, after.y_m - before.y_m)
            ahead = complex(math.cos(before.yaw_rad), math.sin(before.yaw_rad))
            ahead_m, aside_m = (went / ahead).real, (went / ahead).imag
            assert 0.45 < ahead_m < 0.4 * held_s
            assert abs(aside_m) < 0.15
            assert math.hypot(odometry.vx_mps, odometry.vy_mps) < 0.12
            await drone.steer(climb_mps=0.3, seconds=1.5)
            assert drone.pose and drone.pose.z_m > after.z_m + 0.15

    with SimulatorProcess("--world", "empty", "--speed", "2") as simulator:
        asyncio.run(run(simulator.uri))
