# SPDX-License-Identifier: GPL-3.0-or-later
"""All drones of one station: their names, colours and places, and the stop for all of them."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from ground.model import Pose
from ground.web.cockpit import Cockpit

COLOURS = (
    "#0d9488",
    "#ea580c",
    "#6366f1",
    "#b7791f",
    "#e23a88",
    "#16a34a",
    "#0284c7",
    "#a855f7",
    "#e5484d",
    "#71809a",
)
"""Seen on the map's light free ground and on its dark one."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a drone was set down, in the map frame of the first."""

    x_m: float
    y_m: float
    yaw_rad: float = 0.0


@dataclass(slots=True)
class Member:
    """One drone. Without a place its map and those of others have nothing in common."""

    cockpit: Cockpit
    name: str = ""
    place: Place | None = None


@dataclass(slots=True)
class Fleet:
    """What pages talk to. The first drone is at (0, 0) of itself."""

    members: list[Member] = field(default_factory=list)

    @classmethod
    def of(cls, *cockpits: Cockpit) -> Fleet:
        """Without names or places."""
        return cls([Member(cockpit) for cockpit in cockpits])

    @property
    def cockpits(self) -> Iterator[Cockpit]:
        """All."""
        return (member.cockpit for member in self.members)

    def page_opened(self) -> None:
        """A page connected."""
        for cockpit in self.cockpits:
            cockpit.page_opened()

    def page_closed(self) -> None:
        """A page is gone."""
        for cockpit in self.cockpits:
            cockpit.page_closed()

    def stop(self) -> None:
        """Cut all motors of all drones, whichever a page looks at: it may be another's fault."""
        for cockpit in self.cockpits:
            cockpit.stop()

    def release(self) -> None:
        """Permit commands again."""
        for cockpit in self.cockpits:
            cockpit.release()

    async def close(self) -> None:
        """Let stops that were pressed get through."""
        for cockpit in self.cockpits:
            await cockpit.close()

    def seen_from(self, chosen: int, other: int) -> Pose | None:
        """The pose of one in the map frame of another, where both places are known."""
        station = self.members[other].cockpit.station
        telemetry = station.picture.telemetry if station else None
        here, there = self._place(chosen), self._place(other)
        if telemetry is None or here is None or there is None:
            return None
        turn = cmath.rect(1.0, there.yaw_rad)
        pose = telemetry.pose
        at = complex(there.x_m, there.y_m) + turn * complex(pose.x_m, pose.y_m)
        seen = (at - complex(here.x_m, here.y_m)) * cmath.rect(1.0, -here.yaw_rad)
        yaw_rad = math.remainder(pose.yaw_rad + there.yaw_rad - here.yaw_rad, math.tau)
        return Pose(seen.real, seen.imag, pose.z_m, yaw_rad)

    def _place(self, number: int) -> Place | None:
        return Place(0.0, 0.0) if number == 0 else self.members[number].place
