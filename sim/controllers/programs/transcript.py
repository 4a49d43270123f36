"""Transcripts: what a program was sent in an episode, to be sent to it again under a debugger."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from sim.controllers import CONTROLLERS, ProcessController
from worldgen.errors import InvalidParameter
from worldgen.files.whole import check_output

__all__ = ["transcribed"]


@contextlib.contextmanager
def transcribed(controller: str, out: Path | None, *, force: bool = False) -> Iterator[None]:
    """Write to ``out`` what a program is sent.

    An episode that is broken off leaves what was sent until then.

    Args:
        controller: Its name.
        out: The file; nothing is written if it is ``None``.
        force: Whether the file may be overwritten.

    Raises:
        InvalidParameter: If the controller is not a program.
        OutputError: If the file exists, or cannot be written.
    """
    if out is None:
        yield
        return
    found = CONTROLLERS.get(controller)
    if not isinstance(found, ProcessController):
        raise InvalidParameter(
            "not-a-program",
            "{option} is what a program is sent, and {controller!r} is not one",
            "for a Python class take --controller 'cmd:python -m sim.host {controller}'",
            at_terminal=True,
            option="--transcript",
            controller=controller,
        )
    check_output(out, force)
    with out.open("wb") as stream, found.transcript(stream):
        yield
