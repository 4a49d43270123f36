"""Search strategies in which Hypothesis draws scenarios one by one.

They draw feature layouts, worlds of families, poses on a map, and worlds with a walled-off target.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzz.failure import regardless_of_walls
from fuzz.layouts.features import decode_world
from fuzz.layouts.map_variations import MapVariations, variations_of
from fuzz.layouts.map_windows import Kind, kind_of
from fuzz.layouts.variation import OVERRIDES, Variation, layout_disc, map_provenance, overrides_in
from fuzz.search.fleets import fleet_worlds
from fuzz.search.sealed import SEALED_BYTES, decode_sealed
from fuzz.search.task import SearchTask
from fuzz.strategies import family_worlds, layouts, scenarios_in
from fuzz.unit.config import CampaignConfig, radii_on
from fuzz.unit.names import LAYOUT_STRATEGIES, SEALED
from sim.clock.stopping import OutOfTime, check_time
from sim.episode import prepare, simulate
from sim.options.run import COVER, RunOptions
from sim.scenario import Scenario
from sim.verdict import OUT_OF_BUDGET, Verdict
from worldgen.body_room import with_fitting_heading
from worldgen.errors import InvalidWorld
from worldgen.lattice import cell_middle
from worldgen.random_streams import RandomStream
from worldgen.world import Pose, Value, World

# Budget of a first run, before the witness is known.
_SEARCH_STEPS = 6_000
# Feature layouts that take as long to draw as one world of a family.
_DEARER = 4
# Words of 8 bytes; more than any Hypothesis strategy here reads.
_EXAMPLE_WORDS = 128
# Shares of the kinds of worlds on a map, in sixteenths. Whole maps show what windows cannot, such as
# a room without an exit on the far side.
_ON_A_MAP = {Kind.POSE: 5, Kind.WINDOW: 4, Kind.DOOR: 2, Kind.BOX: 2, Kind.PERSON: 2, Kind.PIECE: 1}

Visit = Callable[[World, Scenario], object]
"""Runs one scenario, and passes a run that fails to triage."""

_SETTINGS = settings(
    database=None, derandomize=False, deadline=None, suppress_health_check=list(HealthCheck)
)


def search(task: SearchTask) -> None:
    """Run worlds that Hypothesis draws, and pass those in which the robot fails to triage."""
    config = task.config
    share = (1 if task.strategy in (*LAYOUT_STRATEGIES, "map") else _DEARER) * config.pace.slower
    explore(
        strategy_scenarios(config, task.strategy),
        task.stream.next64(),
        max(config.examples // share, 1),
        visit_of(task, task.strategy),
    )


def visit_of(task: SearchTask, strategy: str) -> Visit:
    """Return the function that runs one scenario of a strategy."""
    if strategy == "map":
        return partial(_visit_on_map, task)
    return partial(_visit_sealed if strategy == SEALED else _visit, task)


def _visit_on_map(task: SearchTask, world: World, scenario: Scenario) -> None:
    """Run a world that was drawn on the user's map, and count its kind."""
    result = task.triage.result
    before = result.worlds
    assert task.config.fixed_map is not None, "only a campaign on a map draws on it"
    try:
        _visit(task, world, scenario)
    finally:
        if result.worlds > before:
            result.tried[kind_of(world, task.config.fixed_map).value] += 1


def _visit(task: SearchTask, world: World, scenario: Scenario) -> None:
    budget = _SEARCH_STEPS
    try:
        if world.certificate or scenario.run.task == COVER:
            budget = scenario.options(world).steps
        options = scenario.options(world, budget)
        if world.is_fleet:
            verdict, steps = _ending_of_fleet(scenario, world, options)
            outcome = None
        else:
            run = prepare(world, scenario.controller, options)
            outcome = run.run(budget, find_loop=True, record=False, digest=False)
    except InvalidWorld:
        # The drawn start is in a wall.
        return
    if outcome is not None:
        task.triage.look(world, scenario, outcome)
    else:
        task.triage.look_at(world, scenario, verdict, steps)


def _ending_of_fleet(scenario: Scenario, world: World, options: RunOptions) -> tuple[str, int]:
    """Run several robots, all with the campaign's controller; return verdict and steps."""
    episode = simulate(world, scenario.controller, options)
    verdict = "undecided" if episode.verdict in OUT_OF_BUDGET else episode.verdict
    return verdict, episode.steps


def _visit_sealed(task: SearchTask, world: World, scenario: Scenario) -> None:
    """Run a world whose target is walled off; only a robot that arrives is a failure."""
    verdict = "sealed"
    options = scenario.options(world)
    run = prepare(world, scenario.controller, options)
    outcome = run.run(options.steps, find_loop=True, record=False, digest=False)
    if outcome.ending == Verdict.TUNNEL:
        run = prepare(world, scenario.controller, regardless_of_walls(options))
        whole = run.run(options.steps, find_loop=True, record=False, digest=False)
        verdict = "breach" if whole.ending == Verdict.REACHED else "sealed"
    task.triage.count(verdict, outcome.steps)
    if verdict == "breach":
        task.triage.enter(world, scenario, verdict, outcome.cause)


