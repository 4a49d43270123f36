"""Search for worlds that do what the thesis's prose says of its third and sixth configurations.

A hill climb changes the numbers of a few rectangular obstacles and a target. It looks for worlds in
which rules 1 and 2 meet their published figures within one per cent, rule 3 ranks as in the table,
and each rule does what the prose says. The same seed and rounds find the same worlds everywhere.

``python -m benchmarks.thesis_prose 6 --out config-06.grid`` writes the best one.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import click
import numpy as np
import numpy.typing as npt

from benchmarks.thesis_symmetric import (
    CELL,
    SIDE,
    START,
    have_arrived,
    search_options,
    write_proved,
)
from sim import simulate, simulate_many
from sim.evidence import LoopEvidence
from worldgen.files.whole import check_output
from worldgen.world import Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--rounds", "1", "3")

STEPS = 3000
CHANCE_STEPS = 6000
SEEDS = 20
LOOP_STEPS = 6000
# How many worlds a round draws, keeps, changes, how often, and into how many others.
DRAWN = 400
KEPT = 14
GENERATIONS = 16
CHANGED = 14
# The times are met if the sum of the logarithms of their ratios is below this.
NEAR = 0.01
# Beyond this sum, neither the prose nor rule 3 is looked at.
FAR = 0.4
# What it costs that they were not looked at, and that rule 3 was not.
UNSEEN = 1.5
UNTRIED = 0.24
# A robot touches a box if its centre is this close to it, cells.
TOUCH = 1.2

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


class Box(NamedTuple):
    """Cells [left, right) x [low, high)."""

    left: int
    low: int
    right: int
    high: int

    def gap_to(self, other: Box) -> Box:
        """Return the rectangle between this box and another one."""
        columns = sorted((self.left, self.right, other.left, other.right))[1:3]
        rows = sorted((self.low, self.high, other.low, other.high))[1:3]
        return Box(columns[0], rows[0], columns[1], rows[1])

    def distance(self, x: Floats, y: Floats) -> Floats:
        """Return the distances of points, cells; 0 inside."""
        dx = np.maximum(np.maximum(self.left - x, x - self.right), 0.0)
        dy = np.maximum(np.maximum(self.low - y, y - self.high), 0.0)
        return np.hypot(dx, dy)


class Drawing(NamedTuple):
    """Obstacles and a target: the numbers that the search changes, cells.

    Args:
        numbers: Left column, lowest row, width and height of each obstacle; column and row of the
        target.
    """

    numbers: tuple[int, ...]

    @property
    def boxes(self) -> list[Box]:
        """The obstacles."""
        rows = zip(*(iter(self.numbers[:-2]),) * 4, strict=True)
        return [Box(left, low, left + wide, low + tall) for left, low, wide, tall in rows]

    def world(self, first: int = 0) -> World | None:
        """Return the hall with this obstacle and all later ones; ``None`` if they do not fit."""
        # Draw the border and the obstacles, which keep clear of it and of each other.
        walls = np.zeros((SIDE, SIDE), np.bool_)
        for box in self.boxes[first:]:
            fits = 2 <= box.left < box.right <= SIDE - 2 and 2 <= box.low < box.high <= 24
            if not fits or walls[box.low - 1 : box.high + 1, box.left - 1 : box.right + 1].any():
                return None
            walls[box.low : box.high, box.left : box.right] = True
        walls[[0, -1]] = True
        walls[:, [0, -1]] = True

        # The target is in the lower right, as in the other configurations, and has room.
        column, row = self.numbers[-2:]
        if not (18 <= column <= SIDE - 3 and 2 <= row <= 11):
            return None
        if walls[row - 1 : row + 2, column - 1 : column + 2].any():
            return None
        x, y = (round((place + 0.5) * CELL, 9) for place in (column, row))
        return World(walls, START, Target(x, y, 0.05))

    def changed(self, rng: random.Random) -> Drawing:
        """Return a drawing that differs in one to four numbers."""
        numbers = list(self.numbers)
        for _ in range(rng.choice((1, 1, 2, 3, 4))):
            numbers[rng.randrange(len(numbers))] += rng.choice((-3, -2, -1, 1, 2, 3))
        return Drawing(tuple(numbers))


@dataclass(frozen=True)
class DrivenPath:
    """What a rule does in a drawing.

    Args:
        x: Position after each step, cells.
        y: The same.
        touched: By obstacle and step, whether the robot touches it.
        period: Period of its loop, in steps; 0 if it does not loop.
    """

    x: Floats
    y: Floats
    touched: Bools
    period: int

    @property
    def first(self) -> int:
        """The obstacle that it touches first; -1 for none."""
        steps = np.where(self.touched.any(axis=1), self.touched.argmax(axis=1), len(self.x))
        return int(steps.argmin()) if self.touched.any() else -1

    def within(self, box: Box) -> Bools:
        """Return whether the robot's centre is in a box, by step."""
        return box.distance(self.x, self.y) == 0.0


