# SPDX-License-Identifier: GPL-3.0-or-later
"""One drone for scripts, with a method for each command.

    async with Station.connect("radio://0/80/2M/E7E7E7E7E7") as drone:
        await drone.explore()
        await drone.save_map("room.yaml")

A method returns when the drone has done what was asked; otherwise it raises a GroundError that says
why: NotReached, CommandRefused, LinkLost, NoAnswer. At the end of the block the drone lands.
Metres and radians, in the map frame: x forward and y left of the first take-off.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import AsyncIterator, Sequence
from pathlib import Path

from ground.core import MissionCmd, MissionState
from ground.errors import NoAnswer, NotReached
from ground.link.kept import KeptLink
from ground.link.radio import RadioLink
from ground.link.uri import SIMULATOR_URI
from ground.map.files import check_free, save_map
from ground.map.groundmap import GroundMap
from ground.model import Point, Pose, Ranges
from ground.record.recorder import recorded
from ground.requests import Stick
from ground.station import station
from ground.station.flight import bring_down
from ground.station.maps import await_map
from ground.station.settling import fly_when_settled
from ground.station.steering import steer_for
from ground.words import COMMAND_WORDS


class Station(station.Station):
    """A connected drone; made by connect()."""

    @classmethod
    @contextlib.asynccontextmanager
    async def connect(
        cls, uri: str | None = None, record: Path | None = None
    ) -> AsyncIterator[Station]:
        """Connect to `uri`, else to CFLIB_URI, else to the simulator; record as `--record` does.

        Raises LinkUnavailable if nobody answers.
        """
        address = uri or os.environ.get("CFLIB_URI") or SIMULATOR_URI
        link = recorded(KeptLink(lambda: RadioLink(address)), record)
        drone = cls(link)
        async with station.station_on(link, drone):
            try:
                yield drone
            finally:
                await bring_down(drone)

    @property
    def pose(self) -> Pose | None:
        """The drone's estimate of its pose; None before the first telemetry."""
        telemetry = self.picture.telemetry
        return telemetry.pose if telemetry else None

    @property
    def state(self) -> MissionState:
        """What the drone is doing."""
        return self.picture.state

    @property
    def ranges(self) -> Ranges | None:
        """The latest ranges; None before the first."""
        return self.picture.ranges

    @property
    def map(self) -> GroundMap:
        """The map as far as it has been received; the whole of it after whole_map()."""
        return self.picture.map

    async def take_off(self) -> None:
        """Take off and hover."""
        await self._fly(MissionCmd.TAKE_OFF)

    async def goto(self, x_m: float, y_m: float) -> None:
        """Plan a route there, fly it and hover."""
        await self._fly(MissionCmd.GOTO, Point(x_m, y_m))

    async def explore(self) -> None:
        """Explore everything that can be reached, come home and land."""
        await self._fly(MissionCmd.EXPLORE)

    async def fly_along(self, points: Sequence[Point]) -> None:
        """Fly along these points, at most twelve, and hover at the last."""
        await self.give_waypoints(points)
        await self._fly(MissionCmd.FLY)

    async def look_around(self) -> None:
        """Turn once in the air and map the surroundings."""
        await self._fly(MissionCmd.SCAN)

    async def hold(self) -> None:
        """Stop the present task and hover here."""
        await self._fly(MissionCmd.HOLD)

    async def steer(
        self,
        ahead_mps: float = 0.0,
        left_mps: float = 0.0,
        yaw_rate_rps: float = 0.0,
        climb_mps: float = 0.0,
        seconds: float = 1.0,
    ) -> None:
        """Fly by hand for `seconds`, then hover; the drone must be hovering. It stops at obstacles.

        Raises CommandRefused.
        """
        await steer_for(self, Stick(ahead_mps, left_mps, yaw_rate_rps, climb_mps), seconds)

    async def home(self) -> None:
        """Fly back to the place of take-off and land."""
        await self._fly(MissionCmd.HOME)

    async def land(self) -> None:
        """Land here."""
        await self._fly(MissionCmd.LAND)

    async def whole_map(self) -> GroundMap:
        """Wait until the whole map has been received. Raises NoAnswer."""
        if not await await_map(self):
            raise NoAnswer(f"only {self.map.completeness:.0%} of the map came")
        return self.map

    async def save_map(self, file: str | Path, overwrite: bool = False) -> None:
        """Write the whole map by the ending: .yaml (ROS map_server), .png, .svg, .csv or .npz."""
        path = Path(file)
        check_free(path, overwrite)
        save_map(await self.whole_map(), path)

    async def _fly(self, cmd: MissionCmd, goal: Point | None = None) -> None:
        outcome = await fly_when_settled(self, cmd, goal)
        if not outcome.reached:
            raise NotReached(f"could not {COMMAND_WORDS[cmd]}: {outcome.told}")