def explore(
    draws: st.SearchStrategy[tuple[World, Scenario]], unit_seed: int, examples: int, visit: Visit
) -> None:
    """Let Hypothesis turn random bytes of the unit into examples, and visit each.

    The bytes make a unit depend on its seed alone. Left to itself, Hypothesis mixes constants of
    every loaded module into its draws, and derandomises them if ``CI`` is set.

    Raises:
        OutOfTime: As ``visit`` does, but not through Hypothesis, which would take it for a failure.
    """
    ended: list[BaseException] = []

    @_SETTINGS
    @given(draws)
    def example(draw: tuple[World, Scenario]) -> None:
        try:
            visit(*draw)
        # Hypothesis would treat these as failures of the example, so keep them and raise them
        # outside it.
        except (KeyboardInterrupt, OutOfTime) as end:
            ended.append(end)

    feed: Callable[[bytes], Any] = cast(Any, example).hypothesis.fuzz_one_input
    stream = RandomStream(unit_seed)
    for _ in range(examples):
        feed(stream.bits(_EXAMPLE_WORDS).astype("<u8").tobytes())
        if ended:
            raise ended[0]
        check_time()


def strategy_scenarios(
    config: CampaignConfig, strategy: str
) -> st.SearchStrategy[tuple[World, Scenario]]:
    """Return the Hypothesis strategy that a search strategy draws from."""
    # What is drawn for the robot's body decides how its worlds are laid out.
    bodies = [one for one in config.vary if one.name in OVERRIDES]
    others = [one for one in config.vary if one.name not in OVERRIDES]

    def scenarios(*chosen: Value) -> st.SearchStrategy[tuple[World, Scenario]]:
        body = {one.name: value for one, value in zip(bodies, chosen, strict=True)}
        worlds = (
            _worlds_on_map(config)
            if strategy == "map"
            else strategy_worlds(strategy, config.robots, body)
        )
        fixed = (Variation(name, (value,)) for name, value in body.items())
        return scenarios_in(worlds, config.scenario, config.time_steps, (*fixed, *others))

    choices = list(itertools.product(*(one.values for one in bodies)))
    if len(choices) == 1:
        return scenarios(*choices[0])
    return st.sampled_from(choices).flatmap(lambda chosen: scenarios(*chosen))


def strategy_worlds(
    strategy: str, robots: int = 1, body: Mapping[str, Value] | None = None
) -> st.SearchStrategy[World]:
    """Return the Hypothesis strategy of the worlds of a search strategy.

    Args:
        strategy: ``features``, ``sealed``, or a family's name.
        robots: Number of robots in each world.
        body: Quantities of the robot's body, drive and goal, which decide how worlds are laid out.
    """
    body = body or {}
    if strategy == "features":
        _, cell_size = layout_disc(body)
        decode = partial(decode_world, cell_size=cell_size)
        return fleet_worlds(layouts().map(decode), robots)
    if strategy == SEALED:
        return st.binary(min_size=SEALED_BYTES, max_size=SEALED_BYTES).map(decode_sealed)
    given = overrides_in(body).given()
    if robots == 1:
        return family_worlds(strategy, **given)
    return family_worlds(strategy, robots=robots)


def _worlds_on_map(config: CampaignConfig) -> st.SearchStrategy[World]:
    """Return the worlds that a campaign draws on its map.

    For several robots, and on a map that changes, only the poses vary.
    """
    fixed_map = config.fixed_map
    assert fixed_map is not None, "the strategy needs a map"
    poses = fleet_worlds(poses_on(fixed_map), config.robots, fixed_map)
    if config.robots > 1 or fixed_map.is_dynamic:
        return poses
    step = fixed_map.robot_speed * config.time_steps[0]
    kinds = [kind for kind, share in _ON_A_MAP.items() for _ in range(share)]
    return _drawn_on_map(poses, variations_of(fixed_map, step), kinds)


@st.composite
def _drawn_on_map(
    draw: st.DrawFn,
    poses: st.SearchStrategy[World],
    variations: MapVariations,
    kinds: Sequence[Kind],
) -> World:
    kind = draw(st.sampled_from(kinds))
    if kind is not Kind.POSE:
        world = variations.draw(kind, RandomStream(draw(st.integers(0, 2**64 - 1))))
        if world is not None:
            return world
    return draw(poses)


def poses_on(world: World) -> st.SearchStrategy[World]:
    """Draw a single robot's start, heading, target and radius on a map.

    Start and target are centres of free cells.
    """
    free = np.argwhere(~world.walls)
    if not len(free):
        raise InvalidWorld("no-free-cell", "the map has no free cell to start from")
    plain = replace(world.alone(1), provenance=map_provenance(world))
    radii = radii_on(plain)

    def place(start: int, heading: int, target: int, radius: float) -> World:
        at = free[start]
        to = free[target]
        side = world.cell_size
        pose = Pose(cell_middle(at[1], side), cell_middle(at[0], side), heading * (math.pi / 8))
        there = replace(world.target, x=cell_middle(to[1], side), y=cell_middle(to[0], side))
        placed = replace(plain, start=pose, target=there, robot_radius=radius)
        return with_fitting_heading(placed)

    index = st.integers(0, len(free) - 1)
    return st.builds(place, index, st.integers(0, 15), index, st.sampled_from(radii))
