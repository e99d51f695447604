# SPDX-License-Identifier: GPL-3.0-or-later
"""What pages may do to the drone: commands, the stop latch and the dead-man, held by the server.

Browsers throttle hidden tabs and vanish without a word, so none of this is left to a page.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from collections.abc import Sequence
from typing import Protocol

from ground.core import MissionCmd
from ground.errors import GroundError, LinkUnavailable, StopLatched
from ground.link.rate import LinkRate
from ground.model import Point
from ground.requests import Stick
from ground.station.station import Station
from ground.station.tuning import tune
from ground.web.hand import Hand

log = logging.getLogger(__name__)

DEAD_MAN_S = 3.0
STOP_AGAIN_S = 0.2
AREA_SIDE_M = 0.5
AREA = ("way.areaX0", "way.areaY0", "way.areaX1", "way.areaY1")
SELF_TEST = "self_test"

COMMANDS = {
    "take_off": MissionCmd.TAKE_OFF,
    "goto": MissionCmd.GOTO,
    "explore": MissionCmd.EXPLORE,
    "home": MissionCmd.HOME,
    "land": MissionCmd.LAND,
    "hold": MissionCmd.HOLD,
    "scan": MissionCmd.SCAN,
    "relocalise": MissionCmd.RELOCALISE,
    "spin": MissionCmd.SPIN,
}
WAYS = {"fly": MissionCmd.FLY, "patrol": MissionCmd.PATROL}


class Timeline(Protocol):
    """A recording that is shown in place of a drone."""

    position_s: float
    playing: bool

    @property
    def duration_s(self) -> float:
        """Of all of it."""

    def play(self) -> None:
        """Go on."""

    def pause(self) -> None:
        """Stay where it is."""

    def seek(self, time_s: float) -> None:
        """Go to that time."""


class Cockpit:
    """One drone, any number of pages. `station` is None while there is no link.

    With a `timeline` it shows a recording, and commands go nowhere.
    """

    def __init__(self, station: Station | None = None, dead_man_s: float = DEAD_MAN_S) -> None:
        self.station = station
        self.trouble: GroundError = LinkUnavailable("looking for the drone")
        """Why there is no station."""
        self.stop_latched = False
        self.timeline: Timeline | None = None
        self.rate = LinkRate()
        self.sticks = Hand()
        self._dead_man_s = dead_man_s
        self._closing = False
        self._pages = 0
        self._steered = False
        self._dead_man: asyncio.Task[None] | None = None
        self._stopping: asyncio.Task[None] | None = None

    def page_opened(self) -> None:
        """A page connected."""
        self._pages += 1
        if self._dead_man:
            self._dead_man.cancel()
            self._dead_man = None

    def page_closed(self) -> None:
        """A page is gone; if it was the last one and pages were steering, the drone will hold."""
        self._pages -= 1
        if self._pages == 0 and self._steered and not self._closing:
            self._dead_man = asyncio.create_task(self._hold_soon())

    async def command(self, name: str, goal: Point | None = None) -> None:
        """A command of COMMANDS, or SELF_TEST. Raises a GroundError with the sentence to show."""
        station = self._ready()
        if name == SELF_TEST:
            await station.set_parameter("way.selftest", 1)
            return
        cmd = COMMANDS.get(name)
        if cmd is None:
            raise GroundError(f"no such command: {name}")
        if cmd is MissionCmd.GOTO and not (
            goal and math.isfinite(goal.x_m) and math.isfinite(goal.y_m)
        ):
            raise GroundError("a goal needs two numbers")
        await station.command(cmd, goal)
        self._steered = cmd is not MissionCmd.LAND

    async def fly_along(self, name: str, points: Sequence[Point]) -> None:
        """A command of WAYS, along these points. Raises as command() does."""
        station = self._ready()
        await station.give_waypoints(points)
        await station.command(WAYS[name])
        self._steered = True

    def steer(self, page: object, stick: Stick) -> None:
        """Fly by hand. Raises a GroundError with the sentence to show."""
        self.sticks.take(self._ready(), page, stick)
        self._steered = True

    async def spin(self, turns: float) -> None:
        """Turn in place so often, counter-clockwise if positive. Raises as command() does."""
        await tune(self._ready(), "way.turns", turns)
        await self.command("spin")

    async def set_area(self, corner: Point, other: Point) -> None:
        """The area that is explored and never left. Raises a GroundError."""
        if abs(corner.x_m - other.x_m) < AREA_SIDE_M or abs(corner.y_m - other.y_m) < AREA_SIDE_M:
            raise GroundError(f"an area is at least {AREA_SIDE_M:g} m wide and deep")
        x_m, y_m = sorted((corner.x_m, other.x_m)), sorted((corner.y_m, other.y_m))
        for name, value in zip(AREA, (x_m[0], y_m[0], x_m[1], y_m[1]), strict=True):
            await self.set_parameter(name, value)

    async def set_parameter(self, name: str, value: float) -> None:
        """Write a parameter of group way and read it back. Raises a GroundError."""
        if self.timeline:
            raise GroundError("this is a recording")
        await tune(self._connected(), name, value)

    def stop(self) -> None:
        """Cut the motors and stay so until release(). Sent again until confirmed."""
        self.sticks.close()
        self.stop_latched = True
        if self._stopping is None or self._stopping.done():
            self._stopping = asyncio.create_task(self._stop())

    def release(self) -> None:
        """Permit commands again. The drone itself stays locked until it is restarted."""
        self.stop_latched = False

    async def close(self) -> None:
        """Before the link is closed: let a stop that was pressed get through, end all else."""
        self._closing = True
        self.sticks.close()
        await self.sticks.closed()
        if self._dead_man:
            self._dead_man.cancel()
            await asyncio.wait([self._dead_man])
        if self._stopping:
            await self._stopping

    async def _stop(self) -> None:
        """Until the drone confirms it, also over a link that comes back; or until released."""
        while self.stop_latched:
            try:
                await self._connected().emergency_stop()
                return
            except GroundError as error:
                log.error("emergency stop: %s", error)
            if self._closing:
                return
            await asyncio.sleep(STOP_AGAIN_S)

    async def _hold_soon(self) -> None:
        await asyncio.sleep(self._dead_man_s)
        self._steered = False
        station = self.station
        if station and station.picture.state.airborne and not self.stop_latched:
            log.warning("the page that steered is gone: the drone holds its place")
            with contextlib.suppress(GroundError):
                await station.command(MissionCmd.HOLD)

    def _ready(self) -> Station:
        if self.stop_latched:
            raise StopLatched("STOP is pressed: release it first")
        return self._connected()

    def _connected(self) -> Station:
        if self.station is None:
            raise LinkUnavailable("there is no link to the drone")
        return self.station
