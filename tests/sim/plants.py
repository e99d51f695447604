# SPDX-License-Identifier: GPL-3.0-or-later
"""Common parts of tests of the simulated body: setpoints, flights, small worlds, bodies."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from ground.sim.model import Mode, Setpoint
from ground.sim.plant import PLANT_STEP_S, Plant
from ground.sim.vehicle import Vehicle
from ground.sim.world import World, load_world

OFF = Setpoint()

OPEN_FLOOR = """
[start]
x_m = 0.0
y_m = 0.0
"""


def world_from(folder: Path, text: str) -> World:
    """A world from TOML text."""
    path = folder / "small.toml"
    path.write_text(text, encoding="utf-8")
    return load_world(path)


def hover(
    vx_mps: float = 0.0, vy_mps: float = 0.0, z_m: float = 0.5, yaw_rate_dps: float = 0.0
) -> Setpoint:
    return Setpoint(
        mode_x=Mode.VELOCITY,
        mode_y=Mode.VELOCITY,
        mode_z=Mode.ABSOLUTE,
        mode_yaw=Mode.VELOCITY,
        velocity_body=True,
        vx_mps=vx_mps,
        vy_mps=vy_mps,
        z_m=z_m,
        yaw_rate_dps=yaw_rate_dps,
    )


def steps(plant: Plant, setpoint: Setpoint, seconds: float, armed: bool = True) -> Iterator[Plant]:
    """Step by step, for tests that look at every step."""
    for _ in range(round(seconds / PLANT_STEP_S)):
        plant.step(setpoint, armed)
        yield plant


def fly(plant: Plant, setpoint: Setpoint, seconds: float, armed: bool = True) -> Plant:
    for _ in steps(plant, setpoint, seconds, armed):
        pass
    return plant


def fly_until(
    plant: Plant, setpoint: Setpoint, done: Callable[[Plant], bool], limit_s: float
) -> Plant:
    """Fly until a condition holds for the plant; fail if it never does."""
    for now in steps(plant, setpoint, limit_s):
        if done(now):
            return plant
    raise AssertionError(f"not so within {limit_s} s: {plant.truth}")


def hovering(world: World, seed: int = 1, profile: str = "perfect", z_m: float = 0.5) -> Plant:
    """A plant that has taken off and settled."""
    return fly(Plant(world, seed, profile), hover(z_m=z_m), 6.0)


def in_the_air(x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0) -> Vehicle:
    """A body at rest at flight height."""
    body = Vehicle(x_m, y_m, yaw_rad, np.random.default_rng(0))
    body.z_m, body.on_floor = 0.5, False
    return body


def wall_at(folder: Path, distance_m: float, extra: str = "") -> World:
    """A wide, high wall ahead whose near face is this far from the origin."""
    x = distance_m + 0.05
    wall = f"[[wall]]\nfrom = [{x}, -20]\nto = [{x}, 20]\nheight_m = 9\n{extra}\n"
    return world_from(folder, OPEN_FLOOR + wall)
