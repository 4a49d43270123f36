"""The door through which failures of every lane come.

Certified, run again, judged by oracles, classified.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from typing import Any

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.deadline import NO_DEADLINE, Deadline
from fuzz.campaign.result import UnitResult
from fuzz.failure import Failure
from fuzz.oracles import BREACH, VERDICT, NamedOracle, Oracle, Trial
from fuzz.triage.crash_bucket import crash_bucket
from fuzz.triage.judging import failure_of
from fuzz.triage.proofs import certified
from sim.controllers import CONTROLLERS, ProcessController
from sim.outcome import LIMIT, Outcome
from sim.runners.stopping import OutOfTime, check_time, stopping_when
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.world import World

__all__ = ["Triage", "first_look"]

_PROOF_STEPS = 60_000  # budget in which a failing run may close its loop
# Failing runs of one verdict and cause that a unit proves and classifies; the rest it counts.
_PROVE_AT_MOST = 24
_PROVE_HANGS_AT_MOST = 2  # likewise, for each run that hangs costs a whole deadline, several times


class Triage:
    """Turns runs that look like failures into failures, and keeps the smallest of each class in a unit's result.

    Args:
        config: The campaign's.
        result: Of the unit; runs are counted and failures kept there.
        deadline: Of the unit.
    """

    def __init__(
        self, config: CampaignConfig, result: UnitResult, deadline: Deadline = NO_DEADLINE
    ) -> None:
        self._config = config
        self.result = result
        self._deadline = deadline
        self._oracles = [NamedOracle.parse(text) for text in config.oracles]
        self._failed: Counter[tuple[str, str]] = Counter()
        controller = CONTROLLERS.get(config.scenario.controller)
        self._proof_steps = _PROOF_STEPS // config.slower
        if isinstance(controller, ProcessController):  # of which no loop can be proved
            self._proof_steps = 0

    def stop(self) -> None:
        """End the unit's time now, after Ctrl-C: what it met is still proved, but not for long."""
        self._deadline = self._deadline.stopped_now()

    def count(self, verdict: str, steps: int) -> None:
        """Counts one run."""
        self.result.worlds += 1
        self.result.steps += steps
        self.result.verdicts[verdict] += 1

    def look(self, world: World, scenario: Scenario, outcome: Outcome) -> str:
        """Counts a run at first look; if it does not arrive it is proved.

        Oracles that are asked for judge it.

        Returns:
            The class of a failure; empty if there is none.

        Raises:
            OutOfTime: If the unit's time is over, once the run is counted and, if it failed,
                proved.
        """
        verdict = first_look(outcome)
        self.count(verdict, outcome.steps)
        # Crashes are counted by bucket, or one that occurs in every run would keep all others from
        # being proved.
        cause = (
            crash_bucket(outcome.fault)
            if outcome.fault and verdict == Verdict.CRASH
            else outcome.cause
        )
        kind = "" if verdict == Verdict.REACHED else self.enter(world, scenario, verdict, cause)
        check_time()
        return self.ask(world, scenario) or kind

    def enter(
        self, world: World, scenario: Scenario, verdict: str, cause: str = "", **details: Any
    ) -> str:
        """Proves, classifies and keeps a run that failed, if not too many of its kind came before.

        Args:
            world: Where, with or without certificate.
            scenario: What ran.
            verdict: At first look; ``breach`` for a robot that got to a walled-off target.
            cause: Of the verdict, as far as the core knows it.
            **details: What the failure's record is to say besides.

        Returns:
            Its class; empty if it was not kept.
        """
        if not self._is_one_of_few(verdict, cause):
            return ""
        if verdict == "undecided":  # perhaps no failure at all, and the dearest of all proofs
            with contextlib.suppress(OutOfTime):
                check_time()
                return self._proved(world, scenario, verdict, details)
            return ""
        with stopping_when(self._deadline.to_prove_is_over):  # a failure counts when it is met
            check_time()
            return self._proved(world, scenario, verdict, details)

    def _proved(
        self, world: World, scenario: Scenario, verdict: str, details: dict[str, Any]
    ) -> str:
        """Prove, classify and keep a run; return its class, or nothing if it is no failure."""
        if verdict == "breach":
            steps = scenario.options(world).steps
            return self._judged(BREACH, BREACH.prove(world), scenario, steps=steps, **details)
        return self._judged(
            VERDICT, _with_witness(world), scenario, fewest_steps=self._proof_steps, **details
        )

    def ask(self, world: World, scenario: Scenario) -> str:
        """Let every oracle that was asked for judge the run, with its witness's budget.

        Return the last one's class.
        """
        proved = _with_witness(world) if self._oracles else None
        if proved is None:
            return ""
        kept = ""
        trial = Trial(proved, scenario.controller, scenario.options(proved))
        for oracle in self._oracles:
            found = oracle.check(trial)
            if found is not None and self._is_one_of_few("oracle", found.bucket):
                kept = self._judged(oracle, proved, scenario) or kept
        return kept

    def _judged(
        self, oracle: Oracle, world: World | None, scenario: Scenario, **settings: Any
    ) -> str:
        """Judge a run in a proved world and keep the failure.

        Return its class, or nothing if there is none.
        """
        if world is not None:
            # A run that is too long to be recorded is nothing that could be shown.
            with contextlib.suppress(InvalidParameter):
                return self._keep(
                    failure_of(world, scenario, oracle, found_by=self.result.lane, **settings)
                )
        return ""

    def _is_one_of_few(self, verdict: str, cause: str) -> bool:
        self._failed[verdict, cause] += 1
        return self._failed[verdict, cause] <= (
            _PROVE_HANGS_AT_MOST if verdict == Verdict.HANG else _PROVE_AT_MOST
        )

    def _keep(self, failure: Failure | None) -> str:
        if failure is None:
            return ""
        kind = failure.bucket
        self.result.met[kind] += 1
        before = self.result.failures.get(kind)
        if before is None or failure.size < before.size:
            self.result.failures[kind] = failure
        return kind


def _with_witness(world: World) -> World | None:
    return world if world.certificate else certified(world)


def first_look(outcome: Outcome) -> str:
    """The verdict of a run whose budget was short: ``undecided`` where it was spent."""
    if outcome.ending == LIMIT:
        return Verdict.OVERLAP if outcome.overlap_step >= 0 else "undecided"
    overlaps = outcome.overlap_step >= 0 and outcome.ending in (Verdict.REACHED, Verdict.LOOP)
    return Verdict.OVERLAP if overlaps else outcome.ending
