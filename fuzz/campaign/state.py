"""What a campaign yields while it runs, and its totals."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from fuzz.campaign.executors import Executor
from fuzz.campaign.store import Find
from fuzz.failure import Failure
from fuzz.unit.result import FailureKey, SearchState
from sim.clock.controller_time import Effort


@dataclass(frozen=True)
class UnitDone:
    """A unit has been merged, in order of unit numbers.

    Args:
        unit: Its number.
        state: State of the campaign, including the unit.
        again: True if it was done in an earlier run.
    """

    unit: int
    state: CampaignState
    again: bool = False


@dataclass(frozen=True)
class Discovery:
    """A failure is the first with its key, or comes before the known one in order.

    Args:
        failure: The shrunk failure.
        replaces: True if its key already had one.
    """

    failure: Failure
    replaces: bool


@dataclass(frozen=True)
class SearchEnded:
    """The search has ended, other than by Ctrl-C; nothing follows.

    Args:
        executor: Whose workers are free until the campaign is asked for another event.
    """

    executor: Executor


Progress = UnitDone | Discovery | SearchEnded


@dataclass
class CampaignState:
    """Totals so far.

    Args:
        units: Units done and merged.
        cut: Additional units that must be done again, because they were cut short by the time limit
            or Ctrl-C, or came too early.
        too_early: The part of ``cut`` that was completed with too little knowledge, because an
            earlier unit was cut short.
        until: One more than the highest number of any unit, complete or cut.
        worlds: Scenarios simulated.
        steps: Steps simulated.
        seconds: Seconds of all runs together.
        times: Seconds of this run: ``start-up``, ``search`` and ``shrinking``.
        effort: For this run, how units and shrinking spent their time, over all workers.
        verdicts: Counts of the verdicts in screening.
        tried: Worlds drawn on the user's map, by kind.
        judged: Runs that did not arrive in screening and were judged.
        met: Number of examined failures, by group and verdict.
        known: The same by group, for groups in the baseline.
        best: By key, the smallest failure; of a group of which none is shrunk, as it was found.
        memory: The search state: the strategies' yields, and the knowledge of later units.
        finds: What summaries tell of each find, and the failure as found, before shrinking; in the
            order of units, and in each by time.
    """

    units: int = 0
    cut: int = 0
    too_early: int = 0
    until: int = 0
    worlds: int = 0
    steps: int = 0
    seconds: float = 0.0
    times: dict[str, float] = field(default_factory=dict)
    effort: Effort = field(default_factory=Effort)
    verdicts: Counter[str] = field(default_factory=Counter)
    tried: Counter[str] = field(default_factory=Counter)
    judged: int = 0
    met: Counter[tuple[str, str]] = field(default_factory=Counter)
    known: Counter[str] = field(default_factory=Counter)
    best: dict[FailureKey, Failure] = field(default_factory=dict)
    memory: SearchState = field(default_factory=SearchState)
    finds: list[tuple[Find, Failure]] = field(default_factory=list)

    @property
    def met_by_group(self) -> Counter[str]:
        """Number of examined failures of each group."""
        met: Counter[str] = Counter()
        for (group, _), count in self.met.items():
            met[group] += count
        return met
