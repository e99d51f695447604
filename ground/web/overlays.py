# SPDX-License-Identifier: GPL-3.0-or-later
"""What one page wants to know of the map: previews of goals, and layers that are computed here.

The computing is done in a thread, one thing at a time: frames never wait for it. Of several places
that are asked for only the newest is answered.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Awaitable, Callable
from typing import Any, ParamSpec, TypeVar

from starlette.websockets import WebSocketDisconnect

from ground.model import Point
from ground.station.picture import Picture
from ground.station.station import Station
from ground.web.insight import Edge, Frontier, Known, frontiers, preview
from ground.web.people import People

ASK_PERIOD_S = 0.1
LAYERS_PERIOD_S = 0.5
PEOPLE_PERIOD_S = 0.1
LAYERS = ("tree", "frontiers", "people")
MOVED_M = 0.1  # by less, nothing is computed anew
NO_DATA = "there is no data of the drone yet"

P = ParamSpec("P")
T = TypeVar("T")
Message = dict[str, Any]
Send = Callable[[Message], Awaitable[None]]


class Overlays:
    """The questions of one page. `station` gives that of the drone that the page looks at."""

    def __init__(self, send: Send, station: Callable[[], Station | None]) -> None:
        self._send = send
        self._station = station
        self._question: tuple[Point, Point | None] | None = None
        self._asked = asyncio.Event()
        self._want: frozenset[str] = frozenset()
        self._busy = asyncio.Lock()
        self._told: object = None

    def take(self, wish: Message) -> bool:
        """A wish of the page. @return False if it is none of these"""
        match wish:
            case {"do": "ask", "x": int() | float() as x, "y": int() | float() as y}:
                if (place := _place(x, y)) is not None:
                    self._question = place, _start(wish)
                    self._asked.set()
            case {"do": "layers", "want": list(names)}:
                self._want = frozenset(name for name in LAYERS if name in names)
                self._told = None
            case {"do": "ask" | "layers"}:
                pass
            case _:
                return False
        return True

    async def run(self) -> None:
        """Answer until cancelled, or until the page has gone."""
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await asyncio.gather(self._answer(), self._tell_layers(), self._tell_people())

    async def _answer(self) -> None:
        while True:
            await self._asked.wait()
            self._asked.clear()
            if self._question is not None:
                await self._send(await self._preview(*self._question))
            await asyncio.sleep(ASK_PERIOD_S)

    async def _preview(self, place: Point, start: Point | None) -> Message:
        answer = {"kind": "preview", "x": place.x_m, "y": place.y_m}
        known = self._known()
        if known is not None and start is not None:
            known = known.seen_from(start)
        if known is None:
            return answer | {"ok": False, "words": NO_DATA, "path": []}
        found = await self._compute(preview, known, place)
        answer |= {"ok": bool(found.path), "words": found.words, "seen_m": found.seen_m}
        answer["path"] = [_xy(point) for point in found.path]
        if "tree" in self._want:
            answer["tree"] = _edges(found.tree)
        return answer

    async def _tell_layers(self) -> None:
        while True:
            await asyncio.sleep(LAYERS_PERIOD_S)
            want = self._want & {"tree", "frontiers"}
            picture = self._picture()
            if not want or picture is None or picture.telemetry is None:
                continue
            version = _version(picture)
            if version == self._told:
                continue
            self._told = version
            await self._send(await self._layers(want, picture))

    async def _layers(self, want: frozenset[str], picture: Picture) -> Message:
        message: Message = {"kind": "layers"}
        known, telemetry = Known.of(picture), picture.telemetry
        if known is None or telemetry is None:
            return message
        if "frontiers" in want:
            message["frontiers"] = [_row(f) for f in await self._compute(frontiers, known)]
        if "tree" in want:
            flies = picture.state.airborne and bool(picture.route)
            message["tree"] = []
            if flies:
                found = await self._compute(preview, known, telemetry.goal)
                message["tree"] = _edges(found.tree)
        return message

    async def _tell_people(self) -> None:
        people, about, told_s = People(), None, 0.0
        seen: list[Point] = []
        while True:
            await asyncio.sleep(PEOPLE_PERIOD_S)
            picture = self._picture()
            if "people" not in self._want or picture is None:
                continue
            if picture is not about:
                people, about, seen = People(), picture, []
            now_s = time.monotonic()
            seen += people.look(picture, now_s)
            if seen and now_s - told_s >= LAYERS_PERIOD_S:
                await self._send({"kind": "layers", "people": [_xy(point) for point in seen]})
                told_s, seen = now_s, []

    async def _compute(self, function: Callable[P, T], *of: P.args, **more: P.kwargs) -> T:
        async with self._busy:
            return await asyncio.to_thread(function, *of, **more)

    def _picture(self) -> Picture | None:
        station = self._station()
        return station.picture if station else None

    def _known(self) -> Known | None:
        picture = self._picture()
        return Known.of(picture) if picture else None


def _version(picture: Picture) -> object:
    """What layers depend on, but for small motions."""
    assert picture.telemetry is not None
    pose, goal = picture.telemetry.pose, picture.telemetry.goal
    place = round(pose.x_m / MOVED_M), round(pose.y_m / MOVED_M)
    limits = tuple(picture.parameters.items())
    return id(picture), picture.map.revision, place, goal, picture.state, limits


def _place(x: float, y: float) -> Point | None:
    with contextlib.suppress(OverflowError):  # JSON knows no largest number
        place = Point(float(x), float(y))
        if math.isfinite(place.x_m) and math.isfinite(place.y_m):
            return place
    return None


def _start(wish: Message) -> Point | None:
    match wish:
        case {"from": [int() | float() as x, int() | float() as y]}:
            return _place(x, y)
    return None


def _row(frontier: Frontier) -> list[float]:
    return [*_xy(frontier.place), frontier.gain_cells, int(frontier.first)]


def _edges(tree: tuple[Edge, ...]) -> list[list[float]]:
    return [[round(value, 2) for value in edge] for edge in tree]


def _xy(point: Point) -> list[float]:
    return [round(point.x_m, 3), round(point.y_m, 3)]
