# SPDX-License-Identifier: GPL-3.0-or-later
"""The server of the page: static files, and one WebSocket a page.

Binds this machine only, unless told otherwise; access.py says who may come in. What a page sends is
bounded in size. A stop may also come as a plain request, beside the WebSocket.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import socket
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from ground.errors import GroundError
from ground.web.access import LOCAL, Access, is_local
from ground.web.fleet import Fleet
from ground.web.page import Page

STATIC = Path(__file__).with_name("static")
USUAL_PORT = 8765
MESSAGE_BYTES = 4096
CONNECTIONS = 64
PAGES = 32


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

    async def stop(request: Request) -> Response:
        """For a page whose WebSocket is down. Access has refused foreign ones."""
        fleet.stop()
        return Response(status_code=204)

    return Starlette(
        routes=[
            Route("/stop", stop, methods=["POST"]),
            WebSocketRoute("/socket", serve_page),
            Mount("/", StaticFiles(directory=STATIC, html=True)),
        ],
        middleware=[Middleware(Access, token=token)],
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
