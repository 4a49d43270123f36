"""Runs whose outcome is proved, for watchdogs: loops that never end, and arrivals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from fuzz.failure import Failure
from fuzz.overview.natural import drawn_worlds, natural_case, natural_families
from sim.controllers.base import Command, Memory, Observation
from sim.episode import Episode, prepare, simulate
from sim.evidence import LoopEvidence
from sim.kernels import layout
from sim.options.robot import RobotOptions
from sim.options.run import RunOptions
from sim.runners.lattice import LatticeRun
from sim.scenario import Scenario
from sim.verdict import ARRIVALS, Verdict
from worldgen.errors import WorldgenError
from worldgen.support.arrays import Floats
from worldgen.world import World


@dataclass(frozen=True)
class Drive:
    """A run whose outcome is proved.

    Args:
        name: The failure's file, or the family and number of a natural world.
        world: The world.
        episode: The run, recorded.
    """

    name: str
    world: World
    episode: Episode

    @property
    def loops(self) -> bool:
        """True for a proved loop, False for an arrival."""
        return self.episode.verdict == Verdict.LOOP

    @property
    def entry(self) -> float:
        """When the loop begins, s; infinity for an arrival."""
        evidence = self.episode.evidence
        if not isinstance(evidence, LoopEvidence) or self.episode.trace is None:
            return math.inf
        return evidence.entry * self.episode.trace.time_step

    @property
    def has_beams(self) -> bool:
        """True if beams can be measured afterwards: the walls stay, and the run is on the lattice."""
        trace = self.episode.trace
        return trace is not None and trace.robot is not None and not self.world.is_dynamic

    def observations(self, horizon: float, beams: int = 0) -> Iterator[Observation]:
        """Yield what a robot can know after each step.

        A loop goes on as it is proved to: until a time after its entry, and for two periods.

        Args:
            horizon: That time, s.
            beams: Number of range beams, if it :attr:`has_beams`.
        """
        trace = self.episode.trace
        if trace is None:
            return
        evidence = self.episode.evidence
        steps = trace.steps
        entry, period = steps, 1
        if isinstance(evidence, LoopEvidence):
            entry, period = evidence.entry, evidence.period
            steps = entry + max(math.ceil(horizon / trace.time_step), 2 * period)
        # The goal that counts after each step: the target, unless there are waypoints.
        goals = self.world.robots[0].goals
        passed = trace.passed if len(trace.passed) else np.full(trace.steps + 1, len(goals) - 1)
        ranges = self._beams(beams)
        top_speed, radius = self.world.robot_speed, self.world.robot_radius
        nan = math.nan
        for step in range(1, steps + 1):
            # The state of the entry recurs, with the move that led to it the second time.
            at = step if step <= entry else entry + 1 + (step - entry - 1) % period
            x, y = float(trace.x[at]), float(trace.y[at])
            goal = goals[min(int(passed[at]), len(goals) - 1)]
            yield Observation(
                bump=bool(trace.bump[at]),
                bump_bearing=nan,
                signal=nan,
                signal_heading=nan,
                heading=float(trace.heading[at]),
                x=x,
                y=y,
                target_heading=math.atan2(goal.y - y, goal.x - x),
                target_distance=math.hypot(goal.y - y, goal.x - x),
                random=nan,
                time_step=trace.time_step,
                top_speed=top_speed,
                radius=radius,
                time=step * trace.time_step,
                odometry_x=nan,
                odometry_y=nan,
                odometry_heading=nan,
                beams=tuple(ranges[at].tolist()) if beams else (),
                goal_heading=nan if goal.heading is None else goal.heading,
            )

    def _beams(self, count: int) -> Floats:
        """Return (n + 1, count) the beams' ranges at each pose of the recording, m."""
        trace = self.episode.trace
        if trace is None or not count:
            return np.zeros((0, 0))
        options = RunOptions("swept", 1, trace.time_step, robot=RobotOptions(beams=count))
        run = prepare(self.world, _Scanner(), options)
        if not isinstance(run, LatticeRun):
            raise TypeError("swept runs on the lattice")
        states = trace.states[: trace.steps + 1, :3].astype(np.int64)
        return run.sensed_of_walls(states)[:, layout.OBS_SIZE :]


class _Scanner:
    """Stands still, so that its run has beams and nothing else."""

    senses = ("beams",)

    def reset(self) -> Memory:
        return ()

    def act(self, _observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        return Command(), memory


def drives_of(
    failures: Iterable[tuple[str, Failure]],
    worlds: int,
    *,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[list[Drive], int]:
    """Return the proved loops of failures, and the same controllers' runs in natural worlds.

    Deterministic: equal arguments give equal runs.

    Args:
        failures: Failures with their names.
        worlds: Natural worlds that each controller with its options drives in. Only the runs that
            arrive, or provably loop, are returned.
        seed: Seed of these worlds.
        progress: Called with what is being run.

    Returns:
        The runs, and how many failures are left out: runs of several robots, and those that end
        without a proved loop.
    """
    drives: list[Drive] = []
    scenarios: dict[str, Scenario] = {}
    left_out = 0
    for name, failure in failures:
        progress(name)
        scenario = failure.scenario
        if failure.world.is_fleet:
            left_out += 1
            continue
        scenarios.setdefault(str(scenario.with_run(seed=0)), scenario)
        episode = failure.run()
        if episode.verdict == Verdict.LOOP:
            drives.append(Drive(name, failure.world, episode))
        else:
            left_out += 1
    for scenario in scenarios.values():
        drives += _natural_drives(scenario, worlds, seed, progress)
    return drives, left_out


def _natural_drives(
    scenario: Scenario, count: int, seed: int, progress: Callable[[str], None]
) -> Iterator[Drive]:
    for drawn in drawn_worlds(natural_families(()), seed, count):
        name = f"{drawn.family} {drawn.number}"
        progress(f"{scenario.controller} in natural world {drawn.number + 1} of {count}")
        try:
            case = natural_case(drawn, scenario)
            if case is None:
                continue
            options = case.scenario.options(case.world)
            episode = simulate(case.world, scenario.controller, options, record=True)
        except WorldgenError:
            # A world that cannot be made, or a run too long to record, says nothing.
            continue
        if episode.verdict in ARRIVALS or episode.verdict == Verdict.LOOP:
            yield Drive(name, case.world, episode)
