"""Try a controller for two steps before long work, to report immediately what can never work."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from sim.clock.stopping import OutOfTime, stopping_when
from sim.controllers.base import Command, Memory, Observation
from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.contract import check_contract
from sim.episode import prepare
from sim.outcome import Outcome
from sim.runners.controller_host import host_of
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.world import Pose, Target, World

EMPTY_ARENA = World(np.zeros((8, 8), bool), Pose(0.35, 0.35, 0.0), Target(0.6, 0.6, 0.05))
"""A world without walls."""

# The first step shows what reset() returned, the second what act() made of it.
_STEPS = 2


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


def _two_steps(scenario: Scenario, controller: Any, world: World) -> Outcome:
    options = scenario.options(world, _STEPS)
    return prepare(world, controller, options).run(
        _STEPS, find_loop=False, record=False, digest=False
    )
