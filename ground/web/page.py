# SPDX-License-Identifier: GPL-3.0-or-later
"""One page at one WebSocket: what it wishes is taken, what there is to see is sent.

What a page sends is bounded in rate and in what is under way at once; a stop is taken whatever was
sent before.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import time
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from ground.errors import GroundError
from ground.web.asking import Asking
from ground.web.cockpit import Cockpit
from ground.web.events import events_frame, events_version
from ground.web.fleet import Fleet
from ground.web.frames import NO_TRAIL, fleet_rows, map_frame, state_frame
from ground.web.pace import Pace
from ground.web.parameters import parameters_frame, parameters_version
from ground.web.wishes import perform, stick_of, wind

STATE_PERIOD_S = 0.08
MAP_EVERY = 3  # states between two maps, at least
WISHES_PER_S = 10.0
WISHES_AT_ONCE = 20.0
STICKS_PER_S = 60.0
COMPLAINTS_PER_S = 0.5
COMMANDS_AT_ONCE = 8  # of one page, not answered yet


class Rate:
    """A bucket that fills again with time: what is in it may be spent at once."""

    def __init__(
        self, now_s: float, per_s: float = WISHES_PER_S, at_once: float = WISHES_AT_ONCE
    ) -> None:
        self._left, self._then_s = at_once, now_s
        self._per_s, self._at_once = per_s, at_once

    def allows(self, now_s: float) -> bool:
        """Whether one more is not too many; it counts then."""
        filled = self._left + (now_s - self._then_s) * self._per_s
        self._left, self._then_s = min(filled, self._at_once), now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class Page:
    """One connected page: reads wishes, sends frames of the drone that it has chosen."""

    def __init__(self, socket: WebSocket, fleet: Fleet) -> None:
        self._socket = socket
        self._fleet = fleet
        self._chosen = 0
        self._rate = Rate(time.monotonic())
        self._sticks = Rate(time.monotonic(), STICKS_PER_S, STICKS_PER_S)
        self._complaints = Rate(time.monotonic(), COMPLAINTS_PER_S, 1.0)
        self._pace = Pace()
        self._commands: set[asyncio.Task[None]] = set()
        self._asking = Asking(self._tell, lambda: self._cockpit.station)

    async def serve(self) -> None:
        """Until the page leaves; or until it cannot be told any more, so that it comes again."""
        await self._socket.accept()
        self._fleet.page_opened()
        try:
            async with asyncio.TaskGroup() as group:
                tasks = [group.create_task(work) for work in (self._write(), self._asking.run())]
                await self._read()
                for task in tasks:
                    task.cancel()
        finally:
            self._fleet.page_closed()
            for command in self._commands:
                command.cancel()

    async def _read(self) -> None:
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                try:
                    wish = json.loads(await self._socket.receive_text())
                except (ValueError, KeyError, RecursionError):
                    wish = None
                await self._take(wish if isinstance(wish, dict) else {})

    async def _take(self, wish: dict[str, Any]) -> None:
        """A stop is never too much; of all else only so much is taken."""
        if wish.get("do") == "stop":
            self._fleet.stop()
            return
        name = wish.get("do")
        if name == "taken":
            self._pace.taken()
            return
        if self._asking.take(wish):
            return
        if name == "manual":
            await self._steer(wish)
            return
        if not self._rate.allows(time.monotonic()) or len(self._commands) >= COMMANDS_AT_ONCE:
            await self._answer(str(name), "too much at once")
            return
        match wish:
            case {"do": "play" | "pause" | "seek"} if self._cockpit.timeline:
                wind(self._cockpit.timeline, wish)
            case {"do": "release"}:
                self._fleet.release()
            case {"do": "choose", "drone": int(number)} if type(number) is int and number in range(
                len(self._fleet.members)
            ):
                self._chosen = number
            case {"do": str(name)}:
                task = asyncio.create_task(self._perform(name, wish))
                self._commands.add(task)
                task.add_done_callback(self._commands.discard)

    async def _steer(self, wish: dict[str, Any]) -> None:
        """Sticks come many times a second: what is too much is left out, a refusal told seldom."""
        now_s = time.monotonic()
        if not self._sticks.allows(now_s):
            return
        try:
            self._cockpit.steer(self, stick_of(wish))
        except GroundError as error:
            if self._complaints.allows(now_s):
                await self._answer("manual", str(error))

    async def _perform(self, name: str, wish: dict[str, Any]) -> None:
        words = ""
        try:
            await perform(self._cockpit, wish)
        except GroundError as error:
            words = str(error)
        await self._answer(name, words, wish.get("name"))

    async def _answer(self, name: str, words: str, of: object = None) -> None:
        """Refused with words, or done; of a parameter with its name."""
        answer = {"kind": "answer", "do": name, "ok": not words, "words": words}
        if isinstance(of, str):
            answer["name"] = of
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._tell(answer)

    async def _tell(self, message: dict[str, Any]) -> None:
        await self._socket.send_text(json.dumps(message))

    @property
    def _cockpit(self) -> Cockpit:
        return self._fleet.members[self._chosen].cockpit

    async def _write(self) -> None:
        """A slow page gets fewer frames, never old ones."""
        mark, sent, said, chosen = NO_TRAIL, None, Said(), self._chosen
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            for turn in itertools.count():
                await self._pace.send_next()
                if chosen != self._chosen:
                    mark, sent, said, chosen = NO_TRAIL, None, Said(), self._chosen
                others = fleet_rows(self._fleet, chosen)
                text, mark = state_frame(self._cockpit, mark, others)
                await self._socket.send_text(text)
                if chosen == self._chosen:
                    for text in said.news(self._cockpit):
                        await self._socket.send_text(text)
                station = self._cockpit.station
                if station and (turn % MAP_EVERY == 0 or sent is None):
                    version = (chosen, id(station.picture), station.picture.map.revision)
                    if version != sent and chosen == self._chosen:
                        sent = version
                        await self._socket.send_bytes(map_frame(station.picture))
                await asyncio.sleep(STATE_PERIOD_S)


class Said:
    """What a page was told of what changes seldom: events and parameters."""

    def __init__(self) -> None:
        self._told: dict[str, object] = {}

    def news(self, cockpit: Cockpit) -> list[str]:
        """What is not as it was when it was told last."""
        frames = []
        for kind, version, frame in (
            ("events", events_version(cockpit), events_frame),
            ("parameters", parameters_version(cockpit), parameters_frame),
        ):
            if self._told.get(kind) != version:
                self._told[kind] = version
                frames.append(frame(cockpit))
        return frames
