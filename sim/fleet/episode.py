"""Run the controllers of several robots in one world, and return a verdict with its evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.controllers.base import Controller
from sim.controllers.catalogue import controller_of
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    CollisionEvidence,
    Evidence,
    FaultEvidence,
    JointLoopEvidence,
    ReachedEvidence,
)
from sim.fleet.assignment import assigned
from sim.fleet.run import FleetOutcome, FleetRun, JointProof
from sim.motion import MOTIONS
from sim.options.run import RunOptions
from sim.outcome import Episode, FleetEpisode, Outcome, area_of, wall_evidence
from sim.runners.decide import decide
from sim.trace import Trace, fnv1a, state_digest
from sim.verdict import BY_THE_CONTROLLER, OUT_OF_BUDGET, Verdict
from worldgen.errors import InvalidParameter
from worldgen.world import JointWitness, World

Named = str | Controller | type


def simulate_fleet(
    world: World,
    controllers: Named | Mapping[int, Named],
    options: RunOptions | Sequence[RunOptions],
    *,
    record: bool = False,
) -> FleetEpisode:
    """Run several robots until all arrive, or they provably never will.

    Args:
        world: The world to drive in.
        controllers: One for all robots, or one for each robot's number, from 1.
        options: How to run; one for all robots, or one for each, which differ in ``robot`` only.
        record: Whether to keep every state, as each robot's ``trace``.

    Raises:
        InvalidParameter: If robots and controllers do not fit each other, or an option is unknown.
        InvalidWorld: If a robot does not fit at its start.
    """
    run, each = _prepared(world, controllers, options)
    found = decide(
        run,
        each[0].steps,
        record=record,
        prove_otherwise=lambda steps: run.prove_apart(steps, record=record),
    )
    if isinstance(found, JointProof):
        return _joint_loop(world, each[0], found)
    return _decided(world, each[0], found)


def fleet_traces(
    world: World,
    controllers: Named | Mapping[int, Named],
    options: RunOptions | Sequence[RunOptions],
    steps: int,
) -> tuple[Trace | None, ...]:
    """Record each robot for this many steps, even if the joint state recurs earlier.

    A check of a joint loop needs this, because the run that found it ended after one period.

    Args:
        world: The world to drive in.
        controllers: As for :func:`simulate_fleet`.
        options: As for :func:`simulate_fleet`; their budget does not count.
        steps: Number of steps.
    """
    run = _prepared(world, controllers, options)[0]
    outcome = run.run(steps, find_loop=False, record=True)
    return tuple(member.trace for member in outcome.members)


def _prepared(
    world: World,
    controllers: Named | Mapping[int, Named],
    options: RunOptions | Sequence[RunOptions],
) -> tuple[FleetRun, list[RunOptions]]:
    """Return a run, and the options of each robot in it."""
    count = len(world.robots)
    named: list[Named] = assigned(controllers, count)
    found = [controller_of(one) for one in named]
    each = [options] * count if isinstance(options, RunOptions) else list(options)
    _check_options(each)
    return FleetRun(world, found, each), each


def _check_options(options: Sequence[RunOptions]) -> None:
    """Refuse options for a single robot, and robots under different motion models."""
    for one in options:
        if not MOTIONS.get(one.motion).on_lattice:
            raise InvalidParameter(
                "motion-for-one-robot",
                "motion {motion!r} runs one robot, and the world has several",
                "use --motion swept or endpoint",
                at_terminal=True,
                motion=one.motion,
            )
        if one.task != RunOptions.task:
            raise InvalidParameter(
                "option-for-one-robot",
                "task={task} is for worlds with one robot, and this one has {robots}",
                "omit it, or use a world with one robot",
                task=str(one.task),
                robots=len(options),
            )
        if one.robot.pushes or one.robot.push_places:
            raise InvalidParameter(
                "option-for-one-robot",
                "{option} is for worlds with one robot, and this one has {robots}",
                "omit it; drift and decoys also work with several robots",
                option="pushes" if one.robot.pushes else "push_places",
                robots=len(options),
            )
        if (one.motion, one.time_step) != (options[0].motion, options[0].time_step):
            raise InvalidParameter(
                "robots-move-differently",
                "the robots have motion {one} with steps of {first:g} s and motion {other} with "
                "steps of {second:g} s",
                "give them all the same motion model and time step",
                one=options[0].motion,
                first=options[0].time_step,
                other=one.motion,
                second=one.time_step,
            )


@dataclass(frozen=True)
class _Decision:
    """The outcome of a run of several robots.

    Args:
        world: The world.
        options: Options of the run.
        outcome: The core's claims.
        verdict: How it ended.
        evidence: The facts that confirm that.
        robot: Index of the robot that the verdict is about; -1 if it is about all.
    """

    world: World
    options: RunOptions
    outcome: FleetOutcome
    verdict: Verdict
    evidence: Evidence
    robot: int = -1

    def episode(self) -> FleetEpisode:
        """Return the run's episode."""
        robots = tuple(self._robot(number) for number in range(len(self.outcome.members)))
        digests = np.array([int(one.trace_digest, 16) for one in robots], np.uint64)
        return FleetEpisode(
            verdict=self.verdict,
            steps=self.outcome.steps,
            time=round(self.outcome.steps * self.options.time_step, 9),
            path_length=sum(one.path_length for one in robots),
            collisions=sum(one.collisions for one in robots),
            trace_digest=fnv1a(digests),
            evidence=self.evidence,
            area_covered=sum(one.area_covered for one in robots),
            robots=robots,
            random_draws=sum(one.random_draws for one in self.outcome.members),
        )

    def _robot(self, number: int) -> Episode:
        """Return one robot's episode."""
        member = self.outcome.members[number]
        verdict, evidence = self._of_robot(number, member)
        return Episode(
            verdict=verdict,
            steps=member.steps,
            time=round(member.steps * self.options.time_step, 9),
            path_length=member.path_length,
            collisions=member.collisions,
            trace_digest=member.digest,
            evidence=evidence,
            trace=member.trace,
            area_covered=area_of(member.cells_visited, self.world),
        )

    def _of_robot(self, number: int, member: Outcome) -> tuple[Verdict, Evidence]:
        """Return a robot's own verdict and evidence: the run's, if that is about this robot."""
        # The robot that ended the run has the run's verdict.
        evidence = self.evidence
        collided = isinstance(evidence, CollisionEvidence) and number + 1 in evidence.robots
        if number == self.robot or collided:
            return self.verdict, evidence
        if member.ending == Verdict.REACHED:
            return Verdict.REACHED, ReachedEvidence(step=member.steps)
        if isinstance(evidence, JointLoopEvidence):
            return self.verdict, evidence
        # Any other robot ran out of budget.
        stalled = member.last_new_cell <= member.steps // 2
        own = BudgetEvidence(last_new_cell=member.last_new_cell)
        return (Verdict.STALLED if stalled else Verdict.TIMEOUT), own


