"""What a unit of a campaign found, and what later units know of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from fuzz.failure import Failure
from sim.runners.controller_time import Effort

__all__ = ["Elite", "SearchState", "StrategyYield", "UnitResult"]


@dataclass(frozen=True)
class Elite:
    """The best layout that a quality-diversity search knows in one cell of its archive.

    Args:
        layout: Bytes that a strategy turns into a world again.
        quality: The more, the better.
        verdict: At first look.
    """

    layout: bytes
    quality: float
    verdict: str


@dataclass
class UnitResult:
    """What one unit found.

    Args:
        strategy: Where its scenarios came from.
        worlds: Scenarios simulated.
        steps: Steps simulated.
        verdicts: How often each verdict came up at first look; where the target is walled off,
            ``breach`` for a robot that got there, ``sealed`` for one that did not.
        failures: The smallest failure of each class, with witness, evidence and class.
        met: How often each class was met among the failures that were classified.
        elites: By cell of the archive, what deserves to be there.
        cut: Whether its time was over before its work was done; the rest holds what it had until
            then.
        interrupted: Whether Ctrl-C did that.
        effort: Where its time went, which no store keeps and no other unit knows.
    """

    strategy: str = ""
    worlds: int = 0
    steps: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    failures: dict[str, Failure] = field(default_factory=dict)
    met: Counter[str] = field(default_factory=Counter)
    elites: dict[tuple[int, ...], Elite] = field(default_factory=dict)
    cut: bool = False
    interrupted: bool = False
    effort: Effort = field(default_factory=Effort, compare=False)


@dataclass(frozen=True)
class StrategyYield:
    """What a strategy has brought so far.

    Args:
        units: Units that it had.
        worlds: Scenarios simulated.
        steps: Steps simulated.
        failures: Failures proved and classified.
        classes: Classes that it was the first to meet.
    """

    units: int = 0
    worlds: int = 0
    steps: int = 0
    failures: int = 0
    classes: int = 0


@dataclass(frozen=True)
class SearchState:
    """What the units of an epoch know of all units up to the epoch before the last.

    The same for any timing.

    Args:
        strategies: By strategy, what it brought.
        failures: By class, the smallest failure as it was found, before shrinking.
        elites: The archive.
    """

    strategies: Mapping[str, StrategyYield] = field(default_factory=dict)
    failures: Mapping[str, Failure] = field(default_factory=dict)
    elites: Mapping[tuple[int, ...], Elite] = field(default_factory=dict)

    def after(self, result: UnitResult) -> SearchState:
        """Return the memory with one more unit's result."""
        had = self.strategies.get(result.strategy, StrategyYield())
        strategy = replace(
            had,
            units=had.units + 1,
            worlds=had.worlds + result.worlds,
            steps=had.steps + result.steps,
            failures=had.failures + result.met.total(),
            classes=had.classes + len(result.failures.keys() - self.failures.keys()),
        )
        smaller = {
            kind: one for kind, one in result.failures.items() if self.is_interesting(kind, one)
        }
        better = {
            cell: elite for cell, elite in result.elites.items() if self.is_better(cell, elite)
        }
        return SearchState(
            {**self.strategies, result.strategy: strategy},
            {**self.failures, **smaller},
            {**self.elites, **better},
        )

    def is_interesting(self, kind: str, failure: Failure) -> bool:
        """Return True if a failure is the first of its class, or smaller than those known."""
        before = self.failures.get(kind)
        return before is None or failure.size < before.size

    def is_better(self, cell: tuple[int, ...], elite: Elite) -> bool:
        """Return True if a cell of the archive is empty, or holds less."""
        before = self.elites.get(cell)
        return before is None or elite.quality > before.quality
