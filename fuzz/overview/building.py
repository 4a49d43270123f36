"""Build the overview of a campaign that has ended, within a share of its budget."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from concurrent.futures import wait
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from msgspec import structs

from fuzz.campaign.executors import Executor
from fuzz.campaign.state import CampaignState
from fuzz.campaign.store import MEMORY
from fuzz.cause import Cause, Severity
from fuzz.corpus import Baseline
from fuzz.failure import SHRINKING, Failure, ShrinkState, few_of_each, stem_of
from fuzz.overview.causes import causes_of, with_natural
from fuzz.overview.clearest import clearest
from fuzz.overview.comparison import compare, with_states
from fuzz.overview.counterfactual import Counterfactuals, counterfactuals
from fuzz.overview.limits import (
    EFFORT,
    GRACE,
    MOST_CELLS,
    SECONDS_TO_EXPLAIN,
    SHRINKING_TIME,
    has_passed,
    natural_count,
    time_for_natural,
)
from fuzz.overview.natural import (
    NATURAL,
    describe_fall,
    natural_families,
    natural_result,
    natural_runs,
)
from fuzz.overview.result import CampaignComparison, CampaignResult, CauseResult, NaturalResult
from fuzz.search.plan import prices_of
from fuzz.shrink.queue import SHRINKING_SECONDS, shrunk_or_same
from fuzz.simplicity import Case
from fuzz.triage.diagnosis import cause_of, diagnosis_of
from fuzz.triage.judging import failure_of
from fuzz.triage.run_facts import RunFacts, run_facts
from fuzz.unit.answer import AnswerNumbers
from fuzz.unit.config import CampaignConfig
from fuzz.unit.constraint import Constraint
from fuzz.unit.deadline import now
from fuzz.unit.live import not_arrived
from fuzz.unit.pace import Pace
from sim.clock.controller_time import Effort, count_differences, count_survivors
from sim.clock.stopping import OutOfTime, stopping_when
from sim.controllers.catalogue.renewal import as_loaded
from sim.episode.differences import note_difference
from sim.evidence import FaultEvidence
from worldgen.errors import WorldgenError
from worldgen.plugins.workers import LISTEN

# Causes whose clearest world is explained. The terminal and the first screen show only these.
_MOST_EXPLAINED = 5

# Share of a cause's time for choosing its clearest world. Each candidate has to run, and a slow
# controller would have no time left to show what it repeats in the one that is chosen.
_TO_CHOOSE = 0.4

# A cause, its clearest failure, the failures that were shrunk, by id, and what that took.
_Explained: TypeAlias = tuple[CauseResult, Failure | None, dict[str, Failure], Effort]


@dataclass(frozen=True)
class Conclusion:
    """The inputs for concluding a campaign.

    Args:
        known: Failures that the user already knows, as a baseline.
        last: Failures of the last campaign in the same folder.
        before: Results in natural worlds of the baseline's campaign, or of the last one; ``None``
            if unknown.
        seconds: Time that the conclusion may take; ``None`` for a fixed amount of work, so that the
            result depends only on the seed.
        with_code: False to leave out what runs inside the controller.
    """

    known: Baseline = field(default_factory=Baseline)
    last: Baseline = field(default_factory=Baseline)
    before: NaturalResult | None = None
    seconds: float | None = None
    with_code: bool = True


class Overview(NamedTuple):
    """A campaign's result, with the failures that it names.

    Args:
        result: The result.
        files: By the stem of its file, each failure that the campaign shows.
        examples: By cause, the failure to look at.
        originals: Failures that examples were shrunk from, if the campaign's store may lack them.
    """

    result: CampaignResult
    files: Mapping[str, Failure]
    examples: Mapping[Cause, Failure]
    originals: Sequence[Failure] = ()


def build_overview(
    config: CampaignConfig,
    state: CampaignState,
    conclusion: Conclusion,
    *,
    natural: bool = True,
    executor: Executor | None = None,
    release: Callable[[], None] = lambda: None,
) -> Overview:
    """Return the overview of a campaign.

    Args:
        config: Its definition.
        state: Its results.
        conclusion: Known failures, and the time limit.
        natural: True to run natural worlds. An interrupted campaign does not.
        executor: Whose workers run them and explain the causes; this process if omitted.
        release: Called when the workers are no longer needed.
    """
    at = now()
    seconds = conclusion.seconds

    # Group first, because that needs no runs.
    causes = causes_of({**state.best, **state.memory.failures}.values(), state.met)

    # Natural worlds show how often each cause matters, and so which to explain first.
    runs = None
    natural_cases: dict[Cause, Case] = {}
    families = families_of(config)
    if natural and families:
        runs, natural_cases = natural_runs(
            config.scenario,
            families,
            natural_count(config, state, seconds),
            config.seed,
            time_for_natural(at, seconds, has_failures=bool(causes)),
            config.vary,
            executor,
        )
        causes = with_natural(causes, runs.causes)

    # Find the clearest world of each cause, and its dependencies.
    until = None if seconds is None else at + SHRINKING_TIME * seconds
    sources = {
        one.cause: _FailuresOf(
            config,
            conclusion.known,
            _in_search(one.cause, state, conclusion.known),
            natural_cases.get(one.cause),
            until,
        )
        for one in causes
    }
    end = None if seconds is None else at + seconds
    most_steps = config.pace.steps_in(SECONDS_TO_EXPLAIN)
    if executor is None:
        causes, examples = with_worlds(
            causes,
            lambda cause: sources[cause](cause),
            end,
            with_code=conclusion.with_code,
            most_steps=most_steps,
            clock=now,
        )
        as_found = {id_: one for source in sources.values() for id_, one in source.as_found.items()}
    else:
        call = partial(_explain_one, with_code=conclusion.with_code, most_steps=most_steps)
        causes, examples, as_found = _shared_out(executor, call, causes, sources, end)
    release()

    files = files_of(
        state.best.values(), [one for one in examples.values() if not conclusion.known.has(one)]
    )
    causes = [
        _with_files(one, examples[one.cause], files, conclusion.known)
        if one.cause in examples
        else one
        for one in causes
    ]
    comparison = _compared(files, conclusion, runs)
    if comparison is not None:
        causes = with_states(causes, comparison)
    originals = [as_found[one.original] for one in examples.values() if one.original in as_found]
    result = CampaignResult(causes=causes, natural=runs, comparison=comparison)
    return Overview(result, files, examples, originals)


@dataclass
class _FailuresOf:
    """Returns the failures of a campaign that have a cause.

    Args:
        config: The campaign's definition.
        known: Failures that are known.
        searched: Those that the search found.
        natural: The simplest natural world with the cause, used if there are none.
        until: When shrinking it must end, by :func:`fuzz.unit.deadline.now`.
        as_found: Failures that were shrunk, by id.
    """

    config: CampaignConfig
    known: Baseline
    searched: list[Failure]
    natural: Case | None
    until: float | None
    as_found: dict[str, Failure] = field(default_factory=dict)

    def __call__(self, cause: Cause) -> list[Failure]:
        if self.searched or self.natural is None:
            return self.searched
        constraint = self.config.constraint
        return _in_natural_world(cause, self.natural, self.known, self._shrunk, constraint)

    def _shrunk(self, failure: Failure) -> Failure:
        if not self.config.shrink:
            return failure
        self.as_found[failure.id] = failure
        return _shrunk(failure, self.until, self.config.pace)


def _shared_out(
    executor: Executor,
    call: Callable[..., _Explained],
    causes: Sequence[CauseResult],
    sources: Mapping[Cause, _FailuresOf],
    end: float | None,
) -> tuple[list[CauseResult], dict[Cause, Failure], dict[str, Failure]]:
    """Let workers choose a failure to look at for each cause, and explain the first few.

    Return the causes, these failures, and those that were shrunk, by id.

    Raises:
        KeyboardInterrupt: After Ctrl-C.
    """
    executor.go_on()
    # Causes wait for each other if there are more of them than workers, and share the time.
    rounds = -(-len(causes) // max(executor.room - 1, 1))
    begins = now()
    futures = []
    for number, cause in enumerate(causes):
        until = None
        if end is not None:
            turn = number * rounds // len(causes) + 1
            until = begins + (end - begins) * turn / rounds
        explains = number < _MOST_EXPLAINED
        futures.append(executor.submit(call, cause, sources[cause.cause], until, explains=explains))
    # A worker that is stuck in a step is not waited for.
    late = math.inf if end is None else end + GRACE
    while wait(futures, LISTEN).not_done and now() < late:
        executor.listen()
    executor.listen()
    results = []
    examples: dict[Cause, Failure] = {}
    as_found: dict[str, Failure] = {}
    for cause, future in zip(causes, futures, strict=True):
        result, example, originals, effort = (
            future.result() if future.done() else _unexplained(cause, sources[cause.cause])
        )
        results.append(result)
        as_found |= originals
        if example is not None:
            examples[cause.cause] = example
        # What was noticed there counts here.
        count_survivors(effort.survivors)
        count_differences(effort.differences)
    return results, examples, as_found


def _unexplained(cause: CauseResult, source: _FailuresOf) -> _Explained:
    """Return a cause with the simplest failure of the search, which takes no time to choose."""
    example = min(source.searched, key=lambda one: one.order, default=None)
    result = cause if example is None else _with_example(cause, example)
    return result, example, {}, Effort()


def _explain_one(
    cause: CauseResult,
    source: _FailuresOf,
    end: float | None,
    *,
    explains: bool,
    with_code: bool,
    most_steps: float,
) -> _Explained:
    """Choose a failure to look at for one cause, and perhaps explain it; a worker does this."""
    began = Effort.so_far()
    as_loaded(source.config.scenario.controller)
    (result,), examples = with_worlds(
        [cause],
        source,
        end,
        most=int(explains),
        with_code=with_code,
        most_steps=most_steps,
        clock=now,
    )
    return result, examples.get(cause.cause), source.as_found, began.since()


def families_of(config: CampaignConfig) -> list[str]:
    """Return the families of a campaign's natural worlds.

    Empty if they are not defined: for a user's own map, for several robots, and if no chosen
    strategy draws from a family.
    """
    is_usual = config.fixed_map is None and config.robots == 1
    return natural_families(config.families) if is_usual else []


def answer_numbers(
    config: CampaignConfig, state: CampaignState, result: CampaignResult, failing: Collection[str]
) -> AnswerNumbers:
    """Return the numbers that decide what a campaign answers.

    Args:
        config: Its definition.
        state: Its results.
        result: What it found; empty before that is known.
        failing: Causes of failures that no baseline has, without hazards that do not count.
    """
    own = [one for one in result.causes if one.cause.severity != Severity.UNSENSED]
    groups = {group for one in own for group in one.groups}
    natural = result.natural or natural_result([])
    return AnswerNumbers(
        failures=len(failing),
        known=len((state.known.keys() | groups) - set(failing)),
        natural=natural.finished if families_of(config) else None,
        natural_hazards=natural.unsensed,
        # A cause without groups is one of which no failure is proved.
        natural_unjudged=sum(one.natural or 0 for one in own if not one.groups),
        searched=state.worlds,
        searched_unjudged=max(not_arrived(state.verdicts) - state.judged, 0),
        proof_seconds=prices_of(config).proof / 1e3,
    )


def with_worlds(
    causes: Iterable[CauseResult],
    failures_of: Callable[[Cause], Sequence[Failure]],
    end: float | None = None,
    *,
    most: int = _MOST_EXPLAINED,
    with_code: bool = True,
    most_steps: float = math.inf,
    clock: Callable[[], float] = time.monotonic,
) -> tuple[list[CauseResult], dict[Cause, Failure]]:
    """Choose a failure to look at for each cause, and explain the first few.

    Args:
        causes: The causes, the worst first.
        failures_of: Returns the failures that have a cause.
        end: When there is no more time, by ``clock``; if omitted, the amount of work is fixed.
        most: Number of causes to explain.
        with_code: False to leave out what runs inside the controller.
        most_steps: Limit on the steps of one explanation without a time limit.
        clock: Returns seconds.

    Returns:
        The causes, with what these failures show; and the failures.
    """
    results = []
    examples = {}
    all_causes = list(causes)
    most = min(len(all_causes), most)
    for number, cause in enumerate(all_causes):
        own = failures_of(cause.cause)
        # One cause must not take the time of the others, nor the choice that of the explanation.
        is_over = is_chosen = None
        if end is not None:
            begins = clock()
            share = (end - begins) / max(most - number, 1)
            is_over = partial(has_passed, begins + share, clock)
            is_chosen = partial(has_passed, begins + _TO_CHOOSE * share, clock)
        example = _example(cause.cause, own, is_chosen)
        if example is None:
            results.append(cause)
            continue
        examples[cause.cause] = example
        known: dict[str, Any] = {}
        if number < most:
            known |= vars(_shown(example, is_over, with_code=with_code))
            why = explained(example, is_over, most_steps)
            if why is not None:
                known |= {"why": why.describe(), "changes": list(why.changes)}
        results.append(structs.replace(_with_example(cause, example), **known))
    return results, examples


def _with_example(cause: CauseResult, example: Failure) -> CauseResult:
    """Return a cause with what the record of the failure that shows it says."""
    diagnosis = diagnosis_of(example)
    return structs.replace(
        cause,
        sentence=diagnosis.sentence(example.world),
        advice=diagnosis.advice,
        groups=cause.groups or [example.group],
        fault=_fault_of(example),
    )


def _example(
    cause: Cause, own: Sequence[Failure], is_over: Callable[[], bool] | None
) -> Failure | None:
    """Return the failure that shows a cause best, or ``None`` if ``own`` is empty."""
    # An error of the controller and a broken rule show in their message, not in the picture.
    if cause.severity in (Severity.CONTROLLER_ERROR, Severity.QUESTIONABLE):
        return min(own, key=lambda one: one.order, default=None)
    with stopping_when(is_over or (lambda: False)):
        return clearest(own)


def _in_search(cause: Cause, state: CampaignState, known: Baseline) -> list[Failure]:
    """Return the failures of a campaign's search that have a cause: new ones, or else known ones."""
    found = (*state.best.values(), *(failure for _, failure in state.finds))
    # A failure that waits to be shrunk is in both, but only the first says how far that got.
    distinct: dict[str, Failure] = {}
    for one in found:
        distinct.setdefault(one.without(SHRINKING).id, one)
    own = [one for one in distinct.values() if cause_of(one) == cause]
    return [one for one in own if not known.has(one)] or own


