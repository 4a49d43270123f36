"""Build the overview of a campaign that has ended, within a share of its budget."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.state import CampaignState
from fuzz.campaign.store import MEMORY
from fuzz.corpus import Baseline
from fuzz.failure import Failure
from fuzz.overview.causes import CauseTotals, causes_of, with_natural
from fuzz.overview.clearest import clearest
from fuzz.overview.comparison import RegressionView, compare, with_states
from fuzz.overview.counterfactual import Counterfactuals, counterfactuals
from fuzz.overview.natural import natural_families, natural_runs
from fuzz.overview.overview import Overview
from fuzz.triage.cause import Cause, Severity
from fuzz.triage.diagnosis import cause_of
from sim.evidence import FaultEvidence
from sim.runners.stopping import OutOfTime, stopping_when
from worldgen.errors import WorldgenError

__all__ = ["Conclusion", "build_overview", "causes_in", "explained", "with_worlds"]

# Limit on the natural worlds of a campaign without a time limit: a tenth of the worlds that its
# units may try, so that a short campaign stays short, and no more than an interval of +/- 3 %
# needs.
_NATURAL_SHARE = 10
_MOST_NATURAL = 900
_FEWEST_NATURAL = 9

# Causes whose clearest world is explained. The terminal and the first screen show only these.
_MOST_EXPLAINED = 5

# Fraction of the usual effort that an explanation in a campaign may take.
_EFFORT = 0.15

# Limit on the cells that the proofs of one explanation examine: about a second. A map of 200,000
# cells gets ten changes, a shrunk world all of them.
_MOST_CELLS = 2_000_000

# Share of the time for natural worlds; the rest is for explanations.
_NATURAL_TIME = 0.6


@dataclass(frozen=True)
class Conclusion:
    """The inputs for concluding a campaign.

    Args:
        known: Failures that the user knows, as a baseline.
        last: Failures of the last campaign in the same folder.
        seconds: Time that the conclusion may take; ``None`` for a fixed amount of work, so that the
            result depends only on the seed.
    """

    known: Baseline = field(default_factory=Baseline)
    last: Baseline = field(default_factory=Baseline)
    seconds: float | None = None


def build_overview(
    config: CampaignConfig,
    state: CampaignState,
    conclusion: Conclusion,
    *,
    natural: bool = True,
) -> Overview:
    """Return the overview of a campaign.

    Args:
        config: Its definition.
        state: Its results.
        conclusion: Known failures, and the time.
        natural: True to run natural worlds. An interrupted campaign does not.
    """
    began = time.monotonic()
    seconds = conclusion.seconds

    # Group first, because it takes no runs.
    found = {**state.best, **state.memory.failures}
    causes = causes_of(found, {bucket: state.met[bucket] for bucket in found})

    # Natural worlds show how often each cause matters, and so which to explain first.
    runs = None
    # For a user's own map, and for several robots, "natural" is not defined.
    is_usual = config.fixed_map is None and config.robots == 1
    families = natural_families(config.families) if is_usual else []
    if natural and families:
        runs = natural_runs(
            config.scenario,
            families,
            _natural_count(config, state, seconds),
            config.seed,
            _after(began, seconds, _NATURAL_TIME),
        )
        causes = with_natural(causes, runs.causes)

    # Find the clearest world of each cause, and its dependencies.
    is_over = None if seconds is None else _after(began, seconds, 1.0)
    shown = with_worlds(causes, _candidates(state), is_over)

    comparison = _compared(state, conclusion)
    if comparison is not None:
        shown = with_states(shown, comparison)
    return Overview(tuple(shown), runs, comparison)


def _natural_count(config: CampaignConfig, state: CampaignState, seconds: float | None) -> int:
    if seconds is not None:
        return _MOST_NATURAL
    count = state.units * config.examples // (_NATURAL_SHARE * config.slower)
    return min(max(count, _FEWEST_NATURAL), _MOST_NATURAL)


def _after(began: float, seconds: float | None, share: float) -> Callable[[], bool]:
    if seconds is None:
        return lambda: False
    end = began + share * seconds
    return lambda: time.monotonic() >= end


def _candidates(state: CampaignState) -> dict[str, Failure]:
    """Return the failures that have a file, by its name in the campaign's folder."""
    found = {f"{bucket}.grid": failure for bucket, failure in state.best.items()}
    kept = {find.failure.id: find.failure for find in state.finds}
    return found | {f"{MEMORY}/failures/{name}.grid": failure for name, failure in kept.items()}


