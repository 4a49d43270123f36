"""Searchers for a controller's failures, compared by ``benchmarks.finding``.

All of them hand failures to triage. Given a campaign's configuration, a searcher yields one unit's
result after another, endlessly, each with as many worlds as configured. The strategies are the
product's; the two others are what one would do without it:

- ``random``: uniformly random cells. Arena, density, start, heading and target are drawn, too,
  until a witness shows that the target can be reached.
- ``genetic``: a genetic algorithm over the bytes of a feature layout. The more time a robot takes
  beyond the straight path, the fitter the layout; a layout in which it fails counts as found, and
  has no children.

Source: Dmytro Humeniuk, Foutse Khomh and Giuliano Antoniol, "A search-based framework for automatic
    generation of testing environments for cyber-physical systems", Information and Software
    Technology 149 (2022), for the robot's path as fitness, one-point crossover and mutation of an
    environment's elements; Darrell Whitley, "The GENITOR algorithm and selection pressure", ICGA
    1989, for one child at a time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count

from fuzz.campaign.unit import run_unit
from fuzz.facts.proofs import certified
from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from fuzz.triage.triage import Triage
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import SearchState, UnitResult
from sim.controllers import CONTROLLERS
from sim.episode import prepare
from sim.options.run import step_budget
from sim.verdict import Verdict
from worldgen.errors import InvalidWorld
from worldgen.lattice import lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.world import (
    DEFAULT_CELL_SIZE,
    DEFAULT_ROBOT_RADIUS,
    DEFAULT_ROBOT_SPEED,
    Pose,
    Target,
    World,
)

Searcher = Callable[[CampaignConfig], Iterator[UnitResult]]

STILL_FAMILIES = ("trap", "maze", "corridor", "rooms", "forest", "cave", "rubble")
"""Families of static worlds: in worlds that change, no controller arrives everywhere."""

# At higher densities, hardly any path is left for a robot wider than a cell.
_DENSITIES = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
# Cells, as in feature layouts.
_SIDES = (8, 28)
_POPULATION = 50
_CROSSOVER = 0.9
# Probability for each byte.
_MUTATION = 2.0 / LAYOUT_BYTES
_WORDS = LAYOUT_BYTES // 8


def strategies(*names: str) -> Searcher:
    """Return the strategies with these names; without names, the campaign's own plan."""

    def units(config: CampaignConfig) -> Iterator[UnitResult]:
        config = replace(config, families=names)
        # States by epoch, as in a campaign.
        memory = SearchState()
        known = [SearchState(), SearchState()]
        for unit in count():
            result = run_unit(config, unit, known[unit // config.epoch])
            memory = memory.after(result)
            if (unit + 1) % config.epoch == 0:
                known.append(memory)
            yield result

    return units


def random_cells(config: CampaignConfig) -> Iterator[UnitResult]:
    """Yield uniformly random cells at several densities, with reachable targets."""
    stream = RandomStream(config.seed).child("random cells")
    while True:
        door = Triage(config, UnitResult(strategy="random"))
        for _ in range(config.examples):
            world = None
            while world is None:
                world = certified(_random_world(stream))
            _look(door, config, world, stream)
        yield door.result


def genetic(config: CampaignConfig) -> Iterator[UnitResult]:
    """Yield a genetic algorithm over feature layouts, one child at a time.

    Each child replaces a less fit layout.
    """
    stream = RandomStream(config.seed).child("genetic")
    population: list[tuple[float, bytes]] = []
    while True:
        door = Triage(config, UnitResult(strategy="genetic"))
        while door.result.worlds < config.examples:
            full = len(population) == _POPULATION
            layout = _child(population, stream) if full else stream.bits(_WORDS).tobytes()
            world = certified(decode_world(layout))
            fitness = 0.0 if world is None else _look(door, config, world, stream)
            if not full and fitness > 0.0:
                population.append((fitness, layout))
            elif full:
                loser = min(_two(stream), key=lambda k: population[k][0])
                population[loser] = max(population[loser], (fitness, layout))
        yield door.result


def _child(population: list[tuple[float, bytes]], stream: RandomStream) -> bytes:
    """Return a child: two parents by tournaments of two, one point of crossover, mutation."""
    mother, father = (
        population[max(_two(stream), key=lambda k: population[k][0])][1] for _ in range(2)
    )
    cut = stream.below(len(mother)) if stream.random() < _CROSSOVER else 0
    child = bytearray(father[:cut] + mother[cut:])
    for k in range(len(child)):
        if stream.random() < _MUTATION:
            child[k] = stream.below(256)
    return bytes(child)


def _two(stream: RandomStream) -> tuple[int, int]:
    return stream.below(_POPULATION), stream.below(_POPULATION)


def _look(door: Triage, config: CampaignConfig, world: World, stream: RandomStream) -> float:
    """Run a reachable world and return its fitness.

    It is the robot's time divided by the straight path's, 0 if the robot does not arrive.
    """
    scenario = config.scenario.with_run(seed=stream.below(1 << 32))
    budget = step_budget(world, scenario.run)
    try:
        run = prepare(world, CONTROLLERS.get(scenario.controller), scenario.options(world, budget))
    except InvalidWorld:
        return 0.0
    outcome = run.run(budget, find_loop=True, record=False, digest=False)
    door.look(world, scenario, outcome)
    way = math.dist((world.start.x, world.start.y), (world.target.x, world.target.y))
    took = outcome.steps * scenario.run.time_step * world.robot_speed
    return took / max(way, world.cell_size) if outcome.ending == Verdict.REACHED else 0.0


def _random_world(stream: RandomStream) -> World:
    """Return random cells, each solid or free independently.

    Those around start and target are free, the border is solid.
    """
    height, width = (stream.between(*_SIDES) for _ in range(2))
    walls = stream.floats(height * width).reshape(height, width) < stream.choice(_DENSITIES)
    (ix, iy), (jx, jy) = (
        (stream.between(2, width - 3), stream.between(2, height - 3)) for _ in range(2)
    )
    for x, y in ((ix, iy), (jx, jy)):
        walls[y - 1 : y + 2, x - 1 : x + 2] = False
    walls[[0, -1], :] = walls[:, [0, -1]] = True
    return World(
        walls,
        Pose(_centre(ix), _centre(iy), stream.below(16) * (math.pi / 8)),
        Target(_centre(jx), _centre(jy), DEFAULT_CELL_SIZE / 2),
        cell_size=DEFAULT_CELL_SIZE,
        robot_radius=DEFAULT_ROBOT_RADIUS,
        robot_speed=DEFAULT_ROBOT_SPEED,
    )


def _centre(index: int) -> float:
    return lattice_to_metres(1024 * index + 512, DEFAULT_CELL_SIZE)


SEARCHERS: dict[str, Searcher] = {
    "plan": strategies(),
    "native": strategies("native"),
    "archive": strategies("archive"),
    "features": strategies("features"),
    "families": strategies(*STILL_FAMILIES),
    "boundary": strategies("boundary"),
    "random": random_cells,
    "genetic": genetic,
}
"""The searchers by name, in table order.

``plan`` is the campaign as it is, with its own plan for sharing among strategies.
"""
