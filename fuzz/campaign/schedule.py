"""Divide a campaign's time into start-up, search and shrinking."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Iterator
from typing import NamedTuple

from fuzz.unit.deadline import NO_DEADLINE, Deadline, now

# Share of the time after which shrinking takes precedence.
_SEARCH = 0.75
# Share of the time after which the search ends, even if nothing is left to shrink.
_SEARCH_ON = 0.9
# Share of the remaining time in which a failure can still be proved.
_PROVE = 0.5
# Share of the time for the search if there is no shrinking.
_UNSHRUNK = 0.97
# Share of the work during the search that goes to the first failure of each group.
_SHRINKING = 0.25
# Share of the time for shrinking one failure while the search continues.
_ONE_OF = 0.1
# Seconds for shrinking a failure.
_LEAST = 0.05
# Share of a failure's time for proving the shrunk result.
_TO_CONFIRM = 0.3


class Beginning(NamedTuple):
    """The beginning of a command.

    Args:
        at: The time, by ``time.monotonic``.
        own: Seconds since then that the controller's own code took.
    """

    at: float
    own: float = 0.0


class Schedule:
    """The clock of a campaign.

    Time begins with the first work that no earlier run did.

    Start-up does not count, because on a slow machine it could use up a short budget. The time of
    the controller's own code counts in full.

    Args:
        seconds: Time for search and shrinking together; ``None`` for no limit.
        shrinks: Whether failures are shrunk.
        began: When the command began; now if omitted.
    """

    def __init__(
        self, seconds: float | None, *, shrinks: bool = True, began: Beginning | None = None
    ) -> None:
        self._seconds = seconds
        self._shrinks = shrinks
        self._began, self._own = began or Beginning(time.monotonic())
        self._ready = self._last = math.inf
        self._search = self._shrinking = 0.0  # s
        self.start_up = 0.0  # s

    @property
    def is_unlimited(self) -> bool:
        """True if there is no time limit."""
        return self._seconds is None

    @property
    def is_ready(self) -> bool:
        """True once work can begin."""
        return self._ready < math.inf

    @property
    def search_comes_first(self) -> bool:
        """True until the search's share of the time is over.

        After that the search only continues if there is nothing to shrink.
        """
        return self._left(self._share_to_search(urgent=True)) > 0.0

    @property
    def may_search(self) -> bool:
        """True if a unit may still begin."""
        return self._left(self._share_to_search(urgent=False)) > 0.0

    def begin(self, own: float = 0.0) -> None:
        """Start the clock: everything is loaded.

        Args:
            own: Seconds of that spent in the controller's own code.
        """
        self._ready = time.monotonic()
        self._own += own
        self.start_up = self._ready - self._began

    def is_over(self, grace: float = 0.0) -> bool:
        """Return True if the time, plus ``grace`` seconds, is over."""
        return self._seconds is not None and self._left() + grace <= 0.0

    def deadline(self, *, shrinks: bool = True) -> Deadline:
        """Return when a unit must end.

        This is the end of the search's share of the time, or later if some of it is left.

        Args:
            shrinks: False if nothing waits to be shrunk: then the unit gets that time, too.
        """
        if self._seconds is None:
            return NO_DEADLINE
        share = self._share_to_search(urgent=shrinks and self.search_comes_first)
        at = now()
        prove = share + _PROVE * (1.0 - share)
        return Deadline(at + self._left(share), at + self._left(prove))

    def shrank_enough(self) -> bool:
        """Return True if shrinking has had its share of the time and the search is next."""
        if self._seconds is None:
            return False
        return self._shrinking > _SHRINKING * (self._search + self._shrinking)

    def for_shrinking(self, failures: int, workers: int) -> tuple[float | None, float]:
        """Return the seconds for the next failure, and the time by which it must be proved.

        The second is a time by :func:`fuzz.unit.deadline.now`.

        Args:
            failures: Number of failures to shrink, including this one.
            workers: Number of workers.
        """
        if self._seconds is None:
            return None, math.inf
        left = max(self._left(), 0.0)
        share = _ONE_OF * self._seconds if self.search_comes_first else left * workers / failures
        share = max(min(share, left), _LEAST)
        return share * (1.0 - _TO_CONFIRM), now() + share

    @contextlib.contextmanager
    def doing(self, units: int, shrinks: int) -> Iterator[None]:
        """Count the time spent inside towards work in progress."""
        begin = time.monotonic()
        try:
            yield
        finally:
            spent = time.monotonic() - begin
            all_ = max(units + shrinks, 1)
            self._search += spent * units / all_
            self._shrinking += spent * shrinks / all_

    def elapsed(self) -> float:
        """Return the seconds of this run, without start-up."""
        return time.monotonic() - self._ready if self.is_ready else 0.0

    def times(self) -> dict[str, float]:
        """Return the seconds of each part so far."""
        shrinking = min(self._shrinking, self.elapsed())
        return {
            "start-up": self.start_up,
            "search": self.elapsed() - shrinking,
            "shrinking": shrinking,
        }

    def _share_to_search(self, *, urgent: bool) -> float:
        if not self._shrinks:
            return _UNSHRUNK
        return _SEARCH if urgent else _SEARCH_ON

    def _left(self, share: float = 1.0) -> float:
        """Return the seconds until this share of the time is over, counted from now."""
        if self._seconds is None:
            return math.inf
        return share * (self._seconds - self._own) - self.elapsed()
