"""The result of a unit, and what later units learn from it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, TypeAlias

import msgspec

from fuzz.failure import Failure
from sim.clock.controller_time import Effort

_Count = Annotated[int, msgspec.Meta(ge=0, le=(1 << 63) - 1)]

UnitCount: TypeAlias = Annotated[int, msgspec.Meta(ge=0, le=1 << 48)]
"""A count of one unit; the limit keeps the sums over all units in range."""

Seconds: TypeAlias = Annotated[float, msgspec.Meta(ge=-1e12, le=1e12)]
"""A duration; slightly negative if a clock was set back."""

FailureKey: TypeAlias = tuple[str, str]
"""See :attr:`fuzz.failure.Failure.key`."""


@dataclass(frozen=True)
class Elite:
    """The best layout found by a quality-diversity search in one cell of its archive.

    Args:
        layout: Bytes from which a strategy makes the world again.
        quality: Quality; higher is better.
        verdict: Verdict of the screening run.
    """

    layout: bytes
    quality: float
    verdict: str


class FirstMet(NamedTuple):
    """When a unit first met a failure of one key.

    Args:
        worlds: Scenarios that the unit had simulated by then, with this one.
        steps: Steps by then.
        seconds_left: Seconds from then to the unit's end.
    """

    worlds: UnitCount
    steps: UnitCount
    seconds_left: Seconds

    @property
    def order(self) -> tuple[int, float]:
        """A sort key by time."""
        return self.worlds, -self.seconds_left


class ScreenedRun(NamedTuple):
    """A run of a slow controller that its unit need not repeat if it is cut short.

    Args:
        steps: Steps that it took.
        cause: Cause of the failure that it seems to be; empty if it arrived.
        symptom: Why it seems so (:class:`fuzz.search.suspects.Symptom`).
        complete: False if the controller hid some of its memory.
    """

    steps: UnitCount
    cause: str = ""
    symptom: UnitCount = 0
    complete: bool = True


@dataclass
class UnitResult:
    """The result of one unit.

    Args:
        strategy: Strategy that produced its scenarios.
        worlds: Number of scenarios simulated.
        steps: Number of steps simulated.
        verdicts: Counts of verdicts in screening; if the target is walled off, ``breach`` for a
            robot that got there, ``sealed`` for one that did not.
        tried: Numbers of worlds drawn on the user's map, by kind
            (:class:`fuzz.layouts.map_windows.Kind`).
        failures: By key, the smallest failure, with witness, evidence and cause.
        first_met: By key, when the unit first met such a failure.
        judged: Number of runs that did not arrive and were judged: proved to be failures, or known
            not to be any.
        met: Number of examined failures, by group and verdict.
        elites: Candidates for the archive, by cell.
        screened: Runs that need not be repeated, by the numbers of their worlds.
        lines: First lines of statements in the controller's file that ran, unless an earlier unit of
            the same process has reported them.
        cut: Whether time ran out before its work was done; the other fields hold the results until
            then.
        interrupted: Whether the reason was Ctrl-C.
        effort: How it spent its time; this is not stored, and other units do not know it.
        stored_at: Seconds of the campaign, over all runs, when a store was given it; ``None`` for a
            new result.
    """

    strategy: str = ""
    worlds: int = 0
    steps: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    tried: Counter[str] = field(default_factory=Counter)
    judged: int = 0
    failures: dict[FailureKey, Failure] = field(default_factory=dict)
    first_met: dict[FailureKey, FirstMet] = field(default_factory=dict, compare=False)
    met: Counter[tuple[str, str]] = field(default_factory=Counter)
    elites: dict[tuple[int, ...], Elite] = field(default_factory=dict)
    screened: dict[int, ScreenedRun] = field(default_factory=dict, compare=False)
    lines: frozenset[int] = field(default=frozenset(), compare=False)
    cut: bool = False
    interrupted: bool = False
    effort: Effort = field(default_factory=Effort, compare=False)
    stored_at: float | None = None


class StrategyYield(msgspec.Struct, frozen=True):
    """The yield of a strategy so far.

    Args:
        strategy: Its name.
        units: Units it was given.
        worlds: Scenarios simulated.
        steps: Steps simulated.
        failures: Failures proved and classified.
        variants: Keys of failures that it was the first to find.
    """

    strategy: Annotated[str, msgspec.Meta(min_length=1)]
    units: _Count = 0
    worlds: _Count = 0
    steps: _Count = 0
    failures: _Count = 0
    variants: _Count = 0


@dataclass(frozen=True)
class SearchState:
    """Knowledge that the units of an epoch share, about all units up to the epoch before last.

    It is the same for any timing.

    Args:
        strategies: Yield of each strategy.
        failures: By key, the smallest failure as found, before shrinking.
        elites: The archive.
        lines: First lines of statements in the controller's file that have run.
    """

    strategies: Mapping[str, StrategyYield] = field(default_factory=dict)
    failures: Mapping[FailureKey, Failure] = field(default_factory=dict)
    elites: Mapping[tuple[int, ...], Elite] = field(default_factory=dict)
    lines: frozenset[int] = frozenset()

    def after(self, result: UnitResult) -> SearchState:
        """Return the search state with one more unit's result."""
        had = self.strategies.get(result.strategy, StrategyYield(result.strategy))
        strategy = msgspec.structs.replace(
            had,
            units=had.units + 1,
            worlds=had.worlds + result.worlds,
            steps=had.steps + result.steps,
            failures=had.failures + result.met.total(),
            variants=had.variants + len(result.failures.keys() - self.failures.keys()),
        )
        smaller = {key: one for key, one in result.failures.items() if self.is_interesting(one)}
        better = {
            cell: elite for cell, elite in result.elites.items() if self.is_better(cell, elite)
        }
        return SearchState(
            {**self.strategies, result.strategy: strategy},
            {**self.failures, **smaller},
            {**self.elites, **better},
            self.lines | result.lines,
        )

    def is_interesting(self, failure: Failure) -> bool:
        """Return True if a failure is the first with its key, or before the known one in order."""
        before = self.failures.get(failure.key)
        return before is None or failure.order < before.order

    def is_better(self, cell: tuple[int, ...], elite: Elite) -> bool:
        """Return True if a cell of the archive is empty or holds a worse layout."""
        before = self.elites.get(cell)
        return before is None or elite.quality > before.quality