def _in_natural_world(
    cause: Cause,
    case: Case,
    known: Baseline,
    shrunk: Callable[[Failure], Failure],
    constraint: Constraint,
) -> list[Failure]:
    """Return the failure in a cause's simplest natural world, if it can be proved.

    Both as it was found and, if that keeps the cause, shrunk. Without a file if it is known.
    """
    world, scenario = case
    try:
        failure = failure_of(world, scenario, found_by=NATURAL, **constraint.details())
        if failure is None:
            # It did not arrive before, so its runs may differ.
            note_difference(world, scenario.controller, scenario.options(world))
    except (WorldgenError, OutOfTime):
        return []
    if failure is None or cause_of(failure) != cause:
        return []
    if known.has(failure):
        return [failure]
    smaller = shrunk(failure)
    if smaller.world is failure.world:
        return [smaller]
    # Whether the robot is to blame is decided again for the smaller world.
    return [smaller, failure] if cause_of(smaller) == cause else [failure]


def _shrunk(failure: Failure, until: float | None, pace: Pace) -> Failure:
    """Return a failure shrunk as far as the time allows, by :func:`fuzz.unit.deadline.now`."""
    if until is None:
        return shrunk_or_same(failure, most_steps=pace.steps_in(SHRINKING_SECONDS)).failure
    left = until - now()
    if left <= 0.0:
        return failure
    # The result takes a little longer to be proved.
    result = shrunk_or_same(failure, seconds=0.7 * left, end=now() + left)
    if result.failure is failure and not result.complete:
        return failure.noting(**{SHRINKING: ShrinkState.CUT_SHORT.value})
    return result.failure


