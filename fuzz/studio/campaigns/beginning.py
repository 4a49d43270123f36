"""Mark a campaign that is about to begin, in its campaign store.

Removing the mark ends the campaign before it has begun.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

__all__ = ["beginning", "end_beginnings"]

# The number of the waiting process follows: two studios may begin a campaign in one folder.
_MARK = "studio.begins."


@contextlib.contextmanager
def beginning(memory: Path) -> Iterator[Path]:
    """Keep a mark while a campaign is about to begin.

    Args:
        memory: The campaign's store, which must exist.
    """
    mark = memory / f"{_MARK}{os.getpid()}"
    mark.touch()
    try:
        yield mark
    finally:
        mark.unlink(missing_ok=True)


def end_beginnings(memory: Path) -> bool:
    """End all campaigns that are about to begin in a store; return True if there were any."""
    marks = list(memory.glob(f"{_MARK}*")) if memory.is_dir() else []
    for mark in marks:
        mark.unlink(missing_ok=True)
    return bool(marks)
