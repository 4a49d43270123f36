"""Ways to search for a controller's failures, for ``benchmarks.finding`` to compare.

All of them pass their failures through the same triage. Given a campaign's configuration, a
searcher yields the results of one unit after another, endlessly, each with the number of worlds in
the configuration. The lanes are those of the product. The other two are simple alternatives:

- ``random``: uniformly random cells. Arena, density, start, heading and target are drawn as well,
  until a witness shows that the target can be reached.
- ``genetic``: a genetic algorithm over the bytes of a feature layout. The more time a robot takes
  beyond the straight path, the fitter is the layout. A layout in which the robot fails is a find,
  and has no children.

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

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.result import SearchState, UnitResult
from fuzz.campaign.unit import run_unit
from fuzz.search.features import LAYOUT_BYTES, decode_world
from fuzz.triage.proofs import certified
from fuzz.triage.triage import Triage
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

__all__ = ["SEARCHERS", "STILL_FAMILIES", "Searcher", "genetic", "lanes", "random_cells"]

Searcher = Callable[[CampaignConfig], Iterator[UnitResult]]

STILL_FAMILIES = ("trap", "maze", "corridor", "rooms", "forest", "cave", "rubble")
"""Families whose worlds do not change; in worlds that do, no controller arrives everywhere."""

_DENSITIES = (
    0.05,
    0.1,
    0.15,
    0.2,
    0.25,
    0.3,
)  # beyond, hardly any way is left for a robot wider than a cell
_SIDES = (8, 28)  # cells, as in feature layouts
_POPULATION = 50
_CROSSOVER = 0.9
_MUTATION = 2.0 / LAYOUT_BYTES  # probability for each byte
_WORDS = LAYOUT_BYTES // 8


def lanes(*names: str) -> Searcher:
    """Return a searcher with these lanes; without any, the campaign's own plan."""

    def units(config: CampaignConfig) -> Iterator[UnitResult]:
        config = replace(config, families=names)
        # One epoch after another, as in a campaign.
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
    """Search uniformly random cells at several densities, with reachable targets."""
    stream = RandomStream(config.seed).child("random cells")
    while True:
        door = Triage(config, UnitResult(lane="random"))
        for _ in range(config.examples):
            world = None
            while world is None:
                world = certified(_random_world(stream))
            _look(door, config, world, stream)
        yield door.result


def genetic(config: CampaignConfig) -> Iterator[UnitResult]:
    """Run a genetic algorithm over feature layouts, one child at a time.

    Each child replaces a less fit layout.
    """
    stream = RandomStream(config.seed).child("genetic")
    population: list[tuple[float, bytes]] = []
    while True:
        door = Triage(config, UnitResult(lane="genetic"))
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
    """Return a child of two parents, by tournaments of two, one-point crossover and mutation."""
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
    """Run a reachable world.

    Return the time that the robot took divided by that of the straight path; 0 if it failed.
    """
    scenario = replace(config.scenario, seed=stream.below(1 << 32))
    budget = step_budget(world, scenario.time_step)
    try:
        run = prepare(world, CONTROLLERS.get(scenario.controller), scenario.options(world, budget))
    except InvalidWorld:
        return 0.0
    outcome = run.run(budget, find_loop=True, record=False, digest=False)
    door.look(world, scenario, outcome)
    way = math.dist((world.start.x, world.start.y), (world.target.x, world.target.y))
    took = outcome.steps * scenario.time_step * world.robot_speed
    return took / max(way, world.cell_size) if outcome.ending == Verdict.REACHED else 0.0


def _random_world(stream: RandomStream) -> World:
    """Return a world whose cells are solid or not, independently of each other.

    Cells around start and target are free, and the border is solid.
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
    "plan": lanes(),
    "native": lanes("native"),
    "archive": lanes("archive"),
    "features": lanes("features"),
    "families": lanes(*STILL_FAMILIES),
    "boundary": lanes("boundary"),
    "random": random_cells,
    "genetic": genetic,
}
"""The searchers by name, in the order of the table.

``plan`` is the campaign as it is, in which lanes share by its own plan.
"""
