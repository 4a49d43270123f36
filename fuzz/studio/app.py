"""The server: one page, its files, and one connection."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from importlib.resources import files
from importlib.resources.abc import Traversable

import msgspec
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from fuzz.studio.campaigns.watching import Watching
from fuzz.studio.gate import IMPORTS, Gate, Guarded
from fuzz.studio.requests.folder import Folder
from fuzz.studio.requests.protocol import FULL, REQUESTS, SUBPROTOCOL, Begins, Given
from fuzz.studio.session import Session
from fuzz.studio.workers import Worker

MOST_PAGES = 64  # connected at the same time; more would mean a program out of control
_KINDS = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
}


def _parts() -> dict[str, bytes]:
    """Return the page's files by address.

    Addresses never lead to any other file.
    """
    found: dict[str, bytes] = {}
    for address, package in (("studio", "fuzz.studio"), ("player", "fuzz.player")):
        found |= _parts_below(files(package) / "page", f"/{address}")
    page = found["/studio/index.html"].replace(b"@@IMPORTS@@", IMPORTS.encode("ascii"))
    page = page.replace(b"@@GIVEN@@", msgspec.json.encode(Given()))
    return found | {"/": page, "/studio/index.html": page}


def _parts_below(folder: Traversable, address: str) -> dict[str, bytes]:
    """Return the files of a folder and of the folders in it that a page may load, by address."""
    found: dict[str, bytes] = {}
    for part in folder.iterdir():
        if part.is_dir():
            found |= _parts_below(part, f"{address}/{part.name}")
        elif part.name.endswith(tuple(_KINDS)):
            found[f"{address}/{part.name}"] = part.read_bytes()
    return found


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
    parts: dict[str, bytes] = field(default_factory=_parts, repr=False)


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

    # The page and its files. Unknown addresses never reach the file system.
    async def part(request: Request) -> Response:
        data = studio.parts.get(request.url.path)
        if data is None:
            return Response("This page does not exist.\n", 404, media_type="text/plain")
        ending = "." + request.url.path.rpartition(".")[2] if request.url.path != "/" else ".html"
        return Response(data, media_type=_KINDS[ending])

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

    routes = [WebSocketRoute("/socket", connection), Route("/{path:path}", part)]
    return Guarded(Starlette(routes=routes, lifespan=life), studio.gate)
