"""The mark of a campaign that is to begin, in its memory.

Who takes it away has it end before it has begun.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

__all__ = ["beginning", "end_beginnings"]

# And the number of the process that waits for it: two studios may begin in one folder.
_MARK = "studio.begins."


@contextlib.contextmanager
def beginning(memory: Path) -> Iterator[Path]:
    """A mark for the time in which a campaign begins.

    Args:
        memory: A campaign's, which is there.
    """
    mark = memory / f"{_MARK}{os.getpid()}"
    mark.touch()
    try:
        yield mark
    finally:
        mark.unlink(missing_ok=True)


def end_beginnings(memory: Path) -> bool:
    """Has all that is about to begin in a campaign's memory end; whether there was any."""
    marks = list(memory.glob(f"{_MARK}*")) if memory.is_dir() else []
    for mark in marks:
        mark.unlink(missing_ok=True)
    return bool(marks)
