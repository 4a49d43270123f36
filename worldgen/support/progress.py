"""Report slow work: nothing for two seconds, then a line every few seconds, or one live line.

Any code can wrap slow work in :func:`working`. Only the command line installs a :class:`Display`;
in library use the same messages go to the logger ``worldgen`` at level INFO, so nothing is printed
unless logging is set up for it.

Do not use another live display (a ``rich`` progress bar or status) inside :func:`working`: the two
would overwrite each other. :meth:`Work.count` shows numbers, rate and time left.
"""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import parent_process

from worldgen.support.plain_text import lasting, shown

_clock = time.monotonic
_LOGGER = logging.getLogger("worldgen")
# Seconds of silence before the first line.
_FIRST = 2.0
# Seconds between two lines in a log, at first and in longer work.
_EVERY = 5.0
_LATER = 15.0
# Work that has taken this many seconds counts as long.
_LONG = 60.0
# Work that took this many seconds gets a line at its end.
_WORTH_SAYING = 1.0
# Seconds between checks of the clock, which are also redraws of the live line.
_REDRAW = 0.25
# Seconds between checks of whether the thread has drawn its line, and how many of these checks to
# make in case standard error blocks.
_LOOK = 0.001
_PATIENT_LOOKS = 100
_CLEAR = "\r\x1b[K"
# Columns of a terminal that does not report its width.
_WIDTH = 80


class Work:
    """A piece of slow work in progress.

    Args:
        message: The activity, such as ``"loading the simulator"``.
        clock: Returns seconds.
        often: See :func:`working`.
    """

    def __init__(
        self, message: str, clock: Callable[[], float] = time.monotonic, *, often: bool = False
    ) -> None:
        self.message = message
        self.often = often
        self.begun = clock()
        self._clock = clock
        self._detail: str | Callable[[], str] = ""
        self._first: tuple[float, int] | None = None

    def say(self, detail: str | Callable[[], str]) -> None:
        """Set the text after the message.

        A function is called only when a line is printed, in another thread.
        """
        self._detail = detail

    def count(self, done: int, total: int | None = None, noun: str = "") -> None:
        """Set the detail to ``120 of 10,000 worlds (40/s, 4 min left)``.

        It is cheap enough to call for every item.
        """
        if self._first is None:
            self._first = (self._clock(), done)
        self._detail = lambda: self._counted(done, total, noun)

    def text(self) -> str:
        """Return the message with its detail, on one line."""
        detail = self._detail if isinstance(self._detail, str) else self._detail()
        return shown(f"{self.message}: {detail}" if detail else self.message)

    def _counted(self, done: int, total: int | None, noun: str) -> str:
        of = "" if total is None else f" of {total:,}"
        words = f"{done:,}{of} {noun}".rstrip()
        begun, before = self._first or (self.begun, 0)
        seconds = self._clock() - begun
        if seconds <= 0.0 or done <= before:
            return words
        rate = (done - before) / seconds
        left = "" if total is None else f", {lasting((total - done) / rate)} left"
        return f"{words} ({rate:,.0f}/s{left})" if rate >= 10.0 else f"{words} ({rate:.2g}/s{left})"


class _LoggedWork(Work):
    """Work in library use, which logs its details, at most every few seconds."""

    _logged = 0.0

    def count(self, done: int, total: int | None = None, noun: str = "") -> None:
        """See :meth:`Work.count`."""
        super().count(done, total, noun)
        now = self._clock()
        if now - max(self._logged, self.begun) >= _EVERY:
            self._logged = now
            _LOGGER.info("%s", self.text())


