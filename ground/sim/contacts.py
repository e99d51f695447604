# SPDX-License-Identifier: GPL-3.0-or-later
"""Collisions of the body with the world: push it out, count them, and tell who hit whom."""

from dataclasses import dataclass
from typing import Final

from ground.sim.vehicle import Vehicle
from ground.sim.world import Touch, World

BODY_RADIUS_M: Final = 0.07
BODY_HEIGHT_M: Final = 0.03
TUMBLE_MPS: Final = 0.8
RESTITUTION: Final = 0.3
SCRAPE: Final = 0.95
APART_M: Final = 0.05


@dataclass(frozen=True, slots=True)
class Collision:
    """One contact, from touch to separation; the speeds are towards the other body."""

    time_s: float
    obstacle: str
    drone_mps: float
    obstacle_mps: float

    @property
    def by_drone(self) -> bool:
        """Whether the drone moved into the obstacle, rather than the obstacle into it."""
        return bool(self.drone_mps >= self.obstacle_mps)


class Contacts:
    """Watches one body; looks closely only when something can have come near it."""

    def __init__(self, world: World, vehicle: Vehicle) -> None:
        self._world, self._vehicle = world, vehicle
        self._slack_m = 0.0
        self._changes = -1
        self._touching: dict[int, str] = {}
        self.collisions: list[Collision] = []

    def look(self) -> None:
        """Look closely at the next step, since the body was moved by force."""
        self._slack_m = 0.0

    def step(self, time_s: float, elapsed_s: float) -> None:
        """Handle contacts; call after world and body have moved."""
        body, places = self._vehicle, self._world.footprints
        speed = abs(body.vx_mps) + abs(body.vy_mps) + abs(body.vz_mps) + places.fastest_mps
        self._slack_m -= speed * elapsed_s
        if self._slack_m > 0.0 and self._changes == places.changes:
            return
        self._changes = places.changes
        around = self._world.surroundings(
            body.x_m, body.y_m, body.z_m, BODY_RADIUS_M, BODY_HEIGHT_M
        )
        self._slack_m = around.slack_m
        body.floor_m = around.floor_m
        for touch in around.touches:
            self._collide(touch, time_s)
        self._forget_those_apart()

    def _collide(self, touch: Touch, time_s: float) -> None:
        body = self._vehicle
        nx, ny, nz = touch.normal
        drone_mps = -(body.vx_mps * nx + body.vy_mps * ny + body.vz_mps * nz)
        obstacle_mps = touch.velocity_mps[0] * nx + touch.velocity_mps[1] * ny
        if touch.row not in self._touching:
            self._touching[touch.row] = touch.name
            self.collisions.append(Collision(time_s, touch.name, drone_mps, obstacle_mps))
        closing_mps = drone_mps + obstacle_mps
        body.x_m += nx * touch.depth_m
        body.y_m += ny * touch.depth_m
        body.z_m += nz * touch.depth_m
        if closing_mps > 0.0:
            self._push(touch, closing_mps)

    def _push(self, touch: Touch, closing_mps: float) -> None:
        body = self._vehicle
        nx, ny, nz = touch.normal
        change = (1.0 + RESTITUTION) * closing_mps
        body.vx_mps = (body.vx_mps + nx * change) * SCRAPE
        body.vy_mps = (body.vy_mps + ny * change) * SCRAPE
        body.vz_mps += nz * change
        if closing_mps > TUMBLE_MPS:
            body.tumble()

    def _forget_those_apart(self) -> None:
        if not self._touching:
            return
        body, places = self._vehicle, self._world.footprints
        signed = places.signed_m(body.x_m, body.y_m)
        for row in list(self._touching):
            level_m = max(
                body.z_m - places.top_m[row], places.bottom_m[row] - body.z_m - BODY_HEIGHT_M
            )
            if max(signed[row] - BODY_RADIUS_M, level_m) > APART_M:
                del self._touching[row]
        if self._touching:
            self._slack_m = 0.0
