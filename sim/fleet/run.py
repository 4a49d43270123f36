"""Pack a world of several robots for the core, run it, and read the results."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim._core import lib
from sim.controllers.base import Controller, Memory
from sim.controllers.controller_error import ControllerError
from sim.fleet.apart import separate_loops
from sim.fleet.asking import message_not_finite, own_hosts, run_with_hosts
from sim.fleet.core_calls import CoreFleet
from sim.options.run import MAX_RECORDED, RunOptions, check_recordable
from sim.outcome import ENDINGS, LIMIT, Ending, Outcome
from sim.runners.controller_host import ControllerHost, Faults
from sim.runners.core_calls import memory_for
from sim.runners.lattice import LatticeRun
from sim.runners.long_runs import MOST_HELD
from sim.runners.packing import refuse_unless_plain
from sim.verdict import Verdict
from worldgen.domain import MASK64
from worldgen.errors import InvalidWorld
from worldgen.lattice import clear_distance_sq, metres_to_lattice, radius_in_cells
from worldgen.random_streams import GAMMA, mix64
from worldgen.support.arrays import Ints, Words
from worldgen.support.results import only_results_on_stdout
from worldgen.world import World

Recordings = list[tuple[Ints, Ints]]

# Limit on the steps, over all robots, that are driven beyond the budget to prove a joint loop.
_MOST_DRIVEN = 500_000


@dataclass(frozen=True)
class FleetOutcome:
    """The core's claims about a run of several robots.

    Args:
        ending: ``limit``, ``reached`` if all robots have, ``loop`` if the joint state recurred, or
            an ending that one robot caused.
        steps: Steps simulated.
        period: Length of the recurrence, steps; for ``loop``.
        entry: Step where it begins, for ``loop``; else -1.
        robot: Index of the robot that ended the run; -1 if none did.
        other: For a collision, the index of the other robot; else -1.
        members: Each robot's own outcome; one that has parked ends as ``reached``.
        complete: Whether the recorded states alone decide the future.
    """

    ending: Ending
    steps: int
    period: int
    entry: int
    robot: int
    other: int
    members: tuple[Outcome, ...]
    complete: bool


@dataclass(frozen=True)
class JointProof:
    """A proved recurrence of the joint state.

    Args:
        outcome: The run up to the end of the first period.
        state: The joint state at its entry.
        waiting: Indices of the robots that have not parked.
        moving: Indices of those whose centres move within the period.
        blocked: Pairs of indices: a robot that drives into another one, and that one.
        periods: Pairs of a waiting robot's index and its own period, if they differ and the joint
            period was not driven; else empty.
    """

    outcome: FleetOutcome
    state: Words
    waiting: tuple[int, ...]
    moving: tuple[int, ...]
    blocked: tuple[tuple[int, int], ...]
    periods: tuple[tuple[int, int], ...] = ()


class FleetRun:
    """A world of several robots with their controllers, ready to run any number of times.

    Args:
        world: The world to drive in.
        controllers: (n,) each robot's controller, or its host.
        options: (n,) each robot's options, which differ in ``robot`` only.

    Raises:
        InvalidWorld: If a start is not clear of walls, or two robots overlap there.
        InvalidParameter: If a controller does not compile.
    """

    def __init__(
        self,
        world: World,
        controllers: Sequence[Controller | ControllerHost],
        options: Sequence[RunOptions],
    ) -> None:
        refuse_unless_plain(world, "a run of several robots", "not-for-fleets")
        self.world = world
        self.hosts = own_hosts(controllers)
        memory = memory_for(*controllers)
        self.runs = [
            LatticeRun(
                world.alone(number + 1),
                host,
                replace(one, seed=robot_seed(world, number, one.seed)),
                memory=memory,
            )
            for number, (host, one) in enumerate(zip(self.hosts, options, strict=True))
        ]
        self._words = 0  # words of all robots' states; known after a run
        self._place_robots()

    def _place_robots(self) -> None:
        """Put each robot on the nearest lattice point that is clear of walls and other robots.

        Robots come in the order of their places, so that their numbers do not matter.
        """
        robots = self.world.robots
        # Place the robots from left to right, so that the result does not depend on their order.
        order = sorted(range(len(robots)), key=lambda k: (robots[k].start.x, robots[k].start.y))
        placed: list[int] = []
        for number in order:
            run = self.runs[number]
            # Take the first start near the robot's own that is clear of the others.
            for x, y, _ in run.starts_near(robots[number].start):
                run.settings.start_x = x
                run.settings.start_y = y
                if all(self._gap_sq(number, other) >= 0 for other in placed):
                    break
            else:
                inside = next(other for other in placed if self._gap_sq(number, other) < 0)
                raise _robots_overlap(*sorted((number, inside)))
            placed.append(number)

    def _gap_sq(self, one: int, other: int) -> int:
        """Return how much the squared distance of two robots exceeds the required one."""
        first = self.runs[one].settings
        second = self.runs[other].settings
        dx = int(first.start_x) - int(second.start_x)
        dy = int(first.start_y) - int(second.start_y)
        together = radius_in_cells(self.runs[one].world) + radius_in_cells(self.runs[other].world)
        return dx * dx + dy * dy - clear_distance_sq(together)

    @property
    def can_loop(self) -> bool:
        """True if a joint state can recur and be seen: no clock, no fresh noise, no program."""
        return all(run.can_loop for run in self.runs)

    @property
    def _is_compiled(self) -> bool:
        return all(host.in_core for host in self.hosts)

    def run(self, steps: int, *, find_loop: bool, record: bool) -> FleetOutcome:
        """Simulate up to ``steps`` steps from the start.

        Args:
            steps: Budget.
            find_loop: Whether a recurrence of the joint state ends the run as soon as it is
                noticed.
            record: Whether to keep every state; the run is then done twice, the second time with
                room for just its steps.
        """
        seek = lib.WG_SEEK_LOOP if find_loop and self.can_loop else lib.WG_NO_LOOP
        outcome = self._run(steps, seek)[0]
        if not record:
            return outcome
        check_recordable(sum(one.steps for one in outcome.members))
        return self._run(outcome.steps, lib.WG_NO_LOOP, sizes=outcome.members, like=outcome)[0]

    def prove(self, entry: int, period: int, *, record: bool) -> JointProof | None:
        """Simulate a loop's first period, and compare the joint states at both of its ends.

        A controller that is not compiled may have state that we cannot see, so then a second
        period must repeat the first one, step by step.

        Returns:
            The proof; ``None`` if the state does not recur.
        """
        if not self._is_compiled and not self._repeats(entry, period):
            return None
        # Run to the end of the first period, and compare the states.
        outcome, fleet = self._run(entry + period, lib.WG_PROVE_LOOP, entry=entry)
        if outcome.ending != Verdict.LOOP or fleet is None:
            return None
        proof = _proof_of(outcome, fleet, entry)
        return self._recorded(proof) if record else proof

    def prove_apart(self, steps: int, *, record: bool) -> JointProof | None:
        """Prove that robots loop independently, each with its own period.

        Use this if no joint state recurs within the budget.

        Args:
            steps: Steps of the run, which must end because its budget is spent.
            record: Whether to keep every state of the proof's run.

        Returns:
            The proof, whose run ends after the longest of these periods; ``None`` if a robot does
            not repeat itself twice, or is near another one with a different period.
        """
        if not self.can_loop or 8 * (steps + 1) * self._words > MOST_HELD:
            return None
        # Find the loops in a recording of the whole run.
        whole = self.run(steps, find_loop=False, record=True)
        if not whole.complete or whole.ending != LIMIT:
            return None
        repeats = 1 if self._is_compiled else 2
        loops = separate_loops(
            whole.members, self._reaches(), self.last_event_step, repeats=repeats
        )
        if loops is None:
            return None
        if not loops.are_shown:
            # They may influence each other, so the joint period has to be simulated.
            # Robots that influence each other may return together even earlier.
            most = loops.entry + loops.joint_period
            if most * len(self.runs) > _MOST_DRIVEN:
                return None
            found = self.run(most, find_loop=True, record=False)
            if found.ending != Verdict.LOOP:
                return None
            return self.prove(found.entry, found.period, record=record)
        # Run once more, to note who moves and who drives into whom within the loops.
        last = loops.entry + max(loops.periods.values())
        outcome, fleet = self._run(last, lib.WG_PROVE_LOOP, entry=loops.entry)
        if fleet is None:
            return None
        outcome = replace(
            outcome, ending=Verdict.LOOP, period=loops.joint_period, entry=loops.entry
        )
        proof = _proof_of(outcome, fleet, loops.entry)
        if len(set(loops.periods.values())) > 1:
            proof = replace(proof, periods=tuple(sorted(loops.periods.items())))
        return self._recorded(proof) if record else proof

    @property
    def last_event_step(self) -> int:
        """Last step in which the world changes; 0 if it never does."""
        return max(run.last_event_step for run in self.runs)

    def _reaches(self) -> dict[tuple[int, int], float]:
        """Return the distance beyond which two robots have no effect on each other, m.

        It is the largest distance at which they could touch within a step, or at which one of them
        could sense the other.
        """
        radii = [run.world.robot_radius for run in self.runs]
        moves = [radius + run.reach_of_a_step for radius, run in zip(radii, self.runs, strict=True)]
        senses = [run.reach_of_senses for run in self.runs]
        return {
            (one, other): max(
                moves[one] + moves[other], senses[one] + radii[other], senses[other] + radii[one]
            )
            for one, other in itertools.combinations(range(len(self.runs)), 2)
        }

    def _recorded(self, proof: JointProof) -> JointProof:
        """Return a proof with the recording of its run, which takes memory."""
        like = proof.outcome
        check_recordable(sum(one.steps for one in like.members))
        recorded = self._run(like.steps, lib.WG_NO_LOOP, sizes=like.members, like=like)[0]
        return replace(proof, outcome=recorded)

    def _repeats(self, entry: int, period: int) -> bool:
        """Return True if two whole periods are equal, robot by robot and step by step."""
        # A hidden memory shows only if the loop is run twice.
        steps = entry + 2 * period
        if steps * len(self.runs) > MAX_RECORDED:
            return False
        whole = self.run(steps, find_loop=False, record=True)
        if not whole.complete or whole.steps < steps:
            return False
        # Robots that have parked do not have to repeat anything.
        for one in whole.members:
            if one.ending == Verdict.REACHED and one.steps <= entry:
                continue
            if one.trace is None or one.trace.steps < steps:
                return False
            states = one.trace.states
            if not np.array_equal(states[entry : entry + period + 1], states[entry + period :]):
                return False
        return True

    def _run(
        self,
        steps: int,
        find_loop: int,
        *,
        entry: int = 0,
        sizes: Sequence[Outcome] | None = None,
        like: FleetOutcome | None = None,
    ) -> tuple[FleetOutcome, CoreFleet | None]:
        """Run once.

        Args:
            steps: Budget.
            find_loop: WgFleetSettings.find_loop.
            entry: WgFleetSettings.loop_entry.
            sizes: To record the run: the outcomes of the same run, which give its length.
            like: The same run, whose ending the recorded one keeps.
        """
        for run in self.runs:
            run.settings.digest = 1
        with only_results_on_stdout(), contextlib.ExitStack() as frozen:
            for host, run in zip(self.hosts, self.runs, strict=True):
                frozen.enter_context(host.freezing(run.options))
            # Reset the controllers, then run.
            memories, faults = self._reset()
            if faults:
                return self._failed_in_reset(faults), None
            # Remember the hidden memory, to notice if the run changes it.
            hidden = [host.hidden() for host in self.hosts]
            drivers = [
                host.driver(memory, run.settings)
                for host, memory, run in zip(self.hosts, memories, self.runs, strict=True)
            ]
            fleet = CoreFleet(self.runs, drivers, steps, find_loop, entry)
            self._words = sum(member.words for member in fleet.members)
            recordings = [] if sizes is None else self._recordings(fleet, sizes)
            if self._is_compiled:
                fleet.run_to_the_end()
            else:
                faults = run_with_hosts(fleet, self.hosts, memories, self._channels())
            complete = all(
                before is not None and host.hidden() == before
                for host, before in zip(self.hosts, hidden, strict=True)
            )
        # Collect the outcome.
        outcome = self._outcome(fleet, complete, {**faults, **fleet.faults}, recordings)
        if like is not None:
            outcome = replace(outcome, ending=like.ending, period=like.period, entry=like.entry)
        return outcome, fleet

    def _reset(self) -> tuple[list[Memory], dict[int, ControllerError]]:
        """Return the controllers' memories, and their faults in ``reset``."""
        memories: list[Memory] = []
        faults: dict[int, ControllerError] = {}
        for number, host in enumerate(self.hosts):
            host.start()
            memories.append(())
            try:
                with Faults(host):
                    memories[-1] = host.begin(self.runs[number].world)
            except ControllerError as fault:
                faults[number] = fault
        return memories, faults

    def _channels(self) -> list[int]:
        """Return how many numbers each robot can send."""
        return [run.options.robot.message for run in self.runs]

    def _recordings(self, fleet: CoreFleet, sizes: Sequence[Outcome]) -> Recordings:
        found = []
        memory = self.runs[0].memory
        for member, size in zip(fleet.members, sizes, strict=True):
            rows = memory.zeros((size.steps + 1, 1 + member.words), np.int64)
            path = memory.zeros((size.points, 4), np.int64)
            rows[0, 1:] = member.state_words()
            member.record(rows[1:], path)
            found.append((rows, path))
        return found

    def _outcome(
        self,
        fleet: CoreFleet,
        complete: bool,
        faults: dict[int, ControllerError],
        recordings: Recordings,
    ) -> FleetOutcome:
        report = fleet.report
        # Find out whose fault a crash is.
        ending: Ending = ENDINGS[int(report.ending)]
        robot = int(report.robot)
        if ending == Verdict.CRASH and robot not in faults:
            faults = {robot: self.hosts[robot].fault_of(fleet.members[robot].report.error)}
        if ending == Verdict.CRASH:
            ending = faults[robot].verdict
        elif ending == Verdict.INVALID_COMMAND and not np.isfinite(fleet.members[robot].sent).all():
            faults = {robot: message_not_finite()}
        # Collect each robot's outcome.
        members = []
        for number, member in enumerate(fleet.members):
            fault = faults.get(number) if number == robot else None
            recording = recordings[number] if recordings else None
            if recording is not None:
                has_failed = fault is not None and int(report.ending) == lib.WG_CRASH
                recording = _written(recording, int(member.report.steps), has_failed)
            outcome = self.runs[number].outcome_of(member, recording, complete, fault)
            if outcome.trace is not None:
                size = int(member.c.workspace.observation.message_size)
                outcome = replace(outcome, trace=replace(outcome.trace, after_memory=size))
            members.append(outcome)
        return FleetOutcome(
            ending=ending,
            steps=int(report.steps),
            period=int(report.period),
            entry=int(report.entry),
            robot=robot,
            other=int(report.other),
            members=tuple(members),
            complete=complete,
        )

    def _failed_in_reset(self, faults: dict[int, ControllerError]) -> FleetOutcome:
        first = min(faults)
        members = tuple(
            run.outcome_of(None, None, True, faults[first] if number == first else None)
            for number, run in enumerate(self.runs)
        )
        return FleetOutcome(faults[first].verdict, 0, 0, -1, first, -1, members, complete=True)


