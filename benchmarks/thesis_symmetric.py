"""Search for a symmetric wall that gives the times of the thesis's second configuration.

The thesis draws a symmetric wall there, around whose two ends rules 1 and 2 go. A hill climb tries
walls that are mirror images of themselves by construction, a rectangle with or without a block in
its middle, and targets below them. It keeps those in which both rules take the published number of
ticks, go around different ends, and rule 3 is slower than both. The same seed and rounds find the
same walls on every machine.

``python -m benchmarks.thesis_symmetric --out config-02.grid`` writes the best one.
"""

from __future__ import annotations

import argparse
import math
import random
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np
import numpy.typing as npt

from sim import Runs, simulate, simulate_many
from sim.verdict import Verdict
from worldgen import write_world
from worldgen.reach import decide
from worldgen.world import Pose, Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--rounds", "1")

# Ticks of rules 1 and 2 in configuration 2: the published times, 11.940 and 8.370 s.
TICKS = (796, 558)
RULES = ("thesis-1", "thesis-2")
# The thesis's hall and start.
SIDE = 30
CELL = 0.1
START = Pose(0.35, 2.65, -1.3584073464102069)
# Ticks in which the median of rule 3's runs must arrive.
CHANCE = (1200, 4500)
STEPS = 3000
# How many walls a round draws, keeps and changes, how often, and into how many others.
DRAWN = 400
KEPT = 20
CHANGED = 12
GENERATIONS = 12


@dataclass(frozen=True, order=True)
class Wall:
    """A wall that is its own mirror image, and a target; lengths in cells.

    Args:
        left: First column.
        width: Columns.
        low: First row.
        height: Rows.
        block: Columns of the block in its middle; 0 for none.
        rise: Rows of the block, above the wall.
        target_x: The target, in twentieths of a metre.
        target_y: The same.
    """

    left: int
    width: int
    low: int
    height: int
    block: int
    rise: int
    target_x: int
    target_y: int

    def world(self) -> World | None:
        """Return the hall with this wall; ``None`` if they do not fit."""
        # The wall has room on every side, and the post is on its middle.
        right = self.left + self.width
        top = self.low + self.height
        inside = self.left >= 2 and right <= SIDE - 2 and self.low >= 2 and top + self.rise <= 24
        centred = 0 <= self.block < self.width and (self.width - self.block) % 2 == 0
        if not (inside and self.width >= 3 and self.height >= 1 and self.rise >= 1):
            return None
        if self.block and not centred:
            return None
        # Draw the border, the wall and the post above it.
        walls = np.zeros((SIDE, SIDE), np.bool_)
        walls[[0, -1]] = True
        walls[:, [0, -1]] = True
        walls[self.low : top, self.left : right] = True
        if self.block:
            first = self.left + (self.width - self.block) // 2
            walls[top : top + self.rise, first : first + self.block] = True

        # The target is in the lower right, as in the other configurations, and has room.
        x = self.target_x / 20
        y = self.target_y / 20
        column = int(x / CELL)
        row = int(y / CELL)
        if x <= 0.6 * SIDE * CELL or y >= 0.4 * SIDE * CELL:
            return None
        if column > SIDE - 3 or row < 2 or walls[row - 1 : row + 2, column - 1 : column + 2].any():
            return None
        return World(walls, START, Target(x, y, 0.05))

    def changed(self, rng: random.Random) -> Wall:
        """Return a wall that differs in one to three numbers."""
        values = list(self.__dict__.values())
        for _ in range(rng.choice((1, 1, 2, 3))):
            place = rng.randrange(len(values))
            values[place] += rng.choice((-2, -1, 1, 2))
        return Wall(*values)

    @classmethod
    def drawn(cls, rng: random.Random) -> Wall:
        """Return any wall."""
        width = rng.randint(4, 18)
        block = rng.choice((0, 2 - width % 2))
        return cls(
            rng.randint(2, 20),
            width,
            rng.randint(8, 20),
            rng.randint(1, 3),
            block,
            rng.randint(1, 4),
            rng.randint(37, 55),
            rng.randint(5, 23),
        )


