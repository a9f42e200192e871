"""Who may ask the server: checks of Host, Origin and token before any route, and headers on every reply.

A page of another site cannot read replies, but it can send requests to a server on this machine, and with a name that it resolves
to 127.0.0.1 it could even read. So the Host must be one of the server's own names and the Origin, where a browser states one, the
page's own. A server that others can reach asks for a token as well.
"""

from __future__ import annotations

import asyncio
import hmac
import http.cookies
import ipaddress
import json
import socket
import urllib.parse
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "infinivar_token"

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; font-src 'self'; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
"""Content-security policy: nothing but what this server sends, no code in text, no frame around the page."""

HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), payment=(), usb=()",
}
"""Headers of every reply."""

SEND_SECONDS = 30.0
"""Longest that a peer may take to accept a part of a reply. [s]"""

_LOOPBACK_NAMES = ("localhost", "127.0.0.1", "[::1]")


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches a server that listens there."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


class Guard:
    """Lets only requests through that this server's own page, or a program on this machine, can send."""

    def __init__(self, app: App, *, host: str, port: int, token: str | None) -> None:
        """Guard an app that listens at a host and port; with a token, only for those who know it."""
        self._app, self._port, self._token = app, port, token
        self._wide = not is_loopback(host)
        own = {host.lower(), f"[{host.lower()}]"}
        if self._wide:
            own |= {socket.gethostname().lower(), socket.getfqdn().lower()}
        self._names = own | set(_LOOPBACK_NAMES)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":  # no web sockets
            await send({"type": "websocket.close", "code": 1008})
            return

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = {name.lower() for name, _ in message.get("headers", ())}
                added = [(name.lower().encode(), value.encode()) for name, value in HEADERS.items()]
                headers = [*message.get("headers", ()), *((name, value) for name, value in added if name not in given)]
                message = {**message, "headers": headers}
            await asyncio.wait_for(send(message), SEND_SECONDS)

        refusal = self._refusal(scope)
        if refusal is not None:
            await _reply(guarded, *refusal)
        elif self._token is not None and not self._known(scope):
            await self._introduce(scope, guarded)
        else:
            await self._app(scope, receive, guarded)

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        """Status and words, if the request comes by another name of this server, or from another site."""
        if not scope["path"].isprintable():
            return 400, "the path of the request has control characters"
        hosts = _values(scope, b"host")
        if len(hosts) != 1 or not self._own(hosts[0]):
            return 421, "the Host of the request is not this server"
        origins = _values(scope, b"origin")
        if origins and (len(origins) > 1 or origins[0] != f"http://{hosts[0]}"):
            return 403, "requests of other sites are refused"
        if any(site not in ("same-origin", "none") for site in _values(scope, b"sec-fetch-site")):
            if scope["method"] == "GET" and scope["path"] == "/":  # a link to the page, which only shows it
                return None
            return 403, "requests of other sites are refused"
        return None

    def _own(self, host: str) -> bool:
        """Whether a Host is one of this server's names, with its port. A name of another site never is; addresses are."""
        name, _, port = host.rpartition(":") if not host.endswith("]") and ":" in host else (host, "", "80")
        if port != str(self._port):
            return False
        if name.lower() in self._names:
            return True
        return self._wide and _is_address(name)

    def _known(self, scope: Scope) -> bool:
        """Whether the request has the token, in the cookie that the page was given or as a bearer."""
        assert self._token is not None
        found = [value.removeprefix("Bearer ") for value in _values(scope, b"authorization")]
        for value in _values(scope, b"cookie"):
            jar = http.cookies.SimpleCookie()
            try:
                jar.load(value)
            except http.cookies.CookieError:
                continue
            if COOKIE in jar:
                found.append(jar[COOKIE].value)
        return any(_same(one, self._token) for one in found)

    async def _introduce(self, scope: Scope, send: Send) -> None:
        """Turn the token of the printed address into a cookie, or refuse."""
        query = urllib.parse.parse_qs(scope.get("query_string", b"").decode("latin-1"))
        given = query.get("token", [""])[0]
        if scope["method"] == "GET" and scope["path"] == "/" and _same(given, self._token or ""):
            cookie = f"{COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/"
            headers = [(b"location", b"/"), (b"set-cookie", cookie.encode()), (b"cache-control", b"no-store")]
            await send({"type": "http.response.start", "status": 303, "headers": headers})
            await send({"type": "http.response.body", "body": b""})
            return
        await _reply(send, 401, "a token is needed: open the address that infinivar serve printed")


def _values(scope: Scope, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in scope["headers"] if key == name]


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def _same(one: str, other: str) -> bool:
    return bool(other) and hmac.compare_digest(one.encode("utf-8", "replace"), other.encode())


async def _reply(send: Send, status: int, words: str) -> None:
    headers = [(b"content-type", b"application/json"), (b"cache-control", b"no-store")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": json.dumps({"error": words}).encode()})
