"""Measure how often the thesis's robots enter walls.

It uses scattered worlds and U traps, by rule, cause and repair. ``python -m
benchmarks.thesis_faults`` prints the figures of ``docs/notes/thesis.md``; ``--json`` prints
one object. It takes about four minutes.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import click
import numpy as np
import numpy.typing as npt

from sim.episode import prepare
from sim.outcome import Outcome
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, decide
from worldgen.world import Pose, Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--worlds", "2", "--steps", "200")

# Cells.
SIDE = 30
# Five minutes at the thesis's 15 ms.
STEPS = 20_000
# Heading, rad: the thesis's 4.5 on its screen, in the world's frame.
_HEADING = -1.3584073464102069
# The thesis's default start, (35, 35) px from the upper left.
_START = (3, SIDE - 4)
# Near the centre, or in the far corner.
_TARGETS = ((SIDE // 2, SIDE // 2 - 1), (SIDE - 3, 2))
_REPAIRS = ("repair_slide", "repair_back_off", "repair_corner")

Walls = npt.NDArray[np.bool_]


def scattered(stream: RandomStream) -> Walls:
    """Place 10 to 30 blocks of 1 to 3 by 1 to 3 cells anywhere in a hall with a border."""
    walls = _hall()
    for _ in range(stream.between(10, 30)):
        width = stream.between(1, 3)
        height = stream.between(1, 3)
        ix = stream.between(1, SIDE - 1 - width)
        iy = stream.between(1, SIDE - 1 - height)
        walls[iy : iy + height, ix : ix + width] = True
    return walls


def u_traps(stream: RandomStream, count: int) -> Walls:
    """Place Us of 5 to 12 by 4 to 12 cells, walls one or two cells thick, open to any side.

    They may overlap.
    """
    walls = _hall()
    for _ in range(count):
        width = stream.between(5, 12)
        depth = stream.between(4, 12)
        thick = stream.between(1, 2)
        shape = np.ones((depth, width), bool)
        shape[thick:, thick : width - thick] = False
        shape = np.rot90(shape, stream.below(4))
        ix = stream.between(1, SIDE - 1 - shape.shape[1])
        iy = stream.between(1, SIDE - 1 - shape.shape[0])
        walls[iy : iy + shape.shape[0], ix : ix + shape.shape[1]] |= shape
    return walls


KINDS: dict[str, Callable[[RandomStream], Walls]] = {
    "scattered": scattered,
    "one U": partial(u_traps, count=1),
    "four Us": partial(u_traps, count=4),
}


def draw_worlds(kind: str, count: int, seed: int) -> Iterator[World]:
    """Yield the worlds of a kind with reachable targets; others are drawn again."""
    stream = RandomStream(seed).child(kind)
    while count:
        walls = KINDS[kind](stream)
        target = stream.choice(_TARGETS)
        for ix, iy in (_START, target):
            walls[iy - 1 : iy + 2, ix - 1 : ix + 2] = False
        start = Pose(_centre(_START[0]), _centre(_START[1]), _HEADING)
        world = World(walls, start, Target(_centre(target[0]), _centre(target[1]), 0.05))
        if decide(world).result == REACHABLE:
            count -= 1
            yield world


def tally(worlds: list[World], controller: str, steps: int = STEPS) -> Counter[str]:
    """Return how many runs overlap a wall or enter one, by cause, and how many arrive."""
    scenario = Scenario.parse(controller, motion="stepped")
    counts = Counter[str]()
    for number, world in enumerate(worlds):
        outcome = _run(world, scenario, number, steps)
        tunnelled = outcome.ending == Verdict.TUNNEL
        counts["tunnel"] += tunnelled
        counts["overlap"] += tunnelled or outcome.overlap_step >= 0
        counts["reached"] += outcome.ending == Verdict.REACHED
        if outcome.cause:
            counts[f"{outcome.cause} {'tunnel' if tunnelled else 'overlap'}"] += 1
    return counts


def _run(world: World, scenario: Scenario, number: int, steps: int) -> Outcome:
    options = scenario.options(world, steps)
    seed = RandomStream(scenario.run.seed).child("run", number).next64()
    return prepare(world, scenario.controller, replace(options, seed=seed)).run(
        steps, find_loop=True, record=False
    )


def _hall() -> Walls:
    walls = np.zeros((SIDE, SIDE), bool)
    walls[[0, -1], :] = True
    walls[:, [0, -1]] = True
    return walls


def _centre(index: int) -> float:
    return (2 * index + 1) / 20


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--worlds", type=int, default=4000, help="worlds of each kind (default 4000)"
    )
    parser.add_argument(
        "--steps", type=int, default=STEPS, help="budget of a run in steps (default 20000)"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the worlds (default 1)")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    # All rules and repairs drive in the same worlds, so their counts are comparable.
    worlds = {kind: list(draw_worlds(kind, given.worlds, given.seed)) for kind in KINDS}
    table: dict[str, dict[str, dict[str, int]]] = {}
    for repairs in [("keep_going",), *_sets_of(_REPAIRS)]:
        name = " + ".join(repairs) or "none"
        table[name] = {}
        for kind, rule in itertools.product(KINDS, (1, 2, 3)):
            robot = "+".join((f"thesis-{rule}", *repairs))
            counts = table[name][f"{kind}, thesis-{rule}"] = dict(
                tally(worlds[kind], robot, given.steps)
            )
            if not given.json:
                click.echo(f"{name}; {kind}; thesis-{rule}: {_in_words(counts, given.worlds)}")
    if given.json:
        click.echo(
            json.dumps(
                {"worlds": given.worlds, "steps": given.steps, "seed": given.seed, "runs": table}
            )
        )


def _sets_of(names: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    for size in range(len(names) + 1):
        yield from itertools.combinations(names, size)


def _in_words(counts: dict[str, int], worlds: int) -> str:
    shares = (f"{name} {100 * count / worlds:.2f} %" for name, count in sorted(counts.items()))
    return ", ".join(shares)


if __name__ == "__main__":
    main()