def _proof_of(outcome: FleetOutcome, fleet: CoreFleet, entry: int) -> JointProof:
    """Return the proof of a recurrence, from the run that recorded the acts since its entry."""
    moved = fleet.moved()
    waiting = tuple(number for number, one in enumerate(outcome.members) if one.ending == LIMIT)
    return JointProof(
        outcome,
        fleet.known_words(),
        waiting,
        tuple(number for number in waiting if moved[number] > entry),
        tuple(fleet.blocks()),
    )


def robot_seed(world: World, number: int, seed: int) -> int:
    """Return the seed of one robot's random numbers.

    It depends on where the robot starts, not on its number, so that two robots draw different
    numbers and renumbering changes nothing.
    """
    start = world.robots[number].start
    mixed = seed
    for place in (start.x, start.y):
        mixed ^= metres_to_lattice(place, world.cell_size) & MASK64
        mixed = mix64((mixed + GAMMA) & MASK64)
    return mixed


def _robots_overlap(one: int, other: int) -> InvalidWorld:
    """Return the error for two robots, given by index, that have no clear lattice points."""
    return InvalidWorld(
        "robots-overlap",
        "robots {one} and {other} overlap at the start, where walls keep them from the nearest "
        "points of the pose lattice",
        "move one of them by a hundredth of a cell",
        one=one + 1,
        other=other + 1,
    )


def _written(recording: tuple[Ints, Ints], steps: int, has_failed: bool) -> tuple[Ints, Ints]:
    """Return the part of a recording that was written; a step in which a controller fails isn't."""
    rows, path = recording
    return rows[: max(steps - has_failed, 0) + 1], path[path[:, 0] > 0]
