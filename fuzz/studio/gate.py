"""Access control: only the browser that was given the token, on this server's own page, gets in.

A page of another site can make a browser send requests here, and can make its own host name point
to this machine (DNS rebinding). So every request must name a host that is this server's, a page's
request must come from this server's own page, and all requests but the first must carry the cookie
that only the token provides. Cookies ignore ports: a browser also sends ours to other servers on
this machine. So the cookie only gives access to the page's files, which are not secret. The
connection needs the token itself, which the page keeps where only pages of this port can read it.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import secrets
import socket
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers, MutableHeaders, QueryParams
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from fuzz.studio.requests.protocol import SUBPROTOCOL

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
_ANY = ("0.0.0.0", "::")
_UNSAID = 80  # the port that browsers omit
_REFUSED = (
    "This is a worldgen studio, but your browser has no access.\n\nOpen the complete address that "
    "`worldgen studio` printed, including its token. A restarted studio has a new token.\n"
)


@dataclass(frozen=True)
class Gate:
    """Decides which requests get in.

    Args:
        host: Name or address that the server is bound to, as a browser writes it.
        port: Its port.
        token: Secret that the first address must contain; a new one if omitted.
    """

    host: str
    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)
    _tickets: set[str] = field(default_factory=set, init=False, repr=False, compare=False)

    @property
    def cookie(self) -> str:
        """Name of the cookie; servers on other ports use their own."""
        return f"worldgen-studio-{self.port}"

    @property
    def cookie_value(self) -> str:
        """Value of the cookie; it is derived from the token but does not reveal it."""
        return hmac.new(self.token.encode(), b"cookie", hashlib.sha256).hexdigest()

    @property
    def address(self) -> str:
        """The address to open, with the token."""
        return f"{self._place}/?token={self.token}"

    def address_for_once(self) -> str:
        """Return an address that works once and leads to the one with the token.

        Everyone on the machine can read the arguments of a browser's process.
        """
        ticket = secrets.token_urlsafe(32)
        self._tickets.add(ticket)
        return f"{self._place}/?ticket={ticket}"

    def takes_ticket(self, ticket: str) -> bool:
        """Return True if this ticket has not been used yet, and mark it as used."""
        if ticket not in self._tickets:
            return False
        self._tickets.remove(ticket)
        return True

    @property
    def _place(self) -> str:
        host = (
            "127.0.0.1"
            if self.host in _ANY
            else f"[{self.host}]"
            if ":" in self.host
            else self.host
        )
        return f"http://{host}:{self.port}"

    def knows_host(self, host: str) -> bool:
        """Return True if a Host header names this server, not another name pointed to it."""
        name = host.removesuffix(f":{self.port}")
        if name == host and self.port != _UNSAID:
            return False
        if name in (self.host, f"[{self.host}]"):
            return True
        # Bound to all addresses: accept any address, because addresses cannot be rebound.
        if self.host in _ANY:
            return name in (*LOOPBACK, socket.gethostname()) or _is_address(name)
        return name in LOOPBACK and self.host in ("127.0.0.1", "localhost", "::1")

    def is_ours(self, headers: Headers) -> bool:
        """Return True if a request comes from a page of this server, or not from a page."""
        origin = headers.get("origin")
        if origin is not None and origin != f"http://{headers.get('host', '')}":
            return False
        return headers.get("sec-fetch-site", "none") in ("none", "same-origin")

    def has_cookie(self, headers: Headers) -> bool:
        """Return True if a request has the cookie that the token provides."""
        jar: SimpleCookie = SimpleCookie()
        try:
            jar.load(headers.get("cookie", ""))
        except CookieError:
            return False
        return self.cookie in jar and _are_same(jar[self.cookie].value, self.cookie_value)

    def has_token(self, headers: Headers) -> bool:
        """Return True if a WebSocket offers the token as the second of its subprotocols."""
        offered = [name.strip() for name in headers.get("sec-websocket-protocol", "").split(",")]
        return len(offered) == 2 and offered[0] == SUBPROTOCOL and self.is_token(offered[1])

    def is_token(self, text: str) -> bool:
        """Return True if this is the token; the time taken does not depend on the text."""
        return _are_same(text, self.token)

    def headers(self, said_host: str, sources: str) -> dict[str, str]:
        """Return the security headers of every answer.

        They forbid all scripts and styles except those of the page.

        Args:
            said_host: The server as the request names it.
            sources: The part of the policy that allows the page's scripts and styles.
        """
        policy = (
            f"default-src 'none'; {sources}; img-src 'self' data: blob:; connect-src 'self' "
            f"ws://{said_host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        return {
            "content-security-policy": policy,
            "x-content-type-options": "nosniff",
            "referrer-policy": "no-referrer",
            "cross-origin-opener-policy": "same-origin",
            "cross-origin-resource-policy": "same-origin",
            "x-frame-options": "DENY",
            "cache-control": "no-store",
        }


def _are_same(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode("utf-8", "replace"), wanted.encode())


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.removeprefix("[").removesuffix("]"))
    except ValueError:
        return False
    return True


class Guarded:
    """An application behind a gate.

    Args:
        app: The application.
        gate: Access control.
        sources: See :meth:`Gate.headers`.
    """

    def __init__(self, app: ASGIApp, gate: Gate, sources: str) -> None:
        self.app = app
        self.gate = gate
        self.sources = sources

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        # Everything except server events is judged, and every answer gets the security headers.
        headers = Headers(scope=scope)
        status, gives_cookie = self._judge(scope, headers)
        socket_opens = scope["type"] == "websocket"

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                answer = MutableHeaders(scope=message)
                host = headers.get("host", "")
                for name, value in self.gate.headers(host, self.sources).items():
                    answer[name] = value
                if gives_cookie:
                    given = f"{self.gate.cookie}={self.gate.cookie_value}"
                    answer["set-cookie"] = (
                        f"{given}; Path=/; HttpOnly; SameSite=Strict; Max-Age=2592000"
                    )
            await send(message)

        # Pass it on, redirect a used ticket to the address with the token, or refuse.
        if status == 200:
            await self.app(scope, receive, sent)
        elif status == 303:
            await RedirectResponse(self.gate.address, status, {"cache-control": "no-store"})(
                scope, receive, send
            )
        elif socket_opens:
            await send({"type": "websocket.close", "code": 1008, "reason": "access denied"})
        else:
            await PlainTextResponse(_REFUSED, status)(scope, receive, sent)

    def _judge(self, scope: Scope, headers: Headers) -> tuple[int, bool]:
        """Return the status of the answer, and True if it sets the cookie."""
        gate = self.gate
        if len(headers.getlist("host")) != 1 or not gate.knows_host(headers["host"]):
            return 421, False
        if scope["type"] == "websocket":
            fine = "origin" in headers and gate.is_ours(headers)
            return (
                200 if fine and gate.has_cookie(headers) and gate.has_token(headers) else 403
            ), False
        if scope["method"] not in ("GET", "HEAD"):
            return 405, False
        query = QueryParams(scope["query_string"])
        token = query.get("token")
        ticket = query.get("ticket")
        if scope["path"] == "/" and ticket is not None:
            return (303 if gate.takes_ticket(ticket) else 403), False
        # Opened by hand, or by a link in a terminal's page.
        if scope["path"] == "/" and token is not None:
            return (200, True) if gate.is_token(token) else (403, False)
        return (200 if gate.is_ours(headers) and gate.has_cookie(headers) else 403), False
