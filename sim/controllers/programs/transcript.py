"""Transcripts: the lines that a program was sent in an episode, to send again under a debugger."""

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
    """Write the lines that a program is sent to a file.

    If an episode is interrupted, the file has the lines up to then.

    Args:
        controller: The controller's name.
        out: The file; ``None`` writes nothing.
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
            "{option} records the lines sent to a program, and {controller!r} is not a program",
            "for a Python class take --controller 'cmd:python -m sim.host {controller}'",
            at_terminal=True,
            option="--transcript",
            controller=controller,
        )
    check_output(out, force)
    with out.open("wb") as stream, found.transcript(stream):
        yield
