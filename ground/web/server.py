# SPDX-License-Identifier: GPL-3.0-or-later
"""The server of the page: static files, and one WebSocket a page.

Binds this machine only, unless told otherwise; guard.py says who may come in. What a page sends is
bounded in size, in rate and in what is under way at once; a stop is taken whatever was sent before.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import math
import secrets
import socket
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from ground.errors import GroundError
from ground.model import Point
from ground.web.asking import Asking
from ground.web.cockpit import Cockpit, Timeline
from ground.web.fleet import Fleet
from ground.web.frames import NO_TRAIL, fleet_rows, map_frame, state_frame
from ground.web.guard import LOCAL, Guard, is_local

STATIC = Path(__file__).with_name("static")
USUAL_PORT = 8765
STATE_PERIOD_S = 0.1
MAP_EVERY = 3  # states between two maps, at least
MESSAGE_BYTES = 4096
WISHES_PER_S = 10.0
WISHES_AT_ONCE = 20.0
COMMANDS_AT_ONCE = 8  # of one page, not answered yet
CONNECTIONS = 64
PAGES = 32


class Rate:
    """A bucket that fills again with time: what is in it may be spent at once."""

    def __init__(self, now_s: float) -> None:
        self._left, self._then_s = WISHES_AT_ONCE, now_s

    def allows(self, now_s: float) -> bool:
        """Whether one more is not too many; it counts then."""
        filled = self._left + (now_s - self._then_s) * WISHES_PER_S
        self._left, self._then_s = min(filled, WISHES_AT_ONCE), now_s
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
        self._commands: set[asyncio.Task[None]] = set()
        self._asking = Asking(self._tell, lambda: self._cockpit.station)

    async def serve(self) -> None:
        """Until the page leaves."""
        await self._socket.accept()
        self._fleet.page_opened()
        tasks = [asyncio.create_task(work) for work in (self._write(), self._asking.run())]
        try:
            await self._read()
        finally:
            self._fleet.page_closed()
            for task in (*tasks, *self._commands):
                task.cancel()

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
        if self._asking.take(wish):
            return
        name = wish.get("do")
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
                task = asyncio.create_task(self._command(name, _goal(wish)))
                self._commands.add(task)
                task.add_done_callback(self._commands.discard)

    async def _command(self, name: str, goal: Point | None) -> None:
        words = ""
        try:
            await self._cockpit.command(name, goal)
        except GroundError as error:
            words = str(error)
        await self._answer(name, words)

    async def _answer(self, name: str, words: str) -> None:
        """Refused with words, or done."""
        answer = {"kind": "answer", "do": name, "ok": not words, "words": words}
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._tell(answer)

    async def _tell(self, message: dict[str, Any]) -> None:
        await self._socket.send_text(json.dumps(message))

    @property
    def _cockpit(self) -> Cockpit:
        return self._fleet.members[self._chosen].cockpit

    async def _write(self) -> None:
        """A slow page gets fewer frames, never old ones: each send waits for the one before."""
        mark, sent, chosen = NO_TRAIL, None, self._chosen
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            for turn in itertools.count():
                if chosen != self._chosen:
                    mark, sent, chosen = NO_TRAIL, None, self._chosen
                others = fleet_rows(self._fleet, chosen)
                text, mark = state_frame(self._cockpit, mark, others)
                await self._socket.send_text(text)
                station = self._cockpit.station
                if station and (turn % MAP_EVERY == 0 or sent is None):
                    version = (chosen, id(station.picture), station.picture.map.revision)
                    if version != sent and chosen == self._chosen:
                        sent = version
                        await self._socket.send_bytes(map_frame(station.picture))
                await asyncio.sleep(STATE_PERIOD_S)


def wind(line: Timeline, wish: dict[str, Any]) -> None:
    """Play, pause or seek, as a page wishes; what makes no sense does nothing."""
    match wish:
        case {"do": "play"}:
            line.play()
        case {"do": "pause"}:
            line.pause()
        case {"do": "seek", "s": int() | float() as time_s} if math.isfinite(time_s):
            line.seek(float(time_s))


def _goal(wish: dict[str, Any]) -> Point | None:
    match wish:
        case {"x": int() | float() as x_m, "y": int() | float() as y_m}:
            with contextlib.suppress(OverflowError):  # JSON knows no largest number
                return Point(float(x_m), float(y_m))
    return None


def make_app(fleet: Fleet, token: str | None = None) -> Starlette:
    """The page of these drones."""
    pages: set[WebSocket] = set()

    async def serve_page(websocket: WebSocket) -> None:
        if len(pages) >= PAGES:
            await websocket.close()
            return
        pages.add(websocket)
        try:
            await Page(websocket, fleet).serve()
        finally:
            pages.discard(websocket)

    return Starlette(
        routes=[
            WebSocketRoute("/socket", serve_page),
            Mount("/", StaticFiles(directory=STATIC, html=True)),
        ],
        middleware=[Middleware(Guard, token=token)],
    )


class _Server(uvicorn.Server):
    """Signals belong to the program, not to the page."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


@contextlib.asynccontextmanager
async def page_server(fleet: Fleet, port: int | None, bind: str = LOCAL[0]) -> AsyncIterator[str]:
    """Serve the page meanwhile, at the address given. Port None: the usual or a free one."""
    listener = _listen(bind, port)
    token = None if is_local(bind) else secrets.token_urlsafe(16)
    config = uvicorn.Config(
        make_app(fleet, token),
        log_level="warning",
        access_log=False,
        ws="websockets-sansio",
        ws_max_size=MESSAGE_BYTES,
        limit_concurrency=CONNECTIONS,
        lifespan="off",
        timeout_graceful_shutdown=1,
    )
    server = _Server(config)
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        yield _address(bind, listener.getsockname()[1], token)
    finally:
        await fleet.close()
        server.should_exit = True
        await serving


def _address(bind: str, port: int, token: str | None) -> str:
    if token is None:
        return f"http://{bind}:{port}/"
    host = socket.gethostname() if bind in ("0.0.0.0", "::") else bind
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/?token={token}"


def _listen(bind: str, port: int | None) -> socket.socket:
    ports = [USUAL_PORT, 0] if port is None else [port]
    family = socket.AF_INET6 if ":" in bind else socket.AF_INET
    for candidate in ports:
        try:
            return socket.create_server((bind, candidate), family=family)
        except OSError as error:
            reason = error.strerror
    raise GroundError(f"cannot serve the page at {bind}, port {ports[-1]}: {reason}")