def misses(walls: list[Wall]) -> list[float]:
    """Return how far both rules are from their times in each wall, as a sum of logarithms."""
    # Run all worlds in one batch; walls that do not fit miss by any measure.
    worlds = [wall.world() for wall in walls]
    fit = [world for world in worlds if world is not None]
    found = {}
    if fit:
        runs = simulate_many(fit, RULES, motion="stepped", steps=STEPS)
        steps = runs.steps.reshape(-1, 2)
        arrived = have_arrived(runs).reshape(-1, 2)
        off = np.abs(np.log(steps / np.array(TICKS))).sum(axis=1)
        found = dict(zip(map(id, fit), np.where(arrived.all(axis=1), off, math.inf), strict=True))
    return [math.inf if world is None else float(found[id(world)]) for world in worlds]


def have_arrived(runs: Runs) -> npt.NDArray[np.bool_]:
    """Return which of many runs arrived."""
    return np.array([verdict == Verdict.REACHED for verdict in runs.verdicts], np.bool_)


def tells_the_same(wall: Wall) -> bool:
    """Return True if the rules go around different ends, and chance is slower than both."""
    world = wall.world()
    if world is None:
        return False
    # A rule goes around the end on whose side it is when it first gets below the wall's middle.
    middle = (wall.low + wall.height / 2) * CELL
    sides = []
    for rule in RULES:
        trace = simulate(world, rule, motion="stepped", steps=STEPS, record=True).trace
        if trace is None:
            return False
        passes = int(np.argmax(np.asarray(trace.y) < middle))
        sides.append(trace.x[passes] < (wall.left + wall.width / 2) * CELL)
    # Seeds that never arrive count as infinitely slow.
    runs = simulate_many(world, "thesis-3", motion="stepped", steps=20_000, seeds=20)
    arrived = have_arrived(runs)
    median = float(np.median(np.where(arrived, runs.steps, math.inf)))
    return sides[0] != sides[1] and CHANCE[0] <= median <= CHANCE[1]


def found(rounds: int, seed: int) -> list[tuple[float, Wall]]:
    """Return walls that meet both times within one per cent and do as the text says, best first.

    Args:
        rounds: Hill climbs, each from other walls.
        seed: Of all that is drawn.
    """
    rng = random.Random(seed)
    kept: dict[Wall, float] = {}
    for _ in range(rounds):
        walls = [Wall.drawn(rng) for _ in range(DRAWN)]
        best = sorted(zip(misses(walls), walls, strict=True))[:KEPT]
        for _ in range(GENERATIONS):
            others = [wall.changed(rng) for _, wall in best for _ in range(CHANGED)]
            tried = zip(misses(others), others, strict=True)
            best = sorted({*best, *tried})[:KEPT]
        kept |= {wall: off for off, wall in best if off < 0.01}
    return sorted((off, wall) for wall, off in kept.items() if tells_the_same(wall))


def search_options(description: str | None, *, seed: int) -> argparse.ArgumentParser:
    """Return the parser of a search's options.

    Args:
        description: What the search does.
        seed: The usual seed.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--rounds", type=int, default=10, help="hill climbs (default 10)")
    parser.add_argument(
        "--seed", type=int, default=seed, help=f"of all that is drawn (default {seed})"
    )
    parser.add_argument("--out", type=Path, help="write the best world")
    return parser


def write_proved(world: World | None, out: Path | None) -> None:
    """Write a world with its certificate, if there are a world and a file's name."""
    if world is not None and out is not None:
        write_world(replace(world, certificate=decide(world).certificate), out)


def main() -> None:
    """Search, print what was found, and write the best."""
    options = search_options(__doc__, seed=7).parse_args()
    walls = found(options.rounds, options.seed)
    click.echo(f"{len(walls)} symmetric walls within one per cent of both times")
    for off, wall in walls[:10]:
        click.echo(f"{off:.4f} {wall}")
    if walls:
        write_proved(walls[0][1].world(), options.out)


if __name__ == "__main__":
    main()
