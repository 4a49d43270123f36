"""Decide whether a simpler world still fails in the same way and still has a certificate."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

from fuzz.cause import CAUSE, Cause, Severity
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.crash_bucket import crash_bucket, has_facts
from fuzz.facts.signature import standoff
from fuzz.failure import Failure, regardless_of_walls
from fuzz.oracles import BREACH, VERDICT, NamedOracle, Oracle, Trial
from fuzz.triage.diagnosis import cause_of, cause_of_run
from fuzz.triage.judging import oracle_of
from sim.controllers import CONTROLLERS, Controller
from sim.controllers.answers import leaving_proofs
from sim.episode import prepare, simulate
from sim.evidence import BudgetEvidence, Evidence, FaultEvidence, JointLoopEvidence, WallEvidence
from sim.options.run import RunOptions
from sim.outcome import Outcome
from sim.scenario import Scenario
from sim.verdict import (
    ARRIVALS,
    AT_ONCE,
    BY_THE_CONTROLLER,
    FAILURES,
    JOINT_LOOPS,
    OUT_OF_BUDGET,
    UNENDED,
    Verdict,
)
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.world import World

_PROVED_BY_THE_RUN = tuple(verdict for verdict in FAILURES if verdict not in OUT_OF_BUDGET)
# Severities of the causes that the verdict does not imply and the run alone shows.
SHOWN_BY_THE_RUN = (Severity.HARMED, Severity.NEVER_ARRIVES, Severity.TOO_SLOW)
_SHOWN_BY_ITS_END = tuple(verdict for verdict in FAILURES if verdict not in UNENDED)


def _manner_of(evidence: Evidence | None) -> str:
    """Return the property that a shrunk failure keeps in addition to its verdict; empty if none."""
    match evidence:
        case WallEvidence(cause=cause):
            return cause or ""
        case BudgetEvidence(kind=kind):
            return kind or ""
        case FaultEvidence() as fault if has_facts(fault):
            return crash_bucket(fault)
        case JointLoopEvidence() as joint:
            return standoff(joint)
    return ""


@dataclass
class StillFails:
    """Judges candidates, and counts the simulations needed for that.

    Args:
        scenario: The scenario to run.
        verdict: The verdict to keep.
        budget: Steps for verdicts that the run itself proves; others get the budget of their
            candidate's witness.
        oracle: The oracle that must still find a violation.
        manner: Property to keep in addition to the verdict: the cause of a tunnel or overlap, the
            kind of a stalled run, the bucket of a crash; empty for any.
        cause: The cause to keep as well; ``None`` for any.
        rule: Name of a user's oracle's kind of violation, which is kept as well; else empty.
        tried_budget: Steps for the first attempt at a candidate of such a verdict, which may miss
            some that fail; the budget if omitted.
    """

    scenario: Scenario
    verdict: str
    budget: int
    oracle: Oracle = VERDICT
    manner: str = ""
    cause: Cause | None = None
    rule: str = ""
    tried_budget: int | None = None
    simulations: int = 0

    @classmethod
    def of(
        cls, failure: Failure, budget: int | None = None, *, cause: Cause | None = None
    ) -> StillFails:
        """Return the predicate that keeps what a failure's record states.

        Args:
            failure: The failure to shrink.
            budget: See the class; the recorded budget if omitted.
            cause: See the class; if omitted, the recorded cause, provided that shrinking kept it.
        """
        oracle = oracle_of(failure)
        rule = ""
        if isinstance(oracle, NamedOracle):
            rule = oracle.bucket_of(failure.violation.facts)
        elif cause is None and failure.record.details.get("kept") == CAUSE:
            cause = cause_of(failure)
        return cls(
            failure.scenario,
            failure.verdict,
            failure.options.steps if budget is None else budget,
            oracle,
            manner=_manner_of(failure.evidence),
            cause=cause if cause is not None and cause.severity in SHOWN_BY_THE_RUN else None,
            rule=rule,
        )

    @property
    def breach(self) -> bool:
        """True if the target must stay walled off, but be reached when walls are ignored."""
        return self.oracle == BREACH

    @property
    def is_proved_by_the_run(self) -> bool:
        """True if the run itself proves the verdict, within any budget."""
        return self.verdict in _PROVED_BY_THE_RUN

    @property
    def proof_budget(self) -> int | None:
        """Budget that the final failure must have; ``None`` if its witness decides."""
        return self.budget if self.is_proved_by_the_run else None

    @property
    def least_budget(self) -> int:
        """Smallest budget of any candidate, in steps."""
        if self.is_proved_by_the_run:
            return self.tried_budget or self.budget
        return self.scenario.budget.fewest

    @functools.cached_property
    def controller(self) -> Controller:
        """The controller that runs."""
        return CONTROLLERS.get(self.scenario.controller)

    def __call__(self, candidate: World, scenario: Scenario | None = None) -> World | None:
        """Return the candidate with a new certificate if it fails the same way, else ``None``.

        Args:
            candidate: A simpler world.
            scenario: The scenario, if that was simplified too.
        """
        scenario = scenario or self.scenario
        try:
            with leaving_proofs():
                return self._failing(candidate, scenario)
        except (InvalidWorld, InvalidParameter):
            return None

    def seems_to_fail(self, candidate: World, scenario: Scenario) -> bool:
        """Return True if one unrecorded run with the smallest budget ends as it should.

        This is not a proof, and does not need a certificate.
        """
        try:
            self.simulations += 1
            return self._seems_so(candidate, scenario.options(candidate, self.least_budget))
        except (InvalidWorld, InvalidParameter):
            return False

    def keeps_cause(self, candidate: World, scenario: Scenario) -> bool:
        """Return True if a candidate that fails has the cause to keep.

        It needs no certificate if the run itself proves the verdict.
        """
        with leaving_proofs():
            return self._has_cause(candidate, scenario.options(candidate, self.least_budget))

    def _has_cause(self, world: World, options: RunOptions) -> bool:
        if self.cause is None:
            return True
        episode = simulate(world, self.controller, options, record=True)
        # Several robots may have to be told from one that fails alone.
        others = OtherWorlds(self.scenario.controller, options) if world.is_fleet else None
        return cause_of_run(world, episode, others) == self.cause

    def _failing(self, candidate: World, scenario: Scenario) -> World | None:
        # Run first and prove later where possible: a run costs less than a certificate.
        if not self.oracle.by_verdict:
            return self._objected_to(candidate, scenario)
        if self.is_proved_by_the_run:
            options = scenario.options(candidate, self.budget)
            if not self._fails(candidate, options):
                return None
            proved = self.oracle.prove(candidate)
        else:
            proved = self.oracle.prove(candidate)
            if proved is None:
                return None
            options = scenario.options(proved)
            if not self._fails(proved, options):
                return None
        return proved if proved is not None and self._has_cause(proved, options) else None

    def _objected_to(self, candidate: World, scenario: Scenario) -> World | None:
        """Return the candidate with a new witness if the user's oracle finds the same."""
        proved = self.oracle.prove(candidate)
        if proved is None:
            return None
        self.simulations += 1
        trial = Trial(proved, scenario.controller, scenario.options(proved))
        found = self.oracle.check(trial)
        return proved if found is not None and found.bucket == self.rule else None

    def _fails(self, world: World, options: RunOptions) -> bool:
        self.simulations += 1
        if not self._seems_so(world, options):
            return False
        if world.is_fleet:
            return True
        if self.verdict == Verdict.TUNNEL:
            return self._arrives(world, options)
        if self.verdict in _SHOWN_BY_ITS_END:
            return True
        episode = simulate(world, self.controller, options)
        manner = episode.evidence.kind if isinstance(episode.evidence, BudgetEvidence) else None
        return episode.verdict == self.verdict and self._is_same_manner(manner)

    def _seems_so(self, world: World, options: RunOptions) -> bool:
        """Return True if a run ends as it should, with its proof if there are several robots."""
        if not world.is_fleet:
            takes_several = self.verdict in (*JOINT_LOOPS, Verdict.COLLISION)
            return not takes_several and self._ends_so(self._run(world, options))
        episode = simulate(world, self.controller, options)
        return episode.verdict == self.verdict and self._is_same_manner(
            _manner_of(episode.evidence)
        )

    def _ends_so(self, outcome: Outcome) -> bool:
        """Return True if a run ends as the verdict requires, as far as its end shows that."""
        # The end of the run decides these.
        if self.verdict == Verdict.TUNNEL:
            return outcome.ending == Verdict.TUNNEL and self._is_same_manner(outcome.cause)
        if self.verdict == Verdict.CRASH:
            return outcome.ending == Verdict.CRASH and self._is_same_crash(outcome)
        if self.verdict in (Verdict.CONTACT, Verdict.BURNED, *BY_THE_CONTROLLER):
            return outcome.ending == self.verdict
        if outcome.ending in AT_ONCE:
            return False
        if self.verdict == Verdict.OVERLAP:
            return outcome.overlap_step >= 0 and self._is_same_manner(outcome.cause)
        # A run that overlaps a wall or arrives is neither a loop nor out of budget.
        if outcome.overlap_step >= 0 or outcome.ending in ARRIVALS:
            return False
        return outcome.ending == Verdict.LOOP or self.verdict != Verdict.LOOP

    def _run(self, world: World, options: RunOptions) -> Outcome:
        return prepare(world, self.controller, options).run(
            options.steps, find_loop=True, record=False, digest=False
        )

    def _is_same_crash(self, outcome: Outcome) -> bool:
        if not self.manner:
            return True
        fault = replace(outcome.fault or FaultEvidence(), step=outcome.steps)
        return crash_bucket(fault) == self.manner

    def _is_same_manner(self, manner: object) -> bool:
        return self.manner in ("", manner)

    def _arrives(self, world: World, options: RunOptions) -> bool:
        """Return True unless this is a breach whose robot fails to arrive with walls ignored."""
        return (
            not self.breach
            or self._run(world, regardless_of_walls(options)).ending == Verdict.REACHED
        )
