"""Keep standard output for worldgen's own results, whatever a user's code prints.

While a command runs, ``sys.stdout`` and descriptor 1 lead to standard error. So what a controller
prints, what a C library writes, and what a child process inherits never mixes with results. Those
go to :func:`results`, which only worldgen's own code knows.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

_STDOUT = 1
_STDERR = 2
# Names of standard output in the file system.
_NAMES = ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")

# The stream for results; ``None`` while ``sys.stdout`` is that stream.
_results: TextIO | None = None
# A descriptor of the real standard output; ``None`` while it is 1.
_descriptor: int | None = None


def results() -> TextIO:
    """Return the stream for results."""
    return sys.stdout if _results is None else _results


@contextlib.contextmanager
def results_to(stream: TextIO) -> Iterator[None]:
    """Send results inside this block to another stream."""
    global _results  # noqa: PLW0603 - one process has one standard output
    before = _results
    _results = stream
    try:
        yield
    finally:
        _results = before


@contextlib.contextmanager
def only_results_on_stdout() -> Iterator[None]:
    """Send everything else that is written to ``sys.stdout`` inside this block to stderr."""
    if _results is not None:
        yield
        return
    with results_to(sys.stdout), contextlib.redirect_stdout(sys.stderr):
        yield


def claim_stdout() -> None:
    """Take the process's standard output for results, until the process ends.

    Descriptor 1 leads to standard error from then on, and so does ``sys.__stdout__``. It is never
    restored: what C libraries and exit handlers have not written yet is written last. If
    ``sys.stdout`` is not descriptor 1, as in a test, this does nothing.
    """
    global _descriptor  # noqa: PLW0603 - one process has one standard output
    out = sys.stdout
    if out is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
        return
    try:
        if out.fileno() != _STDOUT:
            return
    except (AttributeError, OSError, ValueError):
        return
    out.flush()
    _descriptor = os.dup(_STDOUT)
    data = open(_descriptor, "wb")  # noqa: PTH123, SIM115 - it stays open
    sys.stdout = io.TextIOWrapper(data, out.encoding, out.errors, line_buffering=out.isatty())
    try:
        os.dup2(_STDERR, _STDOUT)
    except OSError:
        # Standard error is closed.
        os.dup2(os.open(os.devnull, os.O_WRONLY), _STDOUT)


def release_stdout() -> None:
    """Print no more results: whatever is still printed, as by exit handlers, goes to stderr."""
    if _descriptor is not None:
        sys.stdout = sys.stderr


def opened_as(path: Path) -> Path:
    """Return the name under which this process opens a file: ``/dev/stdout`` may lead elsewhere."""
    if _descriptor is not None and str(path) in _NAMES:
        results().flush()
        return Path(f"/dev/fd/{_descriptor}")
    return path
