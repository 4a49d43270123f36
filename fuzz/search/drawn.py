"""Lanes in which Hypothesis draws scenarios one by one.

Feature layouts, families, poses on a map, sealed targets.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any, cast
from unittest import SkipTest

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.database import ExampleDatabase, ReadOnlyDatabase

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.variation import map_provenance
from fuzz.failure import regardless_of_walls
from fuzz.search.database import Failed, exception_of, remembered
from fuzz.search.features import decode_world
from fuzz.search.names import LAYOUT_LANES, SEALED
from fuzz.search.sealed import SEALED_BYTES, decode_sealed
from fuzz.search.task import Task
from fuzz.strategies import family_worlds, layouts, scenarios_in
from sim.episode import prepare
from sim.options.run import step_budget
from sim.runners.stopping import OutOfTime, check_time
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.errors import InvalidWorld
from worldgen.lattice import lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.world import Pose, Target, World

__all__ = ["explore", "lane_worlds", "poses_on", "search", "search_again"]

_SEARCH_STEPS = 6_000  # budget of a first look, before the witness is known
_DEARER = 4  # how many feature layouts are drawn in the time of one world of a family
_MOST_AGAIN = 10_000  # examples of a lane that are tried again
_EXAMPLE_WORDS = 128  # of 8 bytes; more than any lane's strategy reads

Visit = Callable[[World, Scenario], str]
"""Runs one scenario; the class of the failure, empty if there is none."""

_SETTINGS = settings(
    database=None, derandomize=False, deadline=None, suppress_health_check=list(HealthCheck)
)


def search(task: Task) -> None:
    """Runs worlds as Hypothesis draws them, and hands on what does not arrive."""
    config = task.config
    share = (1 if task.lane in (*LAYOUT_LANES, "map") else _DEARER) * config.slower
    database = remembered(config, task.lane) if config.database else None
    explore(
        lane_scenarios(config, task.lane),
        task.stream.next64(),
        max(config.examples // share, 1),
        visit_of(task, task.lane),
        database,
    )


def search_again(task: Task, lanes: Iterable[str]) -> None:
    """Runs what failed before in these lanes, as the campaign's Hypothesis database has it."""
    for lane in lanes:
        _repeat(
            lane_scenarios(task.config, lane), visit_of(task, lane), remembered(task.config, lane)
        )


def _repeat(
    strategy: st.SearchStrategy[tuple[World, Scenario]], visit: Visit, database: ExampleDatabase
) -> None:
    """Visits every example of a database.

    Deletes none, as Hypothesis would if it did not fail any more.
    """
    ended: list[BaseException] = []

    @settings(
        _SETTINGS,
        database=ReadOnlyDatabase(database),
        phases=[Phase.reuse],
        max_examples=_MOST_AGAIN,
    )
    @given(strategy)
    def example(draw: tuple[World, Scenario]) -> None:
        try:
            if not ended:
                visit(*draw)
        except (KeyboardInterrupt, OutOfTime) as end:
            ended.append(end)

    with contextlib.suppress(SkipTest):  # so Hypothesis says that there was no example
        example()
    if ended:
        raise ended[0]


def visit_of(task: Task, lane: str) -> Visit:
    """How a lane runs one scenario."""
    return partial(_visit_sealed if lane == SEALED else _visit, task)


def _visit(task: Task, world: World, scenario: Scenario) -> str:
    budget = step_budget(world, scenario.run.time_step) if world.certificate else _SEARCH_STEPS
    try:
        run = prepare(world, task.controller, scenario.options(world, budget))
        outcome = run.run(budget, find_loop=True, record=False, digest=False)
    except InvalidWorld:  # the drawn start is in a wall
        return ""
    return task.door.look(world, scenario, outcome)


def _visit_sealed(task: Task, world: World, scenario: Scenario) -> str:
    """All that counts where the target is walled off is a robot that gets there."""
    verdict = "sealed"
    options = scenario.options(world)
    run = prepare(world, task.controller, options)
    outcome = run.run(options.steps, find_loop=True, record=False, digest=False)
    if outcome.ending == Verdict.TUNNEL:
        run = prepare(world, task.controller, regardless_of_walls(options))
        whole = run.run(options.steps, find_loop=True, record=False, digest=False)
        verdict = "breach" if whole.ending == Verdict.REACHED else "sealed"
    task.door.count(verdict, outcome.steps)
    return task.door.enter(world, scenario, verdict, outcome.cause) if verdict == "breach" else ""


def explore(
    strategy: st.SearchStrategy[tuple[World, Scenario]],
    unit_seed: int,
    examples: int,
    visit: Visit,
    database: ExampleDatabase | None = None,
) -> None:
    """Lets Hypothesis turn our own random bytes into examples.

    So that a unit depends on its seed alone. Left to itself, Hypothesis mixes constants of every
    loaded module into its draws, and with ``CI`` set it would derandomise. A failure is raised only
    for Hypothesis to keep it, so a round goes through all its examples.

    Raises:
        OutOfTime: As ``visit`` does, but not through Hypothesis, which would keep that for a
            failure.
    """
    ended: list[BaseException] = []

    @settings(_SETTINGS, database=database)
    @given(strategy)
    def example(draw: tuple[World, Scenario]) -> None:
        try:
            kind = visit(*draw)
        except (KeyboardInterrupt, OutOfTime) as end:
            ended.append(end)
            return
        if kind:
            raise exception_of(kind)

    feed: Callable[[bytes], Any] = cast(Any, example).hypothesis.fuzz_one_input
    stream = RandomStream(unit_seed)
    for _ in range(examples):
        with contextlib.suppress(Failed):
            feed(stream.bits(_EXAMPLE_WORDS).astype("<u8").tobytes())
        if ended:
            raise ended[0]
        check_time()


def lane_scenarios(config: CampaignConfig, lane: str) -> st.SearchStrategy[tuple[World, Scenario]]:
    """What a lane draws from."""
    return scenarios_in(
        lane_worlds(lane, config.fixed_map), config.scenario, config.time_steps, config.vary
    )


def lane_worlds(lane: str, fixed_map: World | None = None) -> st.SearchStrategy[World]:
    """The worlds of a lane.

    ``features``, ``sealed``, ``map`` (poses on a fixed foreign map), or a family's name.
    """
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
        raise InvalidWorld("no-free-cell", "the map has no free cell to start from")
    plain = replace(world, certificate=None, provenance=map_provenance(world), failure=None)
    radii = sorted(
        {round(world.robot_radius * share, 6) for share in (0.5, 0.75, 1.0)}, reverse=True
    )

    def place(start: int, heading: int, target: int, radius: float) -> World:
        at = free[start]
        to = free[target]
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
