"""Whether a simpler world still fails in the same manner, and still carries a certificate."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

from fuzz.failure import Failure, regardless_of_walls
from fuzz.oracles import Asked, Trial
from fuzz.triage.crash_bucket import crash_bucket, has_facts
from fuzz.triage.judging import judge
from fuzz.triage.proofs import certified, walled_off
from fuzz.triage.signature import failure_class
from sim.controllers import CONTROLLERS, Controller
from sim.episode import prepare, simulate
from sim.evidence import BudgetEvidence, Evidence, FaultEvidence, WallEvidence
from sim.options.run import FEWEST_STEPS, RunOptions
from sim.outcome import Outcome
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER, FAILURES, UNENDED, Verdict
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.world import World

__all__ = ["StillFails"]

_PROVED_BY_THE_RUN = tuple(verdict for verdict in FAILURES if verdict not in (Verdict.STALLED, Verdict.TIMEOUT))
_SHOWN_BY_ITS_END = tuple(verdict for verdict in FAILURES if verdict not in UNENDED)


def _manner_of(evidence: Evidence | None) -> str:
    """What a shrunk failure keeps beside its verdict; empty where anything will do."""
    match evidence:
        case WallEvidence(cause=cause):
            return cause or ""
        case BudgetEvidence(kind=kind):
            return kind or ""
        case FaultEvidence() as fault if has_facts(fault):
            return crash_bucket(fault)
    return ""


@dataclass
class StillFails:
    """Judges candidates; counts the simulations that it cost.

    Args:
        scenario: What runs.
        verdict: The verdict to keep.
        budget: Steps for verdicts that the run itself proves; others get the budget of their own witness.
        manner: What to keep in addition to the verdict: the cause of a tunnel or overlap, the kind of a stalled run,
            the bucket of a crash; empty for any.
        breach: Whether the target is to stay walled off, and to be reached regardless of walls.
        asked: The oracle that is to object still, for a failure by one; then the manner is its class.
        kind: The failure's class, where that is to stay as well; empty for any.
    """

    scenario: Scenario
    verdict: str
    budget: int
    manner: str = ""
    breach: bool = False
    asked: Asked | None = None
    kind: str = ""
    simulations: int = 0

    @classmethod
    def of(cls, failure: Failure, budget: int | None = None, *, kind: str | None = None) -> StillFails:
        """The predicate that keeps what a failure's record says.

        Args:
            failure: What is shrunk.
            budget: See above; the record's own where left out.
            kind: See above; where left out, the record's class if the record says that it was kept.
        """
        if kind is None:
            details = failure.record.details
            kind = failure.bucket if details.get("kept") == "class" and "class" in details else ""
        asked = None if failure.oracle is None else Asked.parse(failure.oracle)
        return cls(
            failure.scenario,
            failure.verdict,
            failure.options.steps if budget is None else budget,
            manner=_manner_of(failure.evidence) if asked is None else asked.kind(failure.objection),
            breach=failure.is_breach,
            asked=asked,
            kind=kind,
        )

    @property
    def is_proved_by_the_run(self) -> bool:
        """Whether the run itself proves the verdict, within any budget."""
        return self.verdict in _PROVED_BY_THE_RUN

    @property
    def proof_budget(self) -> int | None:
        """Budget that the final failure must have; ``None`` where its witness decides."""
        return self.budget if self.is_proved_by_the_run and self.asked is None else None

    @property
    def least_budget(self) -> int:
        """Steps that every candidate gets at least."""
        return self.budget if self.is_proved_by_the_run else FEWEST_STEPS

    @functools.cached_property
    def controller(self) -> Controller:
        """What runs."""
        return CONTROLLERS.get(self.scenario.controller)

    def __call__(self, candidate: World, scenario: Scenario | None = None) -> World | None:
        """The candidate with a fresh certificate if it still fails the same way, else ``None``.

        Args:
            candidate: A simpler world.
            scenario: What runs in it, if that got simpler too.
        """
        scenario = scenario or self.scenario
        try:
            return self._failing(candidate, scenario)
        except (InvalidWorld, InvalidParameter):
            return None

    def seems_to_fail(self, candidate: World, scenario: Scenario) -> bool:
        """Whether one unrecorded run of the least budget ends as it should; without proof, and without certificate."""
        try:
            self.simulations += 1
            return self._ends_so(self._run(candidate, scenario.options(candidate, self.least_budget)))
        except (InvalidWorld, InvalidParameter):
            return False

    def _failing(self, candidate: World, scenario: Scenario) -> World | None:
        if self.asked is not None:
            return self._objected(self.asked, candidate, scenario)
        if self.is_proved_by_the_run:
            options = scenario.options(candidate, self.budget)
            if not self._fails(candidate, options):
                return None
            proved = walled_off(candidate) if self.breach else certified(candidate)
        else:
            proved = certified(candidate)
            if proved is None:
                return None
            options = scenario.options(proved)
            if not self._fails(proved, options):
                return None
        if proved is None or not self.kind:
            return proved
        if self.breach:  # whose class hangs on where the robot gets to, walls or not
            episode, _ = judge(proved, scenario.controller, options)
        else:
            episode = simulate(proved, scenario.controller, options, record=True)
        return proved if failure_class(proved, episode) == self.kind else None

    def _objected(self, asked: Asked, candidate: World, scenario: Scenario) -> World | None:
        """The candidate with a fresh witness if the oracle objects in the same manner."""
        proved = certified(candidate)
        if proved is None:
            return None
        self.simulations += 1
        said = asked.objection(Trial(proved, scenario.controller, scenario.options(proved)))
        return proved if said is not None and asked.kind(said) == self.manner else None

    def _fails(self, world: World, options: RunOptions) -> bool:
        self.simulations += 1
        if not self._ends_so(self._run(world, options)):
            return False
        if self.verdict == Verdict.TUNNEL:
            return self._arrives(world, options)
        if self.verdict in _SHOWN_BY_ITS_END:
            return True
        episode = simulate(world, self.controller, options)
        manner = episode.evidence.kind if isinstance(episode.evidence, BudgetEvidence) else None
        return episode.verdict == self.verdict and self._likewise(manner)

    def _ends_so(self, outcome: Outcome) -> bool:
        """Whether a run ends as the verdict says, as far as its end shows it."""
        if self.verdict == Verdict.TUNNEL:
            return outcome.ending == Verdict.TUNNEL and self._likewise(outcome.cause)
        if self.verdict == Verdict.CRASH:
            return outcome.ending == Verdict.CRASH and self._is_same_crash(outcome)
        if self.verdict in (Verdict.BURNED, *BY_THE_CONTROLLER):
            return outcome.ending == self.verdict
        if outcome.ending in (Verdict.TUNNEL, Verdict.BURNED, *BY_THE_CONTROLLER):
            return False
        if self.verdict == Verdict.OVERLAP:
            return outcome.overlap_step >= 0 and self._likewise(outcome.cause)
        if outcome.overlap_step >= 0 or outcome.ending == Verdict.REACHED:
            return False
        return outcome.ending == Verdict.LOOP or self.verdict != Verdict.LOOP

    def _run(self, world: World, options: RunOptions) -> Outcome:
        return prepare(world, self.controller, options).run(options.steps, find_loop=True, record=False, digest=False)

    def _is_same_crash(self, outcome: Outcome) -> bool:
        if not self.manner:
            return True
        fault = replace(outcome.fault or FaultEvidence(), step=outcome.steps)
        return crash_bucket(fault) == self.manner

    def _likewise(self, manner: object) -> bool:
        return self.manner in ("", manner)

    def _arrives(self, world: World, options: RunOptions) -> bool:
        """For a breach, whether the robot arrives regardless of walls; else nothing is asked."""
        return not self.breach or self._run(world, regardless_of_walls(options)).ending == Verdict.REACHED
