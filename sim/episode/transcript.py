"""Write transcripts: the lines sent to a program in an episode, to send again under a debugger."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.programs.process import ProcessController
from worldgen.errors import InvalidParameter
from worldgen.files.whole import check_output


def check_transcript(robots: Sequence[object], out: Path | None) -> None:
    """Refuse to write a transcript for several robots, each of which has its own program.

    Raises:
        InvalidParameter: If one is requested and there are several robots.
    """
    if out is not None and len(robots) > 1:
        raise InvalidParameter(
            "transcript-of-several",
            "{option} records the lines sent to one program, but the world has {count} robots",
            "leave it out",
            at_terminal=True,
            option="--transcript",
            count=len(robots),
        )


@contextlib.contextmanager
def transcribed(controller: str, out: Path | None, *, force: bool = False) -> Iterator[None]:
    """Write the lines that a program is sent to a file.

    If an episode is interrupted, the file has the lines so far.

    Args:
        controller: The controller's name.
        out: The file; ``None`` writes nothing.
        force: True if the file may be overwritten.

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
            "{option} records the lines sent to a program, but {controller!r} is not a program",
            "for a Python class, use --controller 'cmd:python -m sim.host {controller}'",
            at_terminal=True,
            option="--transcript",
            controller=controller,
        )
    check_output(out, force)
    with out.open("wb") as stream, found.transcript(stream):
        yield
