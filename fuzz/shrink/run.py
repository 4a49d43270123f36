"""Run the passes until a whole round changes nothing, within a time budget."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from fuzz.cause import CAUSE, CIRCUMSTANCE, GAP
from fuzz.chance import seeds_that_fail
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.hazards import HAZARD_DETAILS
from fuzz.failure import SHRINKING, Failure, ShrinkState
from fuzz.shrink.minimal import removed
from fuzz.shrink.passes import PASSES, Pass
from fuzz.shrink.predicate import SHOWN_BY_THE_RUN, StillFails
from fuzz.shrink.trying import Trying
from fuzz.simplicity import Case
from fuzz.triage.diagnosis import cause_of, cause_of_run
from fuzz.triage.judging import failure_of
from fuzz.unit.constraint import Constraint
from sim.clock.stopping import OutOfTime, stopping_when
from sim.controllers import CONTROLLERS
from sim.controllers.instances import origin_of
from sim.episode import simulate
from sim.evidence import LoopEvidence, WallEvidence
from sim.options.run import MAX_STEPS
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.world import Value, World

# A simpler world may need more steps than the original until it fails.
_MORE_STEPS = 4
_FEWEST_STEPS = 2_000
# The same for attempts with a slow controller and a time limit. Of the calls that such an attempt
# makes with the budget above, two thirds are in runs that never end.
_LONGER_LOOP = 2
_FEWEST_IN_HASTE = 200
# Runs that shrinking may take, however slow the controller is.
_FEWEST_RUNS = 50
# Details that do not apply to the new world.
_OF_THE_OLD_WORLD = (
    "boundaries",
    "chance",
    "states",
    "failing_seeds",
    "failing_share_at_least",
    CIRCUMSTANCE,
    GAP,
    *HAZARD_DETAILS,
)
_NOT_CHECKED: tuple[str, ...] = ("not checked: stopped early",)

Progress = Callable[[World], None]


@dataclass(frozen=True)
class Shrunk:
    """The result of shrinking.

    Args:
        failure: The shrunk failure, with new certificate, evidence and digest.
        before: Solid cells before.
        after: Solid cells now.
        simulations: Number of runs that shrinking took.
        left: Parts that could still be removed; empty if the world is 1-minimal.
        complete: True if every pass finished before the time was up.
        interrupted: True if Ctrl-C ended it.
    """

    failure: Failure
    before: int
    after: int
    simulations: int
    left: tuple[str, ...]
    complete: bool
    interrupted: bool = False


def shrink(
    failure: Failure,
    *,
    seconds: float | None = None,
    most_steps: float = math.inf,
    progress: Progress | None = None,
    keep_on_interrupt: bool = False,
) -> Shrunk:
    """Make a failure's world as small as possible, keeping its certificate.

    It keeps the verdict and the cause, and what the failure's campaign fixed, according to its
    record.

    Args:
        failure: The failure to shrink.
        seconds: Stop after this time with the best result so far. If omitted, the amount of work
            does not depend on the clock.
        most_steps: Stop after about this many steps with the best result so far; each run counts as
            many as the failure takes.
        progress: Called with each simpler world.
        keep_on_interrupt: On Ctrl-C, return the best result so far instead of raising.

    Returns:
        The shrunk failure.

    Raises:
        InvalidParameter: If it does not fail, or no longer fails.
    """
    deadline = None if seconds is None else time.monotonic() + seconds
    reducer = _Reducer(failure, deadline, most_steps, progress)
    try:
        reducer.run()
    except KeyboardInterrupt:
        if not keep_on_interrupt:
            raise
        return replace(reducer.result(), interrupted=True)
    return reducer.result()


class _Reducer:
    """Holds the simplest case so far, so that the deadline or Ctrl-C can stop it at any time."""

    def __init__(
        self, failure: Failure, deadline: float | None, most_steps: float, progress: Progress | None
    ) -> None:
        self._failure = failure
        self._deadline = deadline
        self._progress = progress
        steps = _steps_to_fail(failure)
        self._most_runs = max(most_steps / max(steps, 1), _FEWEST_RUNS)
        self._still_fails = _judge(failure, steps)
        # A campaign limits the steps for a slow controller; with a time limit, its runs have shown it.
        if most_steps < math.inf or (deadline is not None and _is_slow(failure)):
            self._still_fails.tried_budget = _budget_in_haste(failure)
        self._best = self._begin = Case(failure.world.bare, self._still_fails.scenario)
        constraint = Constraint.recorded(failure.record.details)
        self._trying = Trying(self._still_fails, self._is_over, constraint)
        # The last case that was confirmed, and its failure.
        self._made: tuple[Case, Failure] | None = None
        self._left = _NOT_CHECKED
        self._complete = False

    def run(self) -> None:
        """Run the passes, then check their result.

        If the quick judgement turns out to be wrong in the end, run once more with exact judgement.
        """
        with contextlib.suppress(TimeoutError, OutOfTime), self._stopping():
            for careful in (False, True):
                self._trying.careful = careful
                self._reduce()
                if self._holds():
                    self._complete = True
                    self._left = ()
                    return
                self._best = self._begin

    def _is_over(self) -> bool:
        """Return True if the time is over, or enough runs are made."""
        if self._still_fails.simulations >= self._most_runs:
            return True
        return self._deadline is not None and time.monotonic() > self._deadline

    def _stopping(self) -> contextlib.AbstractContextManager[None]:
        """Let the deadline end even the current trial, which can be long with a slow controller."""
        end = self._deadline
        return (
            contextlib.nullcontext()
            if end is None
            else stopping_when(lambda: time.monotonic() > end)
        )

    def _reduce(self) -> None:
        """Run passes until none makes the failure simpler and the check finds nothing removable."""
        while True:
            self._exhaust_all()
            found = next(removed(self._best.world, self._judged_in_time), None)
            if found is None:
                return
            self._take(self._best._replace(world=found[1].bare))

    def result(self) -> Shrunk:
        """Return the simplest case that is confirmed, with its record.

        Raises:
            InvalidParameter: If the oracle confirms none of them.
        """
        if not self._holds():
            self._best = self._begin
            self._left = _NOT_CHECKED
            self._complete = False
        if not self._holds() or self._made is None:
            raise InvalidParameter(
                "not-confirmed",
                "the shrunk world of {verdict!r} was not confirmed by its oracle",
                "replay the original file: worldgen replay",
                at_terminal=True,
                verdict=self._still_fails.verdict,
            )
        case, made = self._made
        return Shrunk(
            self._with_details(made, case.scenario),
            before=self._failure.world.solid_cells,
            after=made.world.solid_cells,
            simulations=self._still_fails.simulations,
            left=self._left,
            complete=self._complete,
        )

    def _with_details(self, made: Failure, scenario: Scenario) -> Failure:
        """Return the failure with details of the original, the new world and the shrinking."""
        came = self._failure.record.details
        details: dict[str, Value] = {"original": self._failure.id}
        details |= {name: value for name, value in came.items() if name not in _OF_THE_OLD_WORLD}
        details |= made.record.details
        if self._still_fails.oracle.by_verdict:
            details |= seeds_that_fail(made.world, scenario)
        details |= {
            "shrunk_from": self._failure.world.solid_cells,
            "kept": CAUSE,
            "one_minimal": not self._left,
            SHRINKING: (ShrinkState.DONE if self._complete else ShrinkState.CUT_SHORT).value,
            "simulations": self._still_fails.simulations,
        }
        return replace(made, record=replace(made.record, details=details))

    def _judged_in_time(self, candidate: World) -> World | None:
        if self._is_over():
            raise TimeoutError
        return self._still_fails(candidate, self._best.scenario)

    def _exhaust_all(self) -> None:
        """Run every pass until a whole round changes nothing."""
        before = None
        while before is not self._best:
            before = self._best
            for simplify in PASSES:
                self._exhaust(simplify)

    def _exhaust(self, simplify: Pass) -> None:
        """Take every edit of a pass that still fails.

        After taking one, continue with the edits that follow it instead of starting over.
        """
        taken = self._trying.first(self._best, [*simplify.propose(self._best)], 0)
        while taken is not None:
            index, simpler = taken
            self._take(simpler)
            taken = self._trying.first(self._best, [*simplify.propose(self._best)], index)

    def _take(self, simpler: Case) -> None:
        self._best = simpler
        if self._progress is not None:
            self._progress(simpler.world)

    def _holds(self) -> bool:
        """Return True if the exact judge and the oracle confirm the simplest case so far.

        If they do, keep its failure.
        """
        if self._made is not None and self._made[0] is self._best:
            return True
        proved = self._still_fails(*self._best)
        made = None if proved is None else self._recorded(proved)
        if made is not None:
            self._made = self._best, made
        return made is not None

    def _recorded(self, proved: World) -> Failure | None:
        """Return the failure with its record, or ``None`` if its oracle does not confirm it."""
        oracle = self._still_fails.oracle
        budget = self._still_fails.proof_budget
        return failure_of(proved, self._best.scenario, oracle, steps=budget)


def _judge(failure: Failure, steps: int) -> StillFails:
    """Return a judge that agrees that the original fails.

    Args:
        failure: The original.
        steps: Number of steps after which it is certain.

    Raises:
        InvalidParameter: If it does not fail.
    """
    record = failure.record
    options = failure.options
    # The run decides, whatever the file says.
    cause = cause_of(failure)
    if cause.severity in SHOWN_BY_THE_RUN:
        others = OtherWorlds(record.controller, options)
        cause = cause_of_run(failure.world, failure.run(), others)
    # Try a generous budget first. With more steps an overlap may end as a tunnel; then use the
    # recorded budget.
    more = _MORE_STEPS * steps + _FEWEST_STEPS
    for budget in (min(more, MAX_STEPS), options.steps):
        still_fails = StillFails.of(failure, budget, cause=cause)
        if still_fails(failure.world.bare) is not None:
            return still_fails
    by = "" if failure.oracle is None else f" with a violation of oracle {failure.oracle}"
    raise InvalidParameter(
        "does-not-fail-so",
        "{controller} under {motion} does not end as {verdict!r}{by} in this world, or its target "
        "is not {reach}",
        "replay the file first: worldgen replay",
        at_terminal=True,
        controller=record.controller,
        motion=record.motion,
        verdict=record.verdict,
        by=by,
        reach="walled off" if still_fails.breach else "reachable",
    )


def _is_slow(failure: Failure) -> bool:
    origin = origin_of(CONTROLLERS.get(failure.record.controller))
    return origin is not None and origin.answers.is_trusted


def _budget_in_haste(failure: Failure) -> int | None:
    """Return a budget in which most loops of simpler worlds end; ``None`` if there is no loop.

    The check that nothing can be removed has the full budget, so what this misses is made up for.
    """
    loop = failure.evidence
    if not isinstance(loop, LoopEvidence):
        return None
    return _LONGER_LOOP * (loop.entry + loop.period) + _FEWEST_IN_HASTE


def _steps_to_fail(failure: Failure) -> int:
    """Return the number of steps after which the failure is certain."""
    evidence = failure.evidence
    if isinstance(evidence, WallEvidence) and evidence.reached is not None:
        return evidence.reached
    return simulate(failure.world, failure.record.controller, failure.options).steps
