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
from ground.nextsteps import next_step
from ground.web.cockpit import Cockpit
from ground.web.events import events_frame, events_version
from ground.web.fleet import Fleet
from ground.web.flow import Allowance, Unread
from ground.web.frames import NOTHING, fleet_rows, map_frame, state_frame
from ground.web.overlays import Overlays
from ground.web.parameters import parameters_frame, parameters_version
from ground.web.wishes import perform, stick_of, wind

STATE_PERIOD_S = 0.08
MAP_EVERY = 3  # states between two maps, at least
WISHES_PER_S = 10.0
WISHES_AT_ONCE = 20.0
STICKS_PER_S = 60.0
COMPLAINTS_PER_S = 0.5
COMMANDS_AT_ONCE = 8  # of one page, not answered yet


class Page:
    """One connected page: reads wishes, sends frames of the drone that it has chosen."""

    def __init__(self, socket: WebSocket, fleet: Fleet) -> None:
        self._socket = socket
        self._fleet = fleet
        self._chosen = 0
        self._allowance = Allowance(time.monotonic(), WISHES_PER_S, WISHES_AT_ONCE)
        self._sticks = Allowance(time.monotonic(), STICKS_PER_S, STICKS_PER_S)
        self._complaints = Allowance(time.monotonic(), COMPLAINTS_PER_S, 1.0)
        self._unread = Unread()
        self._commands: set[asyncio.Task[None]] = set()
        self._overlays = Overlays(self._tell, lambda: self._cockpit.station)

    async def serve(self) -> None:
        """Until the page leaves; or until it cannot be told any more, so that it comes again."""
        await self._socket.accept()
        self._fleet.page_opened()
        try:
            async with asyncio.TaskGroup() as group:
                tasks = [group.create_task(work) for work in (self._write(), self._overlays.run())]
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
        match wish.get("do"):
            case "stop":
                self._fleet.stop()
            case "taken":
                self._unread.taken()
            case "manual":
                await self._steer(wish)
            case name:
                if self._overlays.take(wish):
                    return
                free = len(self._commands) < COMMANDS_AT_ONCE
                if self._allowance.allows(time.monotonic()) and free:
                    self._do(wish)
                else:
                    await self._answer(str(name), GroundError("too much at once"))

    def _do(self, wish: dict[str, Any]) -> None:
        """At once, or as a command that is answered; nonsense is not."""
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
                await self._answer("manual", error)

    async def _perform(self, name: str, wish: dict[str, Any]) -> None:
        refusal: GroundError | None = None
        try:
            await perform(self._cockpit, wish)
        except GroundError as error:
            refusal = error
        await self._answer(name, refusal, wish.get("name"))

    async def _answer(self, name: str, refusal: GroundError | None, of: object = None) -> None:
        """Refused with words, or done; of a parameter with its name."""
        words, step = (str(refusal), next_step(refusal)) if refusal else ("", "")
        answer = {"kind": "answer", "do": name, "ok": not words, "words": words, "step": step}
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
        mark, sent, said, chosen = NOTHING, None, Said(), self._chosen
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            for turn in itertools.count():
                await self._unread.send_next()
                if chosen != self._chosen:
                    mark, sent, said, chosen = NOTHING, None, Said(), self._chosen
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
