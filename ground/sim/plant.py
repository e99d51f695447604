# SPDX-License-Identifier: GPL-3.0-or-later
"""One simulated Crazyflie in one world: setpoints in, sensor readings and truth out."""

import math
from typing import Final

import numpy as np

from ground.sim.battery import HOVER_ENDURANCE_S, Battery
from ground.sim.broken import Broken
from ground.sim.contacts import Collision, Contacts
from ground.sim.controller import CONTROL_STEP_S, Controller
from ground.sim.model import Measured, Readings, Setpoint, Truth
from ground.sim.positioning import Positioning, Shadow
from ground.sim.profiles import PROFILES
from ground.sim.ranger import FALSE_SHORT
from ground.sim.sensors import Sensors
from ground.sim.vehicle import HOVER_THRUST, Vehicle
from ground.sim.world import World

PLANT_STEP_S: Final = CONTROL_STEP_S


class Plant:
    """Body and sensors of one Crazyflie, stepped by PLANT_STEP_S; the same seed, the same flight.

    readings.supervisor_info is written by the simulated supervisor. The world's clock is the
    plant's; a world serves one plant.
    """

    def __init__(
        self,
        world: World,
        seed: int,
        profile: str = "real",
        endurance_s: float = HOVER_ENDURANCE_S,
        false_short: float = FALSE_SHORT,
        positioning: str = "flow",
        shadows: tuple[Shadow, ...] = (),
    ) -> None:
        if profile not in PROFILES:
            raise ValueError(f"profile {profile!r} is none of {', '.join(PROFILES)}")
        body_rng, sensor_rng, place_rng = np.random.default_rng(seed).spawn(3)
        (x_m, y_m), yaw_rad = world.spec.start_m, world.spec.start_yaw_rad
        self.truth = Truth()
        self._world = world
        self._steps = 0
        self._vehicle = Vehicle(x_m, y_m, yaw_rad, body_rng)
        self._controller = Controller()
        self._contacts = Contacts(world, self._vehicle)
        self._battery = Battery(endurance_s=endurance_s)
        system = Positioning(positioning, shadows, place_rng)
        self._sensors = Sensors(world, profile, system, sensor_rng, false_short)
        world.set_time(0.0)
        self._write_truth()

    @property
    def time_s(self) -> float:
        return self._steps * PLANT_STEP_S

    @property
    def readings(self) -> Readings:
        """The readings; always the same object, updated in place by step()."""
        return self._sensors.readings

    @property
    def broken(self) -> Broken:
        """Which sensors are broken; may be changed at any time."""
        return self._sensors.broken

    @property
    def battery(self) -> Battery:
        return self._battery

    @property
    def collisions(self) -> int:
        return len(self._contacts.collisions)

    @property
    def collision_log(self) -> tuple[Collision, ...]:
        return tuple(self._contacts.collisions)

    @property
    def tumbled(self) -> bool:
        return self._vehicle.tumbled

    @property
    def on_floor(self) -> bool:
        return self._vehicle.on_floor

    def step(self, setpoint: Setpoint, armed: bool) -> None:
        """Advance by PLANT_STEP_S under this setpoint."""
        vehicle, estimate = self._vehicle, self._sensors.estimator
        command = self._controller.update(setpoint, self.readings, armed)
        command.roll_rad -= estimate.roll_error_rad
        command.pitch_rad -= estimate.pitch_error_rad
        yaw_error_rad = math.remainder(command.yaw_rad - estimate.yaw_rad, math.tau)
        vehicle.step(command, yaw_error_rad, self._battery.voltage_v)
        self._steps += 1
        self._world.set_time(self.time_s, (vehicle.x_m, vehicle.y_m))
        self._contacts.step(self.time_s, PLANT_STEP_S)
        self._battery.step(command.thrust / HOVER_THRUST, PLANT_STEP_S)
        self._sensors.step(vehicle, command, self._battery)
        self._write_truth()

    def reset_estimator(self, x_m: float, y_m: float, z_m: float, yaw_rad: float) -> None:
        """Restart the estimate at this pose, as kalman.resetEstimation does."""
        self._sensors.estimator.reset(x_m, y_m, z_m, yaw_rad)

    def tell_estimator(self, measured: Measured) -> None:
        """Pass on a measurement from outside the plant: from the app, or from a client."""
        self._sensors.estimator.take(measured)

    def jump_estimate(self, x_m: float, y_m: float) -> None:
        """Shift the estimated position."""
        self._sensors.estimator.jump(x_m, y_m)

    def tumble(self) -> None:
        """Turn the body over, as if something had hit it."""
        self._vehicle.tumble()

    def carry(self, x_m: float, y_m: float, z_m: float) -> None:
        """Move the body elsewhere, faster than its sensors can notice, and hold it there."""
        self._vehicle.hold(x_m, y_m, z_m)
        self._sensors.estimator.carried()
        self._contacts.look()

    def let_go(self, z_m: float) -> None:
        """Let go of the held body at this height."""
        self._vehicle.let_go(z_m)

    def _write_truth(self) -> None:
        truth, body = self.truth, self._vehicle
        truth.time_s = self.time_s
        truth.position_m = (body.x_m, body.y_m, body.z_m)
        truth.velocity_mps = (body.vx_mps, body.vy_mps, body.vz_mps)
        truth.roll_rad, truth.pitch_rad = body.roll_rad, body.pitch_rad
        truth.yaw_rad = body.yaw_rad