class Display:
    """Prints the work in progress to standard error, from its own thread.

    The thread never holds a lock, so that Ctrl-C in the main thread can come at any time.

    Args:
        terminal: True if a line can be redrawn in place; by default, if standard error is a
            terminal.
        verbosity: -1 prints nothing; 1 also prints when each piece of work begins and ends.
        silent: True to print no progress, whatever the verbosity.
        clock: Returns seconds.
    """

    def __init__(
        self,
        *,
        terminal: bool | None = None,
        verbosity: int = 0,
        silent: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.verbosity = verbosity
        self.silent = silent
        self._terminal = terminal
        self._clock = clock
        self._works: list[Work] = []
        self._drawn = False
        self._ticking = False
        self._is_paused = False
        self._spoken = clock()
        self._patience = _FIRST
        self._over: threading.Event | None = None
        self._thread: threading.Thread | None = None

    def begin(self, message: str, *, often: bool = False) -> Work:
        """Start a piece of work inside those in progress; see :func:`working`."""
        work = Work(message, self._clock, often=often)
        if self.verbosity > 0 and not self.silent and not often:
            self._write(f"{work.text()} ...\n")
        self._works.append(work)
        if self._over is None and self.verbosity >= 0 and not self.silent:
            self._over = threading.Event()
            self._thread = threading.Thread(target=self._watch, args=(self._over,), daemon=True)
            self._thread.start()
        return work

    def end(self, work: Work) -> None:
        """End a piece of work; the live line disappears with the outermost."""
        with contextlib.suppress(ValueError):
            self._works.remove(work)
        if not self._works:
            self.clear()
        if self.verbosity > 0 and not self.silent and not work.often:
            self._write(f"{shown(work.message)}: done in {lasting(self._clock() - work.begun)}\n")

    def close(self) -> None:
        """Stop the thread and clear the live line."""
        over = self._over
        thread = self._thread
        self._over = self._thread = None
        if over is not None and thread is not None:
            over.set()
            thread.join(1.0)
        self.clear()

    def clear(self) -> None:
        """Clear the live line, because something else is about to be printed."""
        # The thread may be drawing at this moment; that takes microseconds.
        for _ in range(_PATIENT_LOOKS):
            if not self._ticking:
                break
            time.sleep(_LOOK)
        if self._drawn:
            self._drawn = False
            self._put(_CLEAR)

    def spoke(self) -> None:
        """Clear the live line and restart the silence.

        A message is being printed.
        """
        self._spoken = self._clock()
        self.clear()

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Draw nothing inside this block, in which somebody else uses the terminal."""
        before = self._is_paused
        self._is_paused = True
        self.clear()
        try:
            yield
        finally:
            self._is_paused = before
            self.spoke()

    def warn(self, message: str) -> None:
        """Print a warning, unless the command line is quiet."""
        if self.verbosity >= 0:
            self._write(f"warning: {shown(message)}\n")

    def tick(self) -> None:
        """Check the clock and print what is due; the thread calls this a few times a second."""
        works = tuple(self._works)
        if not works or self.verbosity < 0 or self.silent or self._is_paused:
            return
        now = self._clock()
        terminal = self._is_terminal()
        due = now - self._spoken >= self._patience
        if not due and not (terminal and self._drawn):
            return
        # Show only the innermost details: one line has no room for more.
        parts = list(
            dict.fromkeys([*(shown(work.message) for work in works[:-1]), works[-1].text()])
        )
        spent = now - works[0].begun
        # This is short work after other short work.
        took = f" ({lasting(spent)})" if spent >= _WORTH_SAYING else ""
        if terminal:
            self._drawn = True
            self._put(_CLEAR + _fitted(parts, took, _columns() - 1))
        else:
            self._write(f"{'; '.join(parts)}{took}\n")
            self._patience = _LATER if spent > _LONG else _EVERY

    def _watch(self, over: threading.Event) -> None:
        while not over.wait(_REDRAW):
            # A failure to draw must never end the work.
            self._ticking = True
            with contextlib.suppress(Exception):
                self.tick()
            self._ticking = False

    def _write(self, text: str) -> None:
        self.spoke()
        self._put(text)

    def _put(self, text: str) -> None:
        # Standard error may be closed, a full pipe's end, or replaced by a test.
        with contextlib.suppress(OSError, ValueError, AttributeError):
            sys.stderr.write(text)
            sys.stderr.flush()

    def _is_terminal(self) -> bool:
        if self._terminal is not None:
            return self._terminal
        try:
            return sys.stderr.isatty() and os.environ.get("TERM") != "dumb"
        except (AttributeError, ValueError):
            return False


_display: Display | None = None


@contextmanager
def working(message: str, *, often: bool = False) -> Iterator[Work]:
    """Report the activity if it takes a while; the body may add details.

    Args:
        message: The activity, such as ``"loading the simulator"``.
        often: True if this is done thousands of times, so that ``--verbose`` and the log skip it.
    """
    display = _display
    if display is None:
        _LOGGER.log(logging.DEBUG if often else logging.INFO, "%s", message)
        yield _LoggedWork(message, _clock) if _LOGGER.isEnabledFor(logging.INFO) else Work(message)
        return
    work = display.begin(message, often=often)
    try:
        yield work
    finally:
        display.end(work)


@contextmanager
def display_on_stderr() -> Iterator[Display]:
    """Show the messages of :func:`working` inside this block on standard error.

    ``WORLDGEN_PROGRESS=off`` shows none of it.
    """
    global _display  # noqa: PLW0603 - one process has one standard error
    before = _display
    display = _display = Display(
        silent=os.environ.get("WORLDGEN_PROGRESS", "").lower() in ("off", "0", "no")
    )
    try:
        yield display
    finally:
        display.close()
        _display = before


def set_verbosity(verbosity: int) -> None:
    """Make the command line quiet (-1), usual (0) or verbose (1).

    Without a command line this does nothing.
    """
    if _display is not None:
        _display.verbosity = verbosity


def is_quiet() -> bool:
    """Return True if the command line was told to print only results and errors."""
    return _display is not None and _display.verbosity < 0


def is_verbose() -> bool:
    """Return True if the command line was asked for every detail."""
    return _display is not None and _display.verbosity > 0


def spoke() -> None:
    """Tell the display that a message is about to be printed."""
    if _display is not None:
        _display.spoke()


@contextmanager
def no_progress() -> Iterator[None]:
    """Show no progress inside this block, because the user is being asked something."""
    with contextlib.nullcontext() if _display is None else _display.paused():
        yield


_said: set[str] = set()


def say_once(message: str) -> None:
    """Print a warning on the command line's standard error, or log it in library use.

    Worker processes stay silent.
    """
    if message in _said or parent_process() is not None:
        return
    _said.add(message)
    if _display is None:
        _LOGGER.warning("%s", message)
    else:
        _display.warn(message)


def _forget() -> None:
    global _display  # noqa: PLW0603 - a forked child has no such thread, and its parent's terminal is not its own
    _display = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


def _columns() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or _WIDTH
    except (OSError, ValueError, AttributeError):
        return _WIDTH


def _fitted(parts: list[str], end: str, columns: int) -> str:
    """Return one line for a terminal.

    It drops the outer parts if it would be too long, then truncates.
    """
    from rich.cells import cell_len, set_cell_size  # noqa: PLC0415 - only when a live line is drawn

    for first in range(len(parts)):
        line = "; ".join(parts[first:]) + end
        if cell_len(line) <= columns:
            return line
    room = columns - cell_len(f"...{end}")
    return (
        set_cell_size(parts[-1], room) + f"...{end}"
        if room > 0
        else set_cell_size(parts[-1], max(columns, 0))
    )
