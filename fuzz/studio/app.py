"""The server: one page, which contains its scripts and style, and one connection."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from importlib.resources import files

import msgspec
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from fuzz.player.one_file import filled, modules
from fuzz.studio.campaigns.watching import Watching
from fuzz.studio.gate import Gate, Guarded
from fuzz.studio.requests.folder import Folder
from fuzz.studio.requests.protocol import FULL, REQUESTS, SUBPROTOCOL, Begins, Given
from fuzz.studio.session import Session
from fuzz.studio.workers import Worker

MOST_PAGES = 64  # connected at the same time; more would mean a program out of control
_STYLES = ("studio.css", "campaign/campaign.css", "compare/compare.css")


def _page() -> tuple[bytes, str]:
    """Return the page, and the part of the policy that allows its scripts and styles."""
    folder = files("fuzz.studio") / "page"
    return filled(
        (folder / "index.html").read_text("utf-8"),
        "worldgen studio",
        styles="".join((folder / name).read_text("utf-8") for name in _STYLES),
        scripts=modules(folder, "#studio/"),
        start="#studio/start.js",
        data=msgspec.to_builtins(Given()),
    )


@dataclass(frozen=True)
class Studio:
    """A studio's settings.

    Args:
        folder: The folder that can be read and written.
        gate: Access control.
        named: Controllers from files, modules and programs that the page may run, as the command
            line takes them.
        file: Name, in the folder, of the world to open first.
    """

    folder: Folder
    gate: Gate
    named: tuple[str, ...] = ()
    file: str | None = None
    page: tuple[bytes, str] = field(default_factory=_page, repr=False)


def make_app(studio: Studio) -> ASGIApp:
    """Return the studio as an ASGI application, behind its gate."""
    # Requests are answered by separate processes; watching needs none.
    processes = {
        name: Worker(studio.folder, studio.named)
        for name in dict.fromkeys(kind.worker for kind in REQUESTS.values())
        if name != "server"
    }
    watching = Watching(
        studio.folder,
        studio.named,
        lambda: {file for worker in processes.values() for file in worker.loaded},
    )
    workers: dict[str, Worker | Watching] = {**processes, "server": watching}

    html, sources = studio.page

    # One file, because each request costs a round trip. No address reaches the file system.
    async def page(request: Request) -> Response:
        if request.url.path != "/":
            return Response("This page does not exist.\n", 404, media_type="text/plain")
        return Response(html, media_type="text/html")

    # The connections, up to the limit.
    pages: set[WebSocket] = set()
    begins = Begins(str(studio.folder.root), studio.file)

    async def connection(socket: WebSocket) -> None:
        if len(pages) >= MOST_PAGES:
            await socket.accept(SUBPROTOCOL)
            await socket.close(
                FULL, f"{MOST_PAGES} pages are open, which is the limit; close another one."
            )
            return
        pages.add(socket)
        try:
            await Session(socket, workers, begins).serve()
        finally:
            pages.remove(socket)

    # End the processes with the server.
    @contextlib.asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        yield
        for worker in workers.values():
            worker.end()

    routes = [WebSocketRoute("/socket", connection), Route("/{path:path}", page)]
    packed = Starlette(routes=routes, lifespan=life, middleware=[Middleware(GZipMiddleware)])
    return Guarded(packed, studio.gate, sources)