def with_worlds(
    causes: Iterable[CauseTotals],
    candidates: Mapping[str, Failure],
    is_over: Callable[[], bool] | None = None,
) -> list[CauseTotals]:
    """Return causes with their worlds to look at, and explanations of the first few.

    Args:
        causes: The causes, the worst first.
        candidates: Failures by the name of their file.
        is_over: Returns True once there is no more time; a fixed amount of work if omitted.
    """
    return [
        _with_worlds(one, candidates, is_explained=number < _MOST_EXPLAINED, is_over=is_over)
        for number, one in enumerate(causes)
    ]


def _with_worlds(
    cause: CauseTotals,
    candidates: Mapping[str, Failure],
    *,
    is_explained: bool,
    is_over: Callable[[], bool] | None,
) -> CauseTotals:
    """Return a cause with its clearest and its smallest world, and the clearest one's dependencies."""
    with stopping_when(is_over or (lambda: False)):
        own = {name: one for name, one in candidates.items() if cause_of(one) == cause.cause}
        # An error of the controller shows in its message, not in the picture.
        is_error = cause.cause.severity == Severity.CONTROLLER_ERROR
        best = None if is_error else clearest(own.values(), cause.cause)
    smallest = min(own.values(), key=lambda failure: failure.order, default=None)
    best = smallest if is_error else best
    if best is None or smallest is None:
        return cause
    why = explained(best, is_over) if is_explained else None
    return replace(
        cause,
        file=_name_of(best, own),
        smallest=_name_of(smallest, own),
        why=why,
        fault=_fault_of(best),
    )


def _fault_of(failure: Failure) -> str:
    evidence = failure.evidence
    if not isinstance(evidence, FaultEvidence):
        return ""
    return ": ".join(filter(None, (evidence.at, evidence.error)))


def explained(
    failure: Failure, is_over: Callable[[], bool] | None = None
) -> Counterfactuals | None:
    """Return the single changes after which a failure's robot arrives, at little cost.

    Args:
        failure: The failure.
        is_over: Returns True once there is no more time; a fixed amount of work if omitted.

    Returns:
        The changes; ``None`` if nothing could be learned because there is no time, or no change can
        explain such a failure.
    """
    is_bounded = is_over is not None
    is_over = is_over or (lambda: False)
    # Causes that never depend on a wall, a number or an option are explained by their own sentence.
    if cause_of(failure).severity in (Severity.CONTROLLER_ERROR, Severity.UNSENSED) or is_over():
        return None
    try:
        with stopping_when(is_over):
            found = counterfactuals(
                failure,
                effort=1.0 if is_bounded else _EFFORT,
                most_runs=_MOST_CELLS / failure.world.walls.size,
            )
    except (WorldgenError, OutOfTime):
        return None
    # If some changes do not help, the others still might.
    return found if found.changes or found.is_complete else None


def _name_of(failure: Failure, files: Mapping[str, Failure]) -> str:
    """Return the file of a failure, preferably one that the user sees rather than a hidden one."""
    names = [name for name, other in files.items() if other is failure or other.id == failure.id]
    return min(names, key=lambda name: (name.startswith(MEMORY), name))


def _compared(state: CampaignState, conclusion: Conclusion) -> RegressionView | None:
    if conclusion.known.is_empty and conclusion.last.is_empty:
        return None
    against, before = (
        ("baseline", conclusion.known)
        if not conclusion.known.is_empty
        else ("last campaign", conclusion.last)
    )
    now = {bucket: cause_of(failure) for bucket, failure in state.best.items()}
    return compare(against, now, _causes(before.failing()), _causes(before.fixed))


def _causes(failures: Iterable[Failure]) -> dict[str, Cause]:
    """Return the cause of each class; the first failure of a class decides."""
    found: dict[str, Cause] = {}
    for failure in failures:
        if failure.bucket not in found:
            found[failure.bucket] = cause_of(failure)
    return found


def causes_in(failures: Sequence[Failure]) -> list[CauseTotals]:
    """Return the causes of failures that belong to no campaign."""
    found: dict[str, Failure] = {}
    for failure in failures:
        found.setdefault(failure.bucket, failure)
    return causes_of(found, {})
