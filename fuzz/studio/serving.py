"""Serves a studio until Ctrl-C."""

from __future__ import annotations

import contextlib
import socket
import webbrowser
from collections.abc import Callable

import uvicorn

from fuzz.studio.app import MOST_MESSAGE, Studio, make_app
from worldgen.errors import InvalidParameter

__all__ = ["bind", "serve"]


def bind(host: str, port: int | None) -> socket.socket:
    """A socket at a port; where none is named, at the studio's usual one, or any other that is free.

    Raises:
        InvalidParameter: If the host is not this machine's, or the port is taken.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    for number in (USUAL_PORT, 0) if port is None else (port,):
        try:
            listener.bind((host, number))
        except OSError as error:
            reason = error.strerror or str(error)
            continue
        listener.listen(64)
        return listener
    listener.close()
    raise InvalidParameter(f"{host}, port {port}: {reason}; give another --host or --port")


USUAL_PORT = 8642
"""Where the page finds the server again, and what it kept of a drawing, after a new start."""


def serve(studio: Studio, listener: socket.socket, *, browse: bool, said: Callable[[str], None]) -> None:
    """Serves until Ctrl-C.

    Args:
        studio: What.
        listener: Where.
        browse: Whether to open the address in the browser.
        said: Called with sentences for the person at the terminal.
    """
    config = uvicorn.Config(
        make_app(studio),
        log_level="warning",
        access_log=False,
        server_header=False,
        date_header=False,
        ws="websockets-sansio",
        ws_max_size=MOST_MESSAGE,
        timeout_graceful_shutdown=1,
        lifespan="on",
    )
    said(f"studio of {studio.folder.root}: open {studio.gate.address}")
    said("Ctrl-C ends it; what you have saved stays.")
    if browse:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(studio.gate.address)
    with contextlib.suppress(KeyboardInterrupt):  # the way to end it
        uvicorn.Server(config).run(sockets=[listener])
