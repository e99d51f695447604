# SPDX-License-Identifier: GPL-3.0-or-later
"""One drone for scripts, with a method for each command.

    async with Station.connect("radio://0/80/2M/E7E7E7E7E7") as drone:
        await drone.explore()
        await drone.save_map("room.yaml")

A method returns when what was asked is done, and raises GroundError with a sentence where it is
not: NotReached, CommandRefused, LinkLost, NoAnswer. Who leaves the block lets the drone land.
Metres and radians, in the map frame: x forward and y left of the first take-off.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Sequence
from pathlib import Path

from rich.console import Console

from ground import station
from ground.cli_parts import SIMULATOR_URI
from ground.core import MissionCmd, MissionState
from ground.errors import GroundError, NoAnswer, NotReached
from ground.flight import Outcome, fly
from ground.link_kept import KeptLink
from ground.link_radio import RadioLink
from ground.map import GroundMap
from ground.mapfile import check_free, save_map
from ground.model import Point, Pose, Ranges
from ground.record import recorded
from ground.session import explain, fly_when_settled
from ground.steering import steer_for
from ground.stick import Stick
from ground.words import COMMAND_WORDS

MAP_PATIENCE_S = 30.0
LANDING_S = 60.0


class Station(station.Station):
    """A drone that is connected; made by connect()."""

    @classmethod
    @contextlib.asynccontextmanager
    async def connect(
        cls, uri: str | None = None, record: Path | None = None
    ) -> AsyncIterator[Station]:
        """Connect to this drone, to CFLIB_URI or to the simulator; record as `--record` does.

        Raises LinkUnavailable where nobody answers.
        """
        address = uri or os.environ.get("CFLIB_URI") or SIMULATOR_URI
        link = recorded(KeptLink(lambda: RadioLink(address)), record)
        drone = cls(link)
        async with station.station_on(link, drone):
            try:
                yield drone
            finally:
                await drone._come_down()

    @property
    def pose(self) -> Pose | None:
        """Where the drone believes to be; None before it was heard."""
        telemetry = self.picture.telemetry
        return telemetry.pose if telemetry else None

    @property
    def state(self) -> MissionState:
        """What it is doing."""
        return self.picture.state

    @property
    def ranges(self) -> Ranges | None:
        """What its sensors have measured last."""
        return self.picture.ranges

    @property
    def map(self) -> GroundMap:
        """Its map as far as it has come; whole after whole_map()."""
        return self.picture.map

    async def take_off(self) -> None:
        """Rise and hover."""
        await self._fly(MissionCmd.TAKE_OFF)

    async def goto(self, x_m: float, y_m: float) -> None:
        """Find a way there, fly it and hover."""
        await self._fly(MissionCmd.GOTO, Point(x_m, y_m))

    async def explore(self) -> None:
        """See all that can be reached, come home and land."""
        await self._fly(MissionCmd.EXPLORE)

    async def fly_along(self, points: Sequence[Point]) -> None:
        """Fly along these, at most twelve, and hover at the last."""
        await self.give_waypoints(points)
        await self._fly(MissionCmd.FLY)

    async def look_around(self) -> None:
        """Turn once, in the air."""
        await self._fly(MissionCmd.SCAN)

    async def hold(self) -> None:
        """Leave what it is doing and hover here."""
        await self._fly(MissionCmd.HOLD)

    async def steer(
        self,
        ahead_mps: float = 0.0,
        left_mps: float = 0.0,
        yaw_rate_rps: float = 0.0,
        climb_mps: float = 0.0,
        seconds: float = 1.0,
    ) -> None:
        """Fly by hand for so long, then stand; it must hold its place. It brakes before obstacles.

        Raises CommandRefused.
        """
        await steer_for(self, Stick(ahead_mps, left_mps, yaw_rate_rps, climb_mps), seconds)

    async def home(self) -> None:
        """Fly to where it took off, and land."""
        await self._fly(MissionCmd.HOME)

    async def land(self) -> None:
        """Land here."""
        await self._fly(MissionCmd.LAND)

    async def whole_map(self) -> GroundMap:
        """Wait until all of the map has come down. Raises NoAnswer."""
        self.ask_snapshot()
        try:
            async with asyncio.timeout(MAP_PATIENCE_S):
                while self.map.completeness < 1:
                    await asyncio.sleep(0.05)
        except TimeoutError:
            raise NoAnswer(f"{self.map.completeness:.0%} of the map have come") from None
        return self.map

    async def save_map(self, file: str | Path, overwrite: bool = False) -> None:
        """Write the whole map: .yaml (ROS map_server), .png, .svg, .csv or .npz, by the ending."""
        path = Path(file)
        check_free([path], overwrite)
        save_map(await self.whole_map(), path)

    async def _fly(self, cmd: MissionCmd, goal: Point | None = None) -> Outcome:
        outcome = await fly_when_settled(self, cmd, goal, Console(quiet=True))
        if not outcome.reached:
            raise NotReached(f"could not {COMMAND_WORDS[cmd]}: {explain(outcome)}")
        return outcome

    async def _come_down(self) -> None:
        with contextlib.suppress(GroundError, TimeoutError):
            async with asyncio.timeout(LANDING_S):
                if self.state.airborne:
                    await fly(self, MissionCmd.LAND)
