"""Triage: certify, repeat, judge and classify the failures of every search strategy."""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from typing import Any

from fuzz.facts.crash_bucket import crash_bucket
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.oracles import BREACH, VERDICT, NamedOracle, Oracle, Trial
from fuzz.simplicity import Case
from fuzz.triage.judging import judge
from fuzz.unit.config import CampaignConfig
from fuzz.unit.deadline import NO_DEADLINE, Deadline
from fuzz.unit.live import count_live
from fuzz.unit.result import FailureKey, FirstMet, UnitResult
from sim.clock.stopping import OutOfTime, check_time, stopping_when
from sim.controllers import CONTROLLERS, ProcessController
from sim.outcome import LIMIT, Outcome
from sim.scenario import Scenario
from sim.verdict import ARRIVALS, Verdict
from worldgen.errors import InvalidParameter
from worldgen.world import World

UNDECIDED = "undecided"
"""What is counted as the verdict of a run that spent a short budget."""

_PROOF_STEPS = 60_000  # budget in which a failing run may close its loop
# Failing runs with the same verdict and cause that a unit proves and classifies; it only counts
# the rest.
_PROVE_AT_MOST = 24
_PROVE_HANGS_AT_MOST = 2  # far fewer, because each hang takes a whole deadline, several times


class Triage:
    """Turns runs that look like failures into failures, and keeps the simplest of each signature.

    Args:
        config: The campaign's configuration.
        result: The unit's result, in which runs are counted and failures kept.
        deadline: The unit's deadline.
    """

    def __init__(
        self, config: CampaignConfig, result: UnitResult, deadline: Deadline = NO_DEADLINE
    ) -> None:
        self._config = config
        self.result = result
        self._deadline = deadline
        self._oracles = [NamedOracle.parse(text) for text in config.oracles]
        # Failed runs, those of them that were examined, and those that this settled, by kind.
        self._failed: Counter[tuple[str, str]] = Counter()
        self._examined: Counter[tuple[str, str]] = Counter()
        self._settled: Counter[tuple[str, str]] = Counter()
        # By key, the worlds and steps until the first failure, and the time.
        self._first_met: dict[FailureKey, tuple[int, int, float]] = {}
        controller = CONTROLLERS.get(config.scenario.controller)
        self._proof_steps = _PROOF_STEPS // config.pace.slower
        # The memory of a program is unknown, so that its loops cannot be proved.
        # At a slow controller's pace, a longer budget than the witness's would cost too much.
        if isinstance(controller, ProcessController) or config.pace.is_slow:
            self._proof_steps = 0

    def end(self) -> None:
        """Record when failures were met, once the unit is over."""
        now = time.monotonic()
        self.result.first_met = {
            key: FirstMet(worlds, steps, round(now - at, 3))
            for key, (worlds, steps, at) in self._first_met.items()
        }

    def stop(self) -> None:
        """End the unit soon after Ctrl-C; until then, failures found so far may still be proved."""
        self._deadline = self._deadline.stopped_now()

    def count(self, verdict: str, steps: int) -> None:
        """Count one run."""
        self.result.worlds += 1
        self.result.steps += steps
        self.result.verdicts[verdict] += 1
        count_live(verdict, 1, steps)

    def look(self, world: World, scenario: Scenario, outcome: Outcome) -> None:
        """Count a screening run; if it does not arrive, prove its failure.

        The oracles that the user chose judge it too.

        Raises:
            OutOfTime: If the unit's time is over. The run has then been counted and, if it failed,
                proved.
        """
        verdict = first_look(outcome)
        # Count crashes by bucket. Otherwise a failure that occurs in every run would use up the
        # limit and keep all others from being proved.
        cause = (
            crash_bucket(outcome.fault)
            if outcome.fault and verdict == Verdict.CRASH
            else outcome.cause
        )
        self.look_at(world, scenario, verdict, outcome.steps, cause)

    def look_at(
        self, world: World, scenario: Scenario, verdict: str, steps: int, cause: str = ""
    ) -> None:
        """Do the same for a run whose verdict is known.

        Args:
            world: The world, with or without a certificate.
            scenario: The scenario that ran.
            verdict: Its verdict, or ``undecided``.
            steps: Number of steps that it took.
            cause: Cause of the verdict, if the core knows it.

        Raises:
            OutOfTime: If the unit's time is over.
        """
        self.count(verdict, steps)
        if verdict not in ARRIVALS:
            self.enter(world, scenario, verdict, cause)
        check_time()
        self.ask(world, scenario)

    def enter(
        self, world: World, scenario: Scenario, verdict: str, cause: str = "", **details: Any
    ) -> None:
        """Prove, classify and keep a failed run, unless there were too many of its kind.

        Args:
            world: The world, with or without a certificate.
            scenario: The scenario that ran.
            verdict: Verdict of the screening run; ``breach`` if the robot got to a walled-off
                target.
            cause: Cause of the verdict, if the core knows it.
            **details: Further details for the failure's record.
        """
        if not self._is_one_of_few(verdict, cause):
            self.count_alike(verdict, cause, 1)
            return
        self._examined[verdict, cause] += 1
        # An undecided run may not be a failure at all, and is the most expensive to prove, unless it
        # has already spent the witness's budget.
        if verdict == UNDECIDED and details.get("known") is None:
            with contextlib.suppress(OutOfTime):
                check_time()
                self._prove(world, scenario, verdict, cause, details)
            return
        # A failure counts as soon as it is found, so its proof may exceed the unit's time.
        with stopping_when(self._deadline.to_prove_is_over):
            check_time()
            self._prove(world, scenario, verdict, cause, details)

    def count_alike(self, verdict: str, cause: str, runs: int) -> None:
        """Count failed runs that are not examined: the examined ones of their kind stand for them.

        Args:
            verdict: Their verdict in screening.
            cause: Cause of the verdict, as for :meth:`enter`.
            runs: Number of runs.
        """
        kind = (verdict, cause)
        if self._examined[kind] and self._settled[kind] == self._examined[kind]:
            self.result.judged += runs

    def examined(self, verdict: str, cause: str) -> int:
        """Return the number of runs of a kind that were examined."""
        return self._examined[verdict, cause]

    def _prove(
        self, world: World, scenario: Scenario, verdict: str, cause: str, details: dict[str, Any]
    ) -> None:
        if verdict == "breach":
            steps = scenario.options(world).steps
            is_settled = self._judge(BREACH, BREACH.prove(world), scenario, steps=steps, **details)
        else:
            is_settled = self._judge(
                VERDICT, _with_witness(world), scenario, fewest_steps=self._proof_steps, **details
            )
        self.result.judged += is_settled
        self._settled[verdict, cause] += is_settled

    def ask(self, world: World, scenario: Scenario) -> None:
        """Let every oracle that the user chose judge the run, with its witness's budget."""
        proved = _with_witness(world) if self._oracles else None
        if proved is None:
            return
        trial = Trial(proved, scenario.controller, scenario.options(proved))
        for oracle in self._oracles:
            found = oracle.check(trial)
            if found is not None and self._is_one_of_few("oracle", found.bucket):
                self._judge(oracle, proved, scenario)

    def _judge(
        self, oracle: Oracle, world: World | None, scenario: Scenario, **settings: Any
    ) -> bool:
        """Judge a run in a proved world and keep the failure; return whether that is settled."""
        # No robot can be blamed for a target that cannot be reached.
        if world is None:
            return True
        # A run that is too long to be recorded could not be shown, so it is dropped.
        with contextlib.suppress(InvalidParameter):
            settings |= self._config.constraint.details()
            # Runs in other worlds would delay a slow controller's failure. Shrinking makes them.
            config = self._config
            elsewhere = not (config.pace.is_slow and config.shrink and config.robots == 1)
            found = judge(
                world,
                scenario,
                oracle,
                found_by=self.result.strategy,
                elsewhere=elsewhere,
                **settings,
            )
            self._keep(found.failure)
            return found.is_settled
        return False

    def _is_one_of_few(self, verdict: str, cause: str) -> bool:
        self._failed[verdict, cause] += 1
        return self._failed[verdict, cause] <= (
            _PROVE_HANGS_AT_MOST if verdict == Verdict.HANG else _PROVE_AT_MOST
        )

    def _keep(self, failure: Failure | None) -> None:
        if failure is None:
            return
        # A failure of another robot is not the user's. Its strategy also ran worlds of that robot
        # that did not fail, so dropping the failure would leave false counts: the unit ends.
        violated = self._config.constraint.violated_by(Case(failure.world, failure.scenario))
        if violated:
            raise RuntimeError(
                f"strategy {self.result.strategy!r} changed what the campaign fixes: "
                f"{', '.join(violated)}"
            )
        self.result.met[failure.group, failure.verdict] += 1
        self._first_met.setdefault(
            failure.key, (self.result.worlds, self.result.steps, time.monotonic())
        )
        before = self.result.failures.get(failure.key)
        if before is None or failure.order < before.order:
            self.result.failures[failure.key] = failure


def _with_witness(world: World) -> World | None:
    return world if world.certificate else certified(world)


def first_look(outcome: Outcome) -> str:
    """Return the verdict of a run with a short budget; ``undecided`` if it used all of it."""
    if outcome.ending == LIMIT:
        return Verdict.OVERLAP if outcome.overlap_step >= 0 else UNDECIDED
    overlaps = outcome.overlap_step >= 0 and outcome.ending in (*ARRIVALS, Verdict.LOOP)
    return Verdict.OVERLAP if overlaps else outcome.ending
