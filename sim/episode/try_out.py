"""Try a controller before long work.

Two steps report immediately what can never work, and a few more show how much time it takes.
"""

from __future__ import annotations

import contextlib
import math
import time
from dataclasses import replace
from typing import Any

import numpy as np

from sim.clock.controller_time import Effort
from sim.clock.stopping import OutOfTime, stopping_when
from sim.controllers.base import Command, Memory, Observation
from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.contract import check_contract
from sim.controllers.instances import origin_of
from sim.episode import prepare
from sim.episode.batch import simulate_many
from sim.outcome import Outcome
from sim.runners.controller_host import host_of
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.world import Pose, Target, World

resource: Any = None
with contextlib.suppress(ImportError):  # Windows has none
    import resource

EMPTY_ARENA = World(np.zeros((8, 8), bool), Pose(0.35, 0.35, 0.0), Target(0.6, 0.6, 0.05))
"""A world without walls."""

# The first step shows what reset() returned, the second what act() made of it.
_STEPS = 2
# Steps of the first run that measures a step; each further run has four times as many.
_FEW_STEPS = 8
_LONGER = 4
# Seconds after which a run is long enough to measure a step, and the limit on its steps.
_LONG_ENOUGH = 0.03
_MOST_STEPS = 1024
# Steps of a run that show what only every so many of them do, such as planning again, and the time
# above which nothing is run for that, or a second time, s.
_TELLING_STEPS = 32
_LONG = 0.1
# A busy machine only ever adds time, so each time is the least of this many.
_REPEATS = 3
# On a busy machine, measuring may last this many times as long as it computes.
_BUSY = 4
# Robots of a vector class, one call of which acts for all.
_AT_ONCE = 64


def _furnished() -> World:
    """Return a world of 2.4 m with walls to sense and to drive around."""
    walls = np.zeros((24, 24), bool)
    walls[6:18, 8] = walls[14:20, 16] = walls[10, 12:22] = True
    return World(walls, Pose(0.35, 1.25, 0.0), Target(2.05, 1.65, 0.05))


class _Idle:
    """Stands still."""

    def reset(self) -> Memory:
        return ()

    def act(self, _observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        return Command(), memory


def try_out(
    scenario: Scenario, world: World = EMPTY_ARENA, *, seconds: float | None = None
) -> Outcome:
    """Run two steps.

    Args:
        scenario: What to run.
        world: The world; an empty arena if omitted.
        seconds: Time limit for the two steps of a Python class, s. A program has its own deadlines,
            and a compiled step cannot be interrupted. Loading the simulator does not count.

    Returns:
        How the run ended.

    Raises:
        InvalidParameter: If the controller does not compile, does not fit the motion model, returns
            something that the contract does not allow, or takes too long.
        InvalidWorld: If the robot cannot stand at the start.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if seconds is None or not host_of(controller).in_python:
        outcome = _two_steps(scenario, controller, world)
    else:
        # Load the simulator first, with a controller that costs nothing.
        _two_steps(scenario, _Idle(), world)
        end = time.monotonic() + seconds
        try:
            with stopping_when(lambda: time.monotonic() > end):
                outcome = _two_steps(scenario, controller, world)
        except OutOfTime:
            raise InvalidParameter(
                "first-steps-too-slow",
                "{controller} did not finish two steps within {seconds:g} s",
                "use a larger --budget, or run it as a program, whose steps have a deadline "
                "(docs/reference/controllers.md)",
                at_terminal=True,
                controller=scenario.controller,
                seconds=seconds,
            ) from None
    check_contract(scenario.controller, outcome.fault, outcome.steps)
    return outcome


def step_times(
    scenario: Scenario, *, at_most: float, world: World | None = None
) -> tuple[float, float] | None:
    """Measure a controller that has been tried out.

    Args:
        scenario: What to run.
        at_most: Limit on the time for that, s.
        world: Where a run begins, if that takes as long as the world is large.

    Returns:
        Seconds of a step, and to begin a run, which includes what only the first step does.
        ``None`` if the runs end before that can be said.
    """
    controller = CONTROLLERS.get(scenario.controller)
    robots = _AT_ONCE if host_of(controller).acts_for_many else 1
    origin = origin_of(controller)
    furnished = _furnished()
    least: dict[int, float] = {}

    def run(limit: int, where: World = furnished) -> tuple[int, float]:
        # A reused answer says nothing about the time that computing it takes.
        if origin is not None:
            origin.answers.forget()
        own = Effort.so_far().own
        wall = time.perf_counter()
        cpu = time.process_time()
        waits = _times_waited()
        done = _steps(scenario, controller, where, limit, robots)
        wall = time.perf_counter() - wall
        cpu = time.process_time() - cpu
        # Other programs' share of a busy machine is left out, unless the controller itself waits.
        spent = wall if _times_waited() - waits >= done else min(wall, cpu)
        # So is what the simulator adds; a compiled controller's own time is not known.
        own = Effort.so_far().own - own
        spent = min(spent, own) if own else spent
        least[done] = min(least.get(done, math.inf), spent)
        return done, spent

    # Nothing but the clock ends these runs early: a step may take longer than the limit. On a busy
    # machine a limit on the wall's time would leave too little to measure.
    cpu_end = time.process_time() + at_most
    wall_end = time.monotonic() + _BUSY * at_most
    own = Effort.so_far().own
    try:
        with stopping_when(lambda: time.process_time() > cpu_end or time.monotonic() > wall_end):
            # A run of one step is all that a run costs, and a longer one shows what a step adds.
            for _ in range(_REPEATS):
                run(1)
            limit = _FEW_STEPS
            done, spent = run(limit)
            while done == limit < _MOST_STEPS and (
                spent < _LONG_ENOUGH or (limit < _TELLING_STEPS and spent < _LONG)
            ):
                limit = min(_LONGER * limit, _MOST_STEPS)
                done, spent = run(limit)
            for _ in range(_REPEATS - 1 if spent < _LONG else 0):
                run(limit)
    except OutOfTime:
        # The first step took all of the time, so each may.
        if max(least, default=1) == 1:
            own = Effort.so_far().own - own
            return (least.get(1, own), 0.0) if own >= at_most / _BUSY else None
    longest = max(least, default=0)
    if 1 not in least or longest <= 1:
        return None
    step = max(least[longest] - least[1], 0.0) / (longest - 1)
    reset = least[1]
    if world is not None:
        least.clear()
        with contextlib.suppress(OutOfTime), stopping_when(lambda: time.monotonic() > wall_end):
            reset = max(reset, run(1, world)[1])
    return step / robots, max(reset - step, 0.0) / robots


def _times_waited() -> int:
    """Return how often this thread has waited for something, as for a program's answer.

    Where that is not known, it counts as never.
    """
    who = getattr(resource, "RUSAGE_THREAD", None)
    return 0 if who is None else resource.getrusage(who).ru_nvcsw


def _steps(scenario: Scenario, controller: Any, world: World, limit: int, robots: int) -> int:
    """Run this many steps at most, and return how many were run."""
    options = scenario.options(world, limit)
    if robots == 1:
        run = prepare(world, controller, options)
        return run.run(limit, find_loop=False, record=False, digest=False).steps
    runs = simulate_many(world, controller, replace(options, seed=0), seeds=robots)
    return int(runs.steps.max())


def _two_steps(scenario: Scenario, controller: Any, world: World) -> Outcome:
    options = scenario.options(world, _STEPS)
    return prepare(world, controller, options).run(
        _STEPS, find_loop=False, record=False, digest=False
    )