def _joint_loop(world: World, options: RunOptions, proof: JointProof) -> FleetEpisode:
    outcome = proof.outcome
    if any(one.overlap_step >= 0 for one in outcome.members):
        return _decided(world, options, outcome)
    if len(proof.waiting) == 1 and len(outcome.members) > 1:
        verdict = Verdict.STARVED
    else:
        verdict = Verdict.LIVELOCK if proof.moving else Verdict.DEADLOCK
    evidence = JointLoopEvidence(
        entry=outcome.entry,
        period=outcome.period,
        state_digest=state_digest(proof.state),
        waiting=tuple(number + 1 for number in proof.waiting),
        moving=tuple(number + 1 for number in proof.moving),
        blocked=tuple((one + 1, other + 1) for one, other in proof.blocked),
        parked=tuple(
            (number + 1, one.steps)
            for number, one in enumerate(outcome.members)
            if one.ending == Verdict.REACHED
        ),
        periods=tuple((number + 1, period) for number, period in proof.periods) or None,
    )
    return _Decision(world, options, outcome, verdict, evidence).episode()


def _decided(world: World, options: RunOptions, outcome: FleetOutcome) -> FleetEpisode:
    # The verdict concerns one robot, and decides which evidence counts.
    verdict, robot = _verdict(outcome)
    one = outcome.members[robot]
    number = robot + 1
    evidence: Evidence
    if verdict == Verdict.REACHED:
        evidence = ReachedEvidence(step=outcome.steps)
    elif verdict == Verdict.COLLISION:
        evidence = CollisionEvidence(step=outcome.steps, robots=(number, outcome.other + 1))
    elif verdict in OUT_OF_BUDGET:
        evidence = BudgetEvidence(
            last_new_cell=_last_new_cell(outcome),
            witness_multiple=_multiple(world, options, outcome),
        )
    elif verdict == Verdict.BURNED:
        evidence = BurnedEvidence(
            step=one.hit_step, cell=one.hit_cell, state=one.hit_state, robot=number
        )
    elif verdict in BY_THE_CONTROLLER:
        fault = one.fault or FaultEvidence()
        evidence = replace(fault, step=outcome.steps, robot=number)
    else:
        evidence = replace(wall_evidence(one), robot=number)
    return _Decision(world, options, outcome, verdict, evidence, robot).episode()


def _verdict(outcome: FleetOutcome) -> tuple[Verdict, int]:
    """Return how a run without a proof ended, and the index of the robot that ended it."""
    if outcome.robot >= 0:
        return Verdict(outcome.ending), outcome.robot
    cuts = [
        (member.overlap_step, number)
        for number, member in enumerate(outcome.members)
        if member.overlap_step >= 0
    ]
    if cuts:
        return Verdict.OVERLAP, min(cuts)[1]
    if outcome.ending == Verdict.REACHED:
        return Verdict.REACHED, -1
    stalled = _last_new_cell(outcome) <= outcome.steps // 2
    return (Verdict.STALLED if stalled else Verdict.TIMEOUT), -1


def _last_new_cell(outcome: FleetOutcome) -> int:
    return max(one.last_new_cell for one in outcome.members)


def _multiple(world: World, options: RunOptions, outcome: FleetOutcome) -> float | None:
    """Return the run's time as a multiple of the witness's; ``None`` without a witness."""
    proof = world.certificate
    duration = proof.duration if isinstance(proof, JointWitness) else 0.0
    return round(outcome.steps * options.time_step / duration, 3) if duration > 0.0 else None
