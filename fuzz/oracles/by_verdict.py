"""The oracles that judge every run by its verdict.

A robot should arrive if it can, and should stay out if its target is walled off.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from fuzz.facts.proofs import walled_off
from fuzz.facts.signature import failure_class
from fuzz.oracles.oracle import Oracle
from fuzz.oracles.trial import Trial
from fuzz.violation import Violation
from sim.evidence import WallEvidence
from sim.verdict import ARRIVALS, Verdict
from worldgen.world import Cut, World


@dataclass(frozen=True)
class VerdictOracle(Oracle):
    """Finds a run that does not end ``reached`` although the target can be reached."""

    def check(self, trial: Trial) -> Violation | None:
        """Return the verdict as a violation, if it is one."""
        if isinstance(trial.world.certificate, Cut) or trial.episode.verdict in ARRIVALS:
            return None
        recorded = trial.recorded_run
        return Violation(failure_class(trial.world, recorded), recorded.evidence)


@dataclass(frozen=True)
class BreachOracle(Oracle):
    """Finds a robot that goes through a wall and could continue to its walled-off target."""

    def prove(self, world: World) -> World | None:
        """Return the world with a cut around its target.

        ``None`` if the target is not provably walled off.
        """
        return walled_off(world)

    def check(self, trial: Trial) -> Violation | None:
        """Return the breach; its evidence names the step in which the robot would arrive."""
        from fuzz.evidence_checks.breach import check_breach  # noqa: PLC0415 - breaches are rare

        wall = trial.episode.evidence
        is_through_a_wall = trial.episode.verdict == Verdict.TUNNEL and isinstance(
            trial.world.certificate, Cut
        )
        if not is_through_a_wall or not isinstance(wall, WallEvidence) or trial.trace is None:
            return None
        if trial.options.motion_model().on_lattice:
            return None
        # Run it again with walls that do not end the run, to see if the robot gets to the target.
        whole = trial.again(record=True, thesis=replace(trial.options.thesis, keep_going=True))
        if whole.verdict != Verdict.REACHED or whole.trace is None:
            return None
        wall = replace(wall, reached=whole.steps)
        if check_breach(trial.world, trial.trace, whole.trace, wall):
            return None
        recorded = replace(trial.episode, evidence=wall, trace=trial.trace)
        return Violation(failure_class(trial.world, recorded), wall)


VERDICT = VerdictOracle()
BREACH = BreachOracle()


def verdict_oracle(world: World) -> Oracle:
    """Return the oracle that judges runs in a world by their verdict.

    The world's certificate decides whether arriving is right or wrong.
    """
    return BREACH if isinstance(world.certificate, Cut) else VERDICT