def files_of(best: Iterable[Failure], clearest: Iterable[Failure] = ()) -> dict[str, Failure]:
    """Return the failures that a campaign shows, by the stem of their file.

    Args:
        best: Failures with different keys, the candidates.
        clearest: Failures that come first in their group, whether they are candidates or not.

    Returns:
        Of each group at most three, the others in order: ``CAUSE``, ``CAUSE-2`` and ``CAUSE-3``.
    """
    groups = few_of_each(
        (*clearest, *sorted(best, key=lambda one: one.order)),
        lambda one: one.group,
        lambda one: one.signature,
    )
    return {
        stem_of(group, number, groups): failure
        for group, own in groups.items()
        for number, failure in enumerate(own, 1)
    }


def _with_files(
    cause: CauseResult, example: Failure, files: Mapping[str, Failure], known: Baseline
) -> CauseResult:
    """Return a cause with the names of its files in the campaign's folder.

    A known failure is not written; the campaign's store has it.
    """
    if known.has(example):
        # A failure that only a natural world shows was never stored.
        file = f"{MEMORY}/failures/{example.id}.grid" if cause.met else ""
        return structs.replace(cause, file=file, smallest=file)
    own = {stem: one for stem, one in files.items() if one.group in cause.groups}
    names = {one.key: f"{stem}.grid" for stem, one in own.items()}
    smallest = min(own.values(), key=lambda one: one.order)
    return structs.replace(
        cause, file=names[example.key], smallest=names[smallest.key], files=list(names.values())
    )


