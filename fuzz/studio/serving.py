"""Serves a studio until Ctrl-C."""

from __future__ import annotations

import contextlib
import errno
import socket
import webbrowser
from collections.abc import Callable

import uvicorn

from fuzz.studio.app import Studio, make_app
from fuzz.studio.limits import MOST_MESSAGE
from worldgen.errors import InvalidParameter, Message

__all__ = ["USUAL_PORT", "bind", "called", "serve"]


def bind(host: str, port: int | None) -> socket.socket:
    """A socket at a port; 0 is any that is free.

    Where none is named, the studio's usual one, or any that is free.

    Raises:
        InvalidParameter: If the host is not this machine's, or the port is taken.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for number in (USUAL_PORT, 0) if port is None else (port,):
        listener = socket.socket(
            family, socket.SOCK_STREAM
        )  # one that is bound cannot be bound again
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, number))
            listener.listen(64)
        except OSError as error:
            fault = _fault(host, number, error)
        except (TypeError, UnicodeError):  # Python's, of a name that no host can have
            fault = Message(
                "not-a-host",
                "no host can be called {host!r}",
                "give another --host",
                at_terminal=True,
                host=host,
            )
        else:
            return listener
        listener.close()
    raise InvalidParameter.of(fault)


def _fault(host: str, port: int, error: OSError) -> Message:
    """Why nobody can listen there, and the way out."""
    if error.errno == errno.EADDRINUSE:
        return Message(
            "port-taken",
            "port {port} of {host} is taken, by another studio maybe",
            "end that, or give another --port; with --port 0 it is any that is free",
            at_terminal=True,
            host=host,
            port=port,
        )
    if error.errno in (errno.EACCES, errno.EPERM):
        return Message(
            "port-not-allowed",
            "port {port} of {host} is not for everybody",
            "give a --port from 1024 on, or 0 for any that is free",
            at_terminal=True,
            host=host,
            port=port,
        )
    if error.errno == errno.EADDRNOTAVAIL:
        return Message(
            "not-our-address",
            "{host} is no address of this machine",
            "give another --host, or none for this machine alone",
            at_terminal=True,
            host=host,
        )
    reason = error.strerror or str(error)
    return Message(
        "cannot-listen",
        "{host}: {reason}",
        "give another --host or --port",
        at_terminal=True,
        host=host,
        reason=reason,
    )


def called(host: str, listener: socket.socket) -> str:
    """The host as a browser writes it: 127.0.0.1 for 127.1, a name in small letters."""
    with contextlib.suppress(OSError, UnicodeError):
        if host:  # all of this machine's addresses, where it is empty
            socket.getaddrinfo(host, None, flags=socket.AI_NUMERICHOST)
        return str(listener.getsockname()[0])
    return host.lower()


USUAL_PORT = 8642
"""Where the page finds the server again, and what it kept of a drawing, after a new start."""


def serve(
    studio: Studio, listener: socket.socket, *, browse: bool, said: Callable[[str], None]
) -> None:
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
    said("Ctrl-C ends it; what you have saved stays.")
    if browse:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(studio.gate.address_for_once())
    with contextlib.suppress(KeyboardInterrupt):  # the way to end it
        uvicorn.Server(config).run(sockets=[listener])