def driven(drawing: Drawing, world: World, rule: str, steps: int) -> DrivenPath:
    """Return what a rule does in a world."""
    episode = simulate(world, rule, motion="stepped", steps=steps, record=True)
    trace = episode.trace
    assert trace is not None  # it was recorded
    x = np.asarray(trace.x) / CELL
    y = np.asarray(trace.y) / CELL
    near = np.array([box.distance(x, y) < TOUCH for box in drawing.boxes])
    evidence = episode.evidence
    period = evidence.period if isinstance(evidence, LoopEvidence) else 0
    return DrivenPath(x, y, near & np.asarray(trace.bump, np.bool_), period)


def lacks_of_third(drawing: Drawing, world: World) -> float:
    """Return how much a world lacks of the prose on configuration 3; 0 for nothing.

    Rule 1 meets the middle obstacle first, is trapped between the lower two for a while, touches
    both often, and leaves from near the middle between them without touching anything again. Rule 2
    passes between two obstacles.
    """
    middle, left, right = drawing.boxes
    if max(left.high, right.high) >= middle.low or left.right >= right.left:
        return 4.0
    if not (middle.left >= 7 and middle.right <= 20):
        return 4.0
    # Rule 1: what it touches, how long it is between the lower two, and how it leaves.
    one = driven(drawing, world, "thesis-1", STEPS)
    between = Box(left.right, min(left.low, right.low), right.left, max(left.high, right.high))
    inside = one.within(between)
    lacks = 0.0 if one.first == 0 else 0.3
    lacks += 0.25 * int((one.touched[1:].sum(axis=1) < 5).sum())
    lacks += 0.25 * (1.0 - min(float(inside.sum()) / 200.0, 1.0))
    leaves = int(np.flatnonzero(one.touched.any(axis=0)).max(initial=0))
    after = one.x[leaves:][inside[leaves:]]
    half = (between.right - between.left) / 2
    aside = float(np.abs(after - between.left - half).min(initial=half)) / half
    if aside > 0.5:
        lacks += 0.2 * aside
    # Rule 2: how near it comes to passing between two of them.
    two = driven(drawing, world, "thesis-2", STEPS)
    gaps = [middle.gap_to(right), left.gap_to(right)]
    missed = min(float(gap.distance(two.x, two.y).min()) for gap in gaps)
    return lacks + (0.1 + 0.15 * min(missed / 6.0, 1.0) if missed > 0.0 else 0.0)


def lacks_of_sixth(drawing: Drawing, world: World) -> float:
    """Return how much a world lacks of the prose on configuration 6; 0 for nothing.

    Rule 1 touches both obstacles. Rule 2 meets the first one, which leads it to the right, to the
    second one, where it is caught in a loop; without the first one it would arrive.
    """
    first, second = drawing.boxes
    if first.right >= second.left:
        return 4.0
    one = driven(drawing, world, "thesis-1", STEPS)
    lacks = 0.0
    for box, touched in zip((first, second), one.touched.any(axis=1), strict=True):
        if not touched:
            lacks += 0.1 + 0.15 * min(float(box.distance(one.x, one.y).min()) / 8.0, 1.0)
    two = driven(drawing, world, "thesis-2", LOOP_STEPS)
    lacks += 0.0 if two.first == 0 else 0.25
    if not two.period:
        lacks += 0.3
    elif not two.touched[1, -two.period :].any():
        lacks += 0.2
    free = drawing.world(first=1)
    alone = simulate_many([free] if free else [], "thesis-2", motion="stepped", steps=STEPS)
    return lacks + (0.0 if have_arrived(alone).all() else 0.2)


class Configuration(NamedTuple):
    """What is published about a configuration, and where the search for it begins.

    Args:
        ticks: Ticks until each deterministic rule arrives, if it does.
        chance: Ticks in which the median of rule 3's runs must arrive, so that it ranks as
            published.
        lacks: Returns how much a world lacks of the prose.
        lows: Smallest value of each of a drawing's numbers.
        highs: Greatest value of each.
    """

    ticks: Mapping[str, int]
    chance: tuple[int, int]
    lacks: Callable[[Drawing, World], float]
    lows: tuple[int, ...]
    highs: tuple[int, ...]

    def drawn(self, rng: random.Random) -> Drawing:
        """Return any drawing."""
        ends = zip(self.lows, self.highs, strict=True)
        return Drawing(tuple(rng.randint(low, high) for low, high in ends))