def _fault_of(failure: Failure) -> str:
    """Return a controller's error with its place: ``mine.py:6: KeyError: 'left'``; may be empty."""
    evidence = failure.evidence
    if not isinstance(evidence, FaultEvidence):
        return ""
    place = evidence.at
    if place is None and evidence.frames and {"file", "line"} <= evidence.frames[-1].keys():
        place = f"{evidence.frames[-1]['file']}:{evidence.frames[-1]['line']}"
    return ": ".join(filter(None, (place, evidence.error, evidence.report)))


def _shown(failure: Failure, is_over: Callable[[], bool] | None, *, with_code: bool) -> RunFacts:
    """Return what the run of a failure shows; nothing without time to run it."""
    try:
        with stopping_when(is_over or (lambda: False)):
            return run_facts(failure, failure.run(), with_code=with_code)
    except (WorldgenError, OutOfTime):
        return RunFacts()


def explained(
    failure: Failure, is_over: Callable[[], bool] | None = None, most_steps: float = math.inf
) -> Counterfactuals | None:
    """Return the single changes after which a failure's robot arrives, at little cost.

    Args:
        failure: The failure.
        is_over: Returns True once there is no more time; if omitted, the amount of work is fixed.
        most_steps: Limit on the steps if the amount of work is fixed.

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
                effort=1.0 if is_bounded else EFFORT,
                most_steps=math.inf if is_bounded else most_steps,
                most_runs=MOST_CELLS / failure.world.walls.size,
            )
    except (WorldgenError, OutOfTime):
        return None
    # If some changes do not help, the others still might.
    return found if found.changes or found.is_complete else None


def _compared(
    files: Mapping[str, Failure], conclusion: Conclusion, natural: NaturalResult | None
) -> CampaignComparison | None:
    if conclusion.known.is_empty and conclusion.last.is_empty:
        return None
    against, before = (
        ("baseline", conclusion.known)
        if not conclusion.known.is_empty
        else ("last campaign", conclusion.last)
    )
    return compare(
        against,
        now={one.group for one in files.values()},
        still={one.group for one in before.failing()},
        fixed={one.group for one in before.fixed},
        fall=describe_fall(natural, conclusion.before),
    )
