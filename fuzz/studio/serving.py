"""Serve a studio until Ctrl-C."""

from __future__ import annotations

import contextlib
import errno
import socket
import webbrowser
from collections.abc import Callable

import uvicorn

from fuzz.studio.app import Studio, make_app
from fuzz.studio.requests.limits import MOST_MESSAGE
from worldgen.errors import InvalidParameter, Message


def bind(host: str, port: int | None) -> socket.socket:
    """Return a socket at a port; 0 means any free port.

    If no port is given, use the studio's default port, or any that is free.

    Raises:
        InvalidParameter: If the host is not this machine's, or the port is taken.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for number in (USUAL_PORT, 0) if port is None else (port,):
        # Use a new socket for each attempt: a socket can be bound only once.
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, number))
            listener.listen(64)
        except OSError as error:
            fault = _fault(host, number, error)
        except (TypeError, UnicodeError):  # raised by Python for a name that no host can have
            fault = Message(
                "not-a-host",
                "{host!r} cannot be the name of a host",
                "choose another --host",
                at_terminal=True,
                host=host,
            )
        else:
            return listener
        listener.close()
    raise InvalidParameter.of(fault)


def _fault(host: str, port: int, error: OSError) -> Message:
    """Return the reason that the server cannot listen there, and the remedy."""
    if error.errno == errno.EADDRINUSE:
        return Message(
            "port-taken",
            "port {port} of {host} is taken, perhaps by another studio",
            "stop it, or choose another --port; --port 0 selects any free port",
            at_terminal=True,
            host=host,
            port=port,
        )
    if error.errno in (errno.EACCES, errno.EPERM):
        return Message(
            "port-not-allowed",
            "port {port} of {host} requires special privileges",
            "choose a --port of at least 1024, or 0 for any free port",
            at_terminal=True,
            host=host,
            port=port,
        )
    if error.errno == errno.EADDRNOTAVAIL:
        return Message(
            "not-our-address",
            "{host} is not an address of this machine",
            "choose another --host, or omit it to serve only this machine",
            at_terminal=True,
            host=host,
        )
    reason = error.strerror or str(error)
    return Message(
        "cannot-listen",
        "{host}: {reason}",
        "choose another --host or --port",
        at_terminal=True,
        host=host,
        reason=reason,
    )


def called(host: str, listener: socket.socket) -> str:
    """Return the host as a browser writes it: 127.0.0.1 for 127.1, a name in lower case."""
    with contextlib.suppress(OSError, UnicodeError):
        if host:  # an empty host means all addresses of this machine
            socket.getaddrinfo(host, None, flags=socket.AI_NUMERICHOST)
        return str(listener.getsockname()[0])
    return host.lower()


USUAL_PORT = 8642
"""Default port, so that after a restart the page finds the server and its unsaved drawing."""


def serve(
    studio: Studio, listener: socket.socket, *, browse: bool, said: Callable[[str], None]
) -> None:
    """Serve until Ctrl-C.

    Args:
        studio: The studio.
        listener: A bound socket.
        browse: Open the address in the browser.
        said: Called with each message for the user at the terminal.
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
    said("Press Ctrl-C to stop. Saved worlds stay.")
    if browse:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(studio.gate.address_for_once())
    with contextlib.suppress(KeyboardInterrupt):  # the normal end
        uvicorn.Server(config).run(sockets=[listener])