CONFIGURATIONS = {
    3: Configuration(
        {"thesis-1": 1933, "thesis-2": 426},
        (520, 1800),
        lacks_of_third,
        (7, 12, 2, 1, 3, 4, 2, 1, 12, 4, 2, 1, 19, 2),
        (17, 20, 9, 5, 14, 13, 12, 7, 24, 13, 8, 7, 27, 10),
    ),
    6: Configuration(
        {"thesis-1": 999},
        (1000, 2000),
        lacks_of_sixth,
        (3, 10, 2, 1, 9, 5, 2, 1, 19, 2),
        (14, 20, 9, 6, 23, 18, 12, 8, 27, 10),
    ),
}


@dataclass
class Search:
    """A search for worlds of one configuration.

    Args:
        wanted: The configuration.
        rng: Source of all that is drawn.
    """

    wanted: Configuration
    rng: random.Random
    tried: dict[Drawing, Found] = field(default_factory=dict)

    def climb(self) -> None:
        """Draw, keep the best, and change them for some generations."""
        best = self._best([self.wanted.drawn(self.rng) for _ in range(DRAWN)])
        for _ in range(GENERATIONS):
            others = [one.changed(self.rng) for one in best for _ in range(CHANGED)]
            best = self._best([*best, *others])

    def _best(self, drawings: list[Drawing]) -> list[Drawing]:
        new = [one for one in dict.fromkeys(drawings) if one not in self.tried]
        worlds = [one.world() for one in new]
        fit = [world for world in worlds if world is not None]
        misses = iter(self._misses(fit) if fit else [])
        for one, world in zip(new, worlds, strict=True):
            miss = math.inf if world is None else next(misses)
            self.tried[one] = self._found(one, world, miss)
        return sorted(set(drawings), key=lambda one: (self.tried[one].cost, one))[:KEPT]

    def _misses(self, worlds: list[World]) -> list[float]:
        """Return how far both rules are from their times, as a sum of logarithms."""
        rules = list(self.wanted.ticks)
        runs = simulate_many(worlds, rules, motion="stepped", steps=STEPS)
        steps = runs.steps.reshape(-1, len(rules))
        off = np.abs(np.log(steps / np.array([*self.wanted.ticks.values()]))).sum(axis=1)
        all_arrive = have_arrived(runs).reshape(-1, len(rules)).all(axis=1)
        return [float(one) for one in np.where(all_arrive, off, math.inf)]

    def _found(self, drawing: Drawing, world: World | None, miss: float) -> Found:
        if world is None or miss > FAR:
            return Found(miss, UNSEEN, math.inf, miss + UNSEEN + UNTRIED)
        lacks = self.wanted.lacks(drawing, world)
        if lacks > 0.0:
            return Found(miss, lacks, math.inf, miss + lacks + UNTRIED)
        # Seeds that never arrive count as infinitely slow.
        runs = simulate_many(world, "thesis-3", motion="stepped", steps=CHANCE_STEPS, seeds=SEEDS)
        median = float(np.median(np.where(have_arrived(runs), runs.steps, math.inf)))
        nearest = min(max(median, self.wanted.chance[0]), self.wanted.chance[1])
        late = min(0.1 * abs(math.log(nearest / median)) if median < math.inf else 1.0, UNTRIED)
        return Found(miss, lacks, median, miss + late)

    def found(self) -> list[tuple[Found, Drawing]]:
        """Return what fits the prose and the figures, the best first."""
        low, high = self.wanted.chance
        return sorted(
            (one, drawing)
            for drawing, one in self.tried.items()
            if one.miss < NEAR and one.lacks == 0.0 and low <= one.median <= high
        )


class Found(NamedTuple):
    """How near a drawing comes to what is wanted.

    Args:
        miss: How far the deterministic rules are from their times.
        lacks: How much of the prose it lacks.
        median: Median of rule 3's ticks; infinity if it was not tried.
        cost: What the climb makes small.
    """

    miss: float
    lacks: float
    median: float
    cost: float


def main() -> None:
    """Search, print what was found, and write the best."""
    parser = search_options(__doc__, seed=1)
    parser.add_argument("configuration", type=int, choices=sorted(CONFIGURATIONS))
    options = parser.parse_args()

    # Search, after a look at where the result goes.
    if options.out is not None:
        check_output(options.out, force=False)
    search = Search(CONFIGURATIONS[options.configuration], random.Random(options.seed))
    for _ in range(options.rounds):
        search.climb()

    # Count how many meet each demand.
    met = [one for one in search.tried.values() if one.miss < NEAR]
    full = [one for one in met if one.lacks == 0.0]
    fits = search.found()
    click.echo(
        f"of {len(search.tried):,} drawings {len(met)} meet the times of rules 1 and 2, "
        f"{len(full)} of them do what the prose says, and {len(fits)} of those fit rule 3"
    )

    # Print the best, and write the very best with its certificate.
    for one, drawing in fits[:10]:
        click.echo(f"miss {one.miss:.4f}, rule 3 {one.median:g} ticks: {drawing.numbers}")
    if fits:
        write_proved(fits[0][1].world(), options.out)


if __name__ == "__main__":
    main()
