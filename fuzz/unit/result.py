"""The result of a unit, and what later units learn from it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from fuzz.failure import Failure
from sim.clock.controller_time import Effort

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


@dataclass
class UnitResult:
    """The result of one unit.

    Args:
        strategy: Strategy that produced its scenarios.
        worlds: Number of scenarios simulated.
        steps: Number of steps simulated.
        verdicts: Counts of verdicts in screening; if the target is walled off, ``breach`` for a
            robot that got there, ``sealed`` for one that did not.
        failures: By key, the smallest failure, with witness, evidence and cause.
        judged: Number of runs that did not arrive and were judged: proved to be failures, or known
            not to be any.
        met: Number of examined failures, by group and verdict.
        elites: Candidates for the archive, by cell.
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
    judged: int = 0
    failures: dict[FailureKey, Failure] = field(default_factory=dict)
    met: Counter[tuple[str, str]] = field(default_factory=Counter)
    elites: dict[tuple[int, ...], Elite] = field(default_factory=dict)
    cut: bool = False
    interrupted: bool = False
    effort: Effort = field(default_factory=Effort, compare=False)
    stored_at: float | None = None


@dataclass(frozen=True)
class StrategyYield:
    """The yield of a strategy so far.

    Args:
        units: Units it was given.
        worlds: Scenarios simulated.
        steps: Steps simulated.
        failures: Failures proved and classified.
        variants: Keys of failures that it was the first to find.
    """

    units: int = 0
    worlds: int = 0
    steps: int = 0
    failures: int = 0
    variants: int = 0


@dataclass(frozen=True)
class SearchState:
    """Knowledge that the units of an epoch share, about all units up to the epoch before last.

    It is the same for any timing.

    Args:
        strategies: Yield of each strategy.
        failures: By key, the smallest failure as found, before shrinking.
        elites: The archive.
    """

    strategies: Mapping[str, StrategyYield] = field(default_factory=dict)
    failures: Mapping[FailureKey, Failure] = field(default_factory=dict)
    elites: Mapping[tuple[int, ...], Elite] = field(default_factory=dict)

    def after(self, result: UnitResult) -> SearchState:
        """Return the search state with one more unit's result."""
        had = self.strategies.get(result.strategy, StrategyYield())
        strategy = replace(
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
        )

    def is_interesting(self, failure: Failure) -> bool:
        """Return True if a failure is the first with its key, or before the known one in order."""
        before = self.failures.get(failure.key)
        return before is None or failure.order < before.order

    def is_better(self, cell: tuple[int, ...], elite: Elite) -> bool:
        """Return True if a cell of the archive is empty or holds a worse layout."""
        before = self.elites.get(cell)
        return before is None or elite.quality > before.quality
