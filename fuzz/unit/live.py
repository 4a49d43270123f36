"""Count runs as they happen, across processes, so that a long unit shows progress.

A unit returns its result at its end, which may be a minute away. Each process therefore adds its
runs to counters that all of them share. They are shown to people only; no result depends on them.
"""

from __future__ import annotations

import contextlib
import json
import os
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import msgspec

from worldgen.files.whole import read_text

LIVE_FILE = "live.json"
"""Name, in the campaign store, of the file with the counts while a campaign runs."""

_EVERY = 0.5  # s between two versions of the file
_EXPECTED = ("reached", "covered", "sealed")  # verdicts in screening

Counters = Any  # a shared array of three numbers, which has no public type
_counters: list[Counters] = []


@dataclass(frozen=True)
class LiveCounts:
    """Runs of all processes since the executor was made.

    Args:
        worlds: Number of runs.
        steps: Steps of all runs.
        failed: Number of runs that did not arrive in screening.
    """

    worlds: int = 0
    steps: int = 0
    failed: int = 0

    @classmethod
    def of(cls, counters: Counters) -> LiveCounts:
        """Return the current values of shared counters."""
        worlds, steps, failed = counters
        return cls(int(worlds), int(steps), int(failed))

    def plus(self, worlds: int, steps: int, verdicts: Mapping[str, int]) -> LiveCounts:
        """Return these counts plus those of a unit's result."""
        failed = not_arrived(verdicts)
        return LiveCounts(self.worlds + worlds, self.steps + steps, self.failed + failed)

    def without(self, handed_in: LiveCounts) -> LiveCounts:
        """Return the counts not yet in a result; at least 0, because a unit may be done twice."""
        return LiveCounts(
            max(0, self.worlds - handed_in.worlds),
            max(0, self.steps - handed_in.steps),
            max(0, self.failed - handed_in.failed),
        )


class Phase(StrEnum):
    """What a running campaign is doing."""

    PREPARING = "preparing"
    SEARCHING = "searching"
    SHRINKING = "shrinking"
    EXPLAINING = "explaining"


@dataclass(frozen=True)
class LiveState:
    """The current activity of a campaign.

    Args:
        phase: Preparing until the first run, which does not count towards the budget; then
            searching, or shrinking while there is no search; at last explaining, while it runs
            natural worlds and tries what the failures depend on.
        worlds: Runs so far, including those of units in progress.
        steps: Steps of these runs.
        failed: Runs that did not arrive in screening.
        shrinking: Failures that are being shrunk, or waiting for it.
        elapsed: Seconds of the budget that are used.
        rate: Worlds a minute, of this run and all of its workers.
        cost: Seconds of one worker for a world, with all work on it; 0 until a unit is done.
        own: Share of that in the controller's own code, where it can be measured.
        left: Seconds until the units are done, estimated; 0 if not known.
    """

    phase: Phase = Phase.PREPARING
    worlds: int = 0
    steps: int = 0
    failed: int = 0
    shrinking: int = 0
    elapsed: float = 0.0
    rate: float = 0.0
    cost: float = 0.0
    own: float = 0.0
    left: float = 0.0


def has_not_arrived(verdict: str) -> bool:
    """Return True if a run with this verdict in screening did not arrive, and should have."""
    return verdict not in _EXPECTED


def not_arrived(verdicts: Mapping[str, int]) -> int:
    """Return the number of runs that did not arrive in screening, and should have."""
    return sum(count for verdict, count in verdicts.items() if has_not_arrived(verdict))


def count_in(counters: Counters) -> None:
    """Add all further runs of this process to these shared counters."""
    _counters[:] = [counters]


def count_live(verdict: str, runs: int, steps: int) -> None:
    """Count runs that have just ended.

    Args:
        verdict: Verdict in screening.
        runs: Number of runs that ended with it.
        steps: Steps of these runs.
    """
    for counters in _counters:
        with counters.get_lock():
            counters[0] += runs
            counters[1] += steps
            counters[2] += runs if has_not_arrived(verdict) else 0


@contextlib.contextmanager
def shown_in(store: Path, state: Callable[[], LiveState]) -> Iterator[None]:
    """Keep a file up to date with a campaign's activity, and remove it at the end.

    Args:
        store: The campaign store's folder.
        state: Returns its activity; called in another thread.
    """
    over = threading.Event()
    file = store / LIVE_FILE

    def write() -> None:
        while not over.wait(_EVERY):
            # A full disk is reported when required files are written.
            with contextlib.suppress(OSError):
                part = file.with_suffix(".part")
                part.write_text(json.dumps(asdict(state())), "utf-8")
                os.replace(part, file)  # noqa: PTH105 - so that a reader finds a whole file

    thread = threading.Thread(target=write, name="live counts", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


def read_live(store: Path) -> LiveState | None:
    """Return the activity of a running campaign; ``None`` if it is not known (yet)."""
    try:
        return msgspec.json.decode(read_text(store / LIVE_FILE), type=LiveState)
    except (ValueError, RecursionError):
        return None
