# SPDX-License-Identifier: GPL-3.0-or-later
"""Who may talk to the server: the page that it has served, on a machine that it trusts.

Host and Origin are checked for every request, the WebSocket's too: a browser lets any site that the
user visits open one to this machine. Bound to other addresses than this machine's own it wants a
token as well, once in the address, then as a cookie.
"""

from __future__ import annotations

import hmac
import ipaddress
import socket
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOCAL = ("127.0.0.1", "localhost")
COOKIE = "wayflie"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Access:
    """Refuses what foreign pages and, with a token, foreign people send."""

    def __init__(self, app: ASGIApp, token: str | None = None) -> None:
        self._app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """ASGI entry."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
        elif answer := self._refusal(scope):
            await answer(scope, receive, send)
        else:
            await self._app(scope, receive, _with_policy(send))

    def _refusal(self, scope: Scope) -> PlainTextResponse | RedirectResponse | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not self._is_ours(host):
            return PlainTextResponse("unknown host", 400)
        origin = headers.get("origin")
        same = origin is not None and urlsplit(origin).netloc == host
        if not same and (origin is not None or scope["type"] == "websocket"):
            return PlainTextResponse("foreign origin", 403)
        if self._token is None or self._knows(headers.get("cookie", "")):
            return None
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if scope["type"] == "websocket" or not self._is_token(given):
            return PlainTextResponse("open the address that the ground station has printed", 401)
        entered = RedirectResponse("/", 303)
        entered.set_cookie(COOKIE, given, httponly=True, samesite="strict")
        return entered

    def _is_ours(self, host: str) -> bool:
        """A name could be made to lead here by anybody: with a token, only bare addresses too."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in LOCAL:
            return True
        return self._token is not None and (_is_address(name) or name == socket.gethostname())

    def _knows(self, cookies: str) -> bool:
        try:
            found = SimpleCookie(cookies).get(COOKIE)
        except CookieError:
            return False
        return found is not None and self._is_token(found.value)

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), (self._token or "").encode())


def is_local(address: str) -> bool:
    """Only this machine can reach what is bound there."""
    return address in LOCAL or (_is_address(address) and ipaddress.ip_address(address).is_loopback)


def _is_address(text: str) -> bool:
    try:
        ipaddress.ip_address(text)
    except ValueError:
        return False
    return True


def _with_policy(send: Send) -> Send:
    async def send_with_policy(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers["Content-Security-Policy"] = POLICY
            headers["X-Content-Type-Options"] = "nosniff"
            headers["Referrer-Policy"] = "no-referrer"
            headers["Cache-Control"] = "no-cache"
        await send(message)

    return send_with_policy
