"""Who is let in: the browser that was given the token, from the page of this very server, and nobody else.

A page of another site can make a browser send requests here, and can make its own name lead to this
machine (DNS rebinding). So every request must say a host that is this server's, a request of a page
must come from this server's own page, and all but the first must bring the cookie that only the
token gives. Cookies know no ports: a browser shows ours to any other server of this machine that it
    visits. So the cookie opens the page's parts alone, which are no secret, and
the connection needs the token itself, which the page keeps where only pages of this very port can
read it.
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

from fuzz.player.one_file import policy_source

__all__ = ["IMPORTS", "LOOPBACK", "SUBPROTOCOL", "Gate", "Guarded"]

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
SUBPROTOCOL = "worldgen-studio"
IMPORTS = '{"imports":{"#player/":"/player/"}}'
"""The page's import map: where a browser finds what a module imports as ``#player/dom.js``."""
_IMPORTS_SOURCE = policy_source(IMPORTS)
_ANY = ("0.0.0.0", "::")
_UNSAID = 80  # the port that browsers leave out
_REFUSED = (
    "This is a worldgen studio, and it does not know you.\n\nOpen the whole address that `worldgen "
    "studio` has "
    "printed, with its token. After a new start of the studio that is a new one.\n"
)


@dataclass(frozen=True)
class Gate:
    """What lets a request in.

    Args:
        host: Name or address that the server is bound to, as a browser writes it.
        port: Its port.
        token: What the address that is opened first must hold; a fresh one where left out.
    """

    host: str
    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)
    _tickets: set[str] = field(default_factory=set, init=False, repr=False, compare=False)

    @property
    def cookie(self) -> str:
        """Name of the cookie; servers on other ports have their own."""
        return f"worldgen-studio-{self.port}"

    @property
    def cookie_value(self) -> str:
        """What the cookie holds: it is got from the token, and does not tell it."""
        return hmac.new(self.token.encode(), b"cookie", hashlib.sha256).hexdigest()

    @property
    def address(self) -> str:
        """The address to open, with the token."""
        return f"{self._place}/?token={self.token}"

    def address_for_once(self) -> str:
        """An address that leads to the other, once.

        The arguments of a browser's process are everybody's to read.
        """
        ticket = secrets.token_urlsafe(32)
        self._tickets.add(ticket)
        return f"{self._place}/?ticket={ticket}"

    def takes_ticket(self, said: str) -> bool:
        """Whether this is a ticket that nobody has used; from now on somebody has."""
        if said not in self._tickets:
            return False
        self._tickets.remove(said)
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

    def knows_host(self, said: str) -> bool:
        """Whether a Host header names this server, and not a name that somebody has made to lead here."""
        name = said.removesuffix(f":{self.port}")
        if name == said and self.port != _UNSAID:
            return False
        if name in (self.host, f"[{self.host}]"):
            return True
        if self.host in _ANY:  # then any of this machine's addresses: no address can be rebound
            return name in (*LOOPBACK, socket.gethostname()) or _is_address(name)
        return name in LOOPBACK and self.host in ("127.0.0.1", "localhost", "::1")

    def is_ours(self, headers: Headers) -> bool:
        """Whether a request comes from a page of this server, or from no page at all."""
        origin = headers.get("origin")
        if origin is not None and origin != f"http://{headers.get('host', '')}":
            return False
        return headers.get("sec-fetch-site", "none") in ("none", "same-origin")

    def has_cookie(self, headers: Headers) -> bool:
        """Whether a request brings the cookie that the token gives."""
        jar: SimpleCookie = SimpleCookie()
        try:
            jar.load(headers.get("cookie", ""))
        except CookieError:
            return False
        return self.cookie in jar and _are_same(jar[self.cookie].value, self.cookie_value)

    def has_token(self, headers: Headers) -> bool:
        """Whether a WebSocket brings the token.

        As the second of the subprotocols that it offers.
        """
        offered = [name.strip() for name in headers.get("sec-websocket-protocol", "").split(",")]
        return len(offered) == 2 and offered[0] == SUBPROTOCOL and self.is_token(offered[1])

    def is_token(self, said: str) -> bool:
        """Whether this is the token; takes as long whatever is said."""
        return _are_same(said, self.token)

    def headers(self, said_host: str) -> dict[str, str]:
        """Return what every answer tells the browser.

        No script or style comes from other hosts, and none is in the page's text but the import
        map.
        """
        policy = (
            f"default-src 'none'; script-src 'self' {_IMPORTS_SOURCE}; style-src 'self'; img-src "
            f"'self' data: blob:; "
            f"connect-src 'self' ws://{said_host}; base-uri 'none'; form-action 'none'; "
            f"frame-ancestors 'none'"
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


def _are_same(said: str, wanted: str) -> bool:
    return hmac.compare_digest(said.encode("utf-8", "replace"), wanted.encode())


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.removeprefix("[").removesuffix("]"))
    except ValueError:
        return False
    return True


class Guarded:
    """An application behind a gate."""

    def __init__(self, app: ASGIApp, gate: Gate) -> None:
        self.app = app
        self.gate = gate

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Lets a request through, or refuses it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        status, gives_cookie = self._judge(scope, headers)
        socket_opens = scope["type"] == "websocket"

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                answer = MutableHeaders(scope=message)
                for name, value in self.gate.headers(headers.get("host", "")).items():
                    answer[name] = value
                if gives_cookie:
                    given = f"{self.gate.cookie}={self.gate.cookie_value}"
                    answer["set-cookie"] = (
                        f"{given}; Path=/; HttpOnly; SameSite=Strict; Max-Age=2592000"
                    )
            await send(message)

        if status == 200:
            await self.app(scope, receive, sent)
        elif status == 303:
            await RedirectResponse(self.gate.address, status, {"cache-control": "no-store"})(
                scope, receive, send
            )
        elif socket_opens:
            await send({"type": "websocket.close", "code": 1008, "reason": "not let in"})
        else:
            await PlainTextResponse(_REFUSED, status)(scope, receive, sent)

    def _judge(self, scope: Scope, headers: Headers) -> tuple[int, bool]:
        """The status of the answer, and whether it brings the cookie."""
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
        asked = QueryParams(scope["query_string"])
        token = asked.get("token")
        ticket = asked.get("ticket")
        if scope["path"] == "/" and ticket is not None:
            return (303 if gate.takes_ticket(ticket) else 403), False
        if (
            scope["path"] == "/" and token is not None
        ):  # opened by hand, or by a link in a terminal's page
            return (200, True) if gate.is_token(token) else (403, False)
        return (200 if gate.is_ours(headers) and gate.has_cookie(headers) else 403), False
