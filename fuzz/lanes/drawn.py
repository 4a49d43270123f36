"""Lanes in which Hypothesis draws scenarios one by one: feature layouts, families, poses on a map, sealed targets."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzz.door import SLOWER
from fuzz.failure import regardless_of_walls
from fuzz.features import decode_world
from fuzz.lanes.task import Task
from fuzz.sealed import SEALED_BYTES, decode_sealed
from fuzz.strategies import family_worlds, layouts, scenarios_in
from sim.episode import prepare
from sim.motion import MOTIONS
from sim.motion.base import THESIS
from sim.run_options import step_budget
from sim.scenario import Scenario
from worldgen.errors import InvalidWorld
from worldgen.lattice import lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.world import Pose, Target, World

__all__ = [
    "LAYOUT_LANES",
    "SEALED",
    "can_breach",
    "explore",
    "lane_worlds",
    "poses_on",
    "search",
    "search_sealed",
]

SEALED = "sealed"
"""Layouts with a walled-off target, for motion models in which a robot can go on past a wall."""

LAYOUT_LANES = ("features", SEALED)
"""Lanes that may be named like families."""

_SEARCH_STEPS = 6_000  # budget of a first look, before the witness is known
_DEARER = 4  # how many feature layouts are drawn in the time of one world of a family
_EXAMPLE_WORDS = 128  # of 8 bytes; more than any lane's strategy reads

Visit = Callable[[World, Scenario], None]
"""Runs one scenario; an error would end the round."""

TIME_STEPS = (0.015, 0.03, 0.06, 0.1, 0.15)  # s: the range of the thesis's spinner


def can_breach(scenario: Scenario) -> bool:
    """Whether a run can show what it does past a wall that it goes through, so that a target walled off is of use."""
    return MOTIONS.get(scenario.motion).kernel == THESIS and not scenario.thesis.keep_going


def search(task: Task) -> None:
    """Runs worlds as Hypothesis draws them, and hands on what does not arrive."""

    def visit(world: World, scenario: Scenario) -> None:
        budget = step_budget(world, scenario.time_step) if world.certificate else _SEARCH_STEPS
        try:
            run = prepare(world, task.controller, scenario.options(world, budget))
            outcome = run.run(budget, find_loop=True, record=False, digest=False)
        except InvalidWorld:  # the drawn start is in a wall
            return
        task.door.look(world, scenario, outcome)

    _draw(task, visit)


def search_sealed(task: Task) -> None:
    """Runs worlds whose target is walled off; all that counts is a robot that gets there."""

    def visit(world: World, scenario: Scenario) -> None:
        verdict, options = "sealed", scenario.options(world)
        run = prepare(world, task.controller, options)
        outcome = run.run(options.steps, find_loop=True, record=False, digest=False)
        if outcome.ending == "tunnel":
            run = prepare(world, task.controller, regardless_of_walls(options))
            whole = run.run(options.steps, find_loop=True, record=False, digest=False)
            verdict = "breach" if whole.ending == "reached" else "sealed"
        task.door.count(verdict, outcome.steps)
        if verdict == "breach":
            task.door.enter(world, scenario, verdict, outcome.cause)

    _draw(task, visit)


def _draw(task: Task, visit: Visit) -> None:
    config, lane = task.config, task.lane
    strategy = scenarios_in(lane_worlds(lane, config.fixed_map), config.scenario, config.time_steps, config.vary)
    share = (1 if lane in (*LAYOUT_LANES, "map") else _DEARER) * (1 if config.is_compiled else SLOWER)
    explore(strategy, task.stream.next64(), max(config.examples // share, 1), visit)


def explore(strategy: st.SearchStrategy[tuple[World, Scenario]], unit_seed: int, examples: int, visit: Visit) -> None:
    """Lets Hypothesis turn our own random bytes into examples, so that a unit depends on its seed alone.

    Left to itself, Hypothesis mixes constants of every loaded module into its draws, and with ``CI`` set it
    would derandomise. Nothing is raised, so a round goes through all its examples.
    """

    @settings(database=None, derandomize=False, deadline=None, suppress_health_check=list(HealthCheck))
    @given(strategy)
    def example(draw: tuple[World, Scenario]) -> None:
        visit(*draw)

    feed: Callable[[bytes], Any] = cast(Any, example).hypothesis.fuzz_one_input
    stream = RandomStream(unit_seed)
    for _ in range(examples):
        feed(stream.bits(_EXAMPLE_WORDS).astype("<u8").tobytes())


def lane_worlds(lane: str, fixed_map: World | None = None) -> st.SearchStrategy[World]:
    """The worlds of a lane: ``features``, ``sealed``, ``map`` (poses on a fixed foreign map), or a family's name."""
    if lane == "map" and fixed_map is not None:
        return poses_on(fixed_map)
    if lane == "features":
        return layouts().map(decode_world)
    if lane == SEALED:
        return st.binary(min_size=SEALED_BYTES, max_size=SEALED_BYTES).map(decode_sealed)
    return family_worlds(lane)


def poses_on(world: World) -> st.SearchStrategy[World]:
    """Start, heading, target and robot radius on a fixed map, at the centres of its free cells."""
    free = np.argwhere(~world.walls)
    if not len(free):
        raise InvalidWorld("the map has no free cell to start from")
    plain = replace(world, certificate=None, provenance=None, failure=None)
    radii = sorted({round(world.robot_radius * share, 6) for share in (0.5, 0.75, 1.0)}, reverse=True)

    def place(start: int, heading: int, target: int, radius: float) -> World:
        at, to = free[start], free[target]
        side = world.cell_size
        return replace(
            plain,
            start=Pose(_centre(at[1], side), _centre(at[0], side), heading * (math.pi / 8)),
            target=Target(_centre(to[1], side), _centre(to[0], side), world.target.radius),
            robot_radius=radius,
        )

    index = st.integers(0, len(free) - 1)
    return st.builds(place, index, st.integers(0, 15), index, st.sampled_from(radii))


def _centre(index: int, cell_size: float) -> float:
    return lattice_to_metres(1024 * int(index) + 512, cell_size)
