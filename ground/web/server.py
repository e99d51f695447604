# SPDX-License-Identifier: GPL-3.0-or-later
"""The server of the page: static files, and one WebSocket a page.

Binds 127.0.0.1 only. Host and Origin are checked for every request, the WebSocket's too: a
browser lets any site that the user visits open one to this machine.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import socket
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.responses import PlainTextResponse
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from ground.errors import GroundError
from ground.model import Point
from ground.web.cockpit import Cockpit
from ground.web.frames import NO_TRAIL, map_frame, state_frame

STATIC = Path(__file__).with_name("static")
USUAL_PORT = 8765
HOSTS = ["127.0.0.1", "localhost"]
STATE_PERIOD_S = 0.1
MAP_EVERY = 3  # states between two maps, at least
MESSAGE_BYTES = 4096
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class SameOrigin:
    """Refuse what a foreign page sends; WebSockets must say where they come from."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """ASGI entry."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        origin = headers.get("origin")
        same = origin is not None and urlsplit(origin).netloc == headers.get("host")
        if same or (origin is None and scope["type"] == "http"):
            await self._app(scope, receive, _with_policy(send))
        else:
            await PlainTextResponse("foreign origin", 403)(scope, receive, send)


def _with_policy(send: Send) -> Send:
    async def send_with_policy(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers["Content-Security-Policy"] = POLICY
            headers["X-Content-Type-Options"] = "nosniff"
            headers["Cache-Control"] = "no-cache"
        await send(message)

    return send_with_policy


class Page:
    """One connected page: a reader of its wishes, a writer that always sends the newest state."""

    def __init__(self, socket: WebSocket, cockpit: Cockpit) -> None:
        self._socket = socket
        self._cockpit = cockpit
        self._commands: set[asyncio.Task[None]] = set()

    async def serve(self) -> None:
        """Until the page leaves."""
        await self._socket.accept()
        self._cockpit.page_opened()
        writer = asyncio.create_task(self._write())
        try:
            await self._read()
        finally:
            self._cockpit.page_closed()
            writer.cancel()
            for command in self._commands:
                command.cancel()

    async def _read(self) -> None:
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                try:
                    wish = json.loads(await self._socket.receive_text())
                except (ValueError, KeyError):
                    continue
                if isinstance(wish, dict):
                    self._take(wish)

    def _take(self, wish: dict[str, Any]) -> None:
        match wish:
            case {"do": "stop"}:
                self._cockpit.stop()
            case {"do": "release"}:
                self._cockpit.release()
            case {"do": str(name)}:
                task = asyncio.create_task(self._command(name, _goal(wish)))
                self._commands.add(task)
                task.add_done_callback(self._commands.discard)

    async def _command(self, name: str, goal: Point | None) -> None:
        answer = {"kind": "answer", "do": name, "ok": True, "words": ""}
        try:
            await self._cockpit.command(name, goal)
        except GroundError as error:
            answer |= {"ok": False, "words": str(error)}
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._socket.send_text(json.dumps(answer))

    async def _write(self) -> None:
        """A slow page gets fewer frames, never old ones: each send waits for the one before."""
        mark, sent_map = NO_TRAIL, None
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            for turn in itertools.count():
                text, mark = state_frame(self._cockpit, mark)
                await self._socket.send_text(text)
                station = self._cockpit.station
                if station and turn % MAP_EVERY == 0:
                    version = (id(station), station.picture.map.revision)
                    if version != sent_map:
                        sent_map = version
                        await self._socket.send_bytes(map_frame(station.picture))
                await asyncio.sleep(STATE_PERIOD_S)


def _goal(wish: dict[str, Any]) -> Point | None:
    match wish:
        case {"x": int() | float() as x_m, "y": int() | float() as y_m}:
            return Point(float(x_m), float(y_m))
    return None


def make_app(cockpit: Cockpit) -> Starlette:
    """The page of this cockpit."""

    async def serve_page(websocket: WebSocket) -> None:
        await Page(websocket, cockpit).serve()

    return Starlette(
        routes=[
            WebSocketRoute("/socket", serve_page),
            Mount("/", StaticFiles(directory=STATIC, html=True)),
        ],
        middleware=[
            Middleware(TrustedHostMiddleware, allowed_hosts=HOSTS),
            Middleware(SameOrigin),
        ],
    )


class _Server(uvicorn.Server):
    """Signals belong to the program, not to the page."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


@contextlib.asynccontextmanager
async def page_server(cockpit: Cockpit, port: int | None) -> AsyncIterator[str]:
    """Serve the page meanwhile, at the address given. Port None: the usual or a free one."""
    listener = _listen(port)
    config = uvicorn.Config(
        make_app(cockpit),
        log_level="warning",
        ws="websockets-sansio",
        ws_max_size=MESSAGE_BYTES,
        lifespan="off",
        timeout_graceful_shutdown=1,
    )
    server = _Server(config)
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}/"
    finally:
        await cockpit.close()
        server.should_exit = True
        await serving


def _listen(port: int | None) -> socket.socket:
    ports = [USUAL_PORT, 0] if port is None else [port]
    for candidate in ports:
        try:
            return socket.create_server(("127.0.0.1", candidate))
        except OSError as error:
            reason = error.strerror
    raise GroundError(f"cannot serve the page on port {ports[-1]}: {reason}")
