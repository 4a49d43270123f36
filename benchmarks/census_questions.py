"""Judge every map at every radius: does the disc reach the target, and does a grid path exist?"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from benchmarks.foreign_maps import CensusMap, Ends, Refused, cell_at, draw_ends
from worldgen.errors import InvalidWorld, WorldgenError
from worldgen.lattice import exact, in_cells
from worldgen.random_streams import RandomStream
from worldgen.reach import BLOCKED, REACHABLE, check_certificate, decide
from worldgen.world import Cut, World

ROWS = (
    "reachable", "blocked", "no_room", "four_only", "four_parted", "eight_only", "eight_parted", "undecided",
)  # fmt: skip
"""What is counted for each radius; docs/notes/census.md describes it."""


@dataclass(frozen=True)
class Radius:
    """A radius, in m or in cells of each map."""

    value: float
    cells: bool = False

    def metres(self, cell_size: float) -> float:
        """Return the radius in m, on a map with cells of ``cell_size`` m."""
        return float(exact(self.value) * exact(cell_size)) if self.cells else self.value

    def in_cells(self, cell_size: float) -> Fraction:
        """Return exactly the radius of :meth:`metres`, in cells."""
        return in_cells(self.metres(cell_size), cell_size)

    def __str__(self) -> str:
        return f"{self.value:g} cells" if self.cells else f"{self.value:g} m"


@dataclass(frozen=True)
class CensusOptions:
    """The questions that a census asks about every map.

    Args:
        radii: Radii of the robot.
        pairs: Starts and targets to draw on a map that names none.
        seed: Seed of the draw.
        clear_ends: True to draw pairs only where the largest disc has room.
    """

    radii: tuple[Radius, ...]
    pairs: int = 1
    seed: int = 0
    clear_ends: bool = False


@dataclass(frozen=True)
class CensusCase:
    """One map, one start and target, one radius, and the answers.

    Args:
        map: Name of the map.
        named: True if the map names start and target.
        asked: The radius.
        side: Longer side of the map, cells.
        result: The prover's answer about the disc.
        proved: True if the checker confirms the certificate.
        room: True if the disc is clear at the start and at some pose of the target; False only if
            proved.
        four: True if a path exists between cells that share a side.
        eight: True if a path exists that may also move between cells that share a corner, no matter
            what is next to that corner.
        seconds: Time spent in prover and checker.
    """

    map: str
    named: bool
    asked: Radius
    side: int
    result: str
    proved: bool
    room: bool
    four: bool
    eight: bool
    seconds: float = field(compare=False)

    @property
    def grid_only(self) -> bool:
        """True if a grid path exists although it is proved that the disc cannot get there."""
        return self.proved and self.result == BLOCKED and self.eight


@dataclass
class Census:
    """The answers, in the order of the maps, and the maps that could not be judged."""

    questions: list[CensusCase] = field(default_factory=list)
    refused: list[Refused] = field(default_factory=list)
    maps: int = 0


def take_census(
    maps: Iterable[CensusMap | Refused],
    options: CensusOptions,
    each: Callable[[CensusCase, World], object] | None = None,
) -> Census:
    """Judge maps one after another; ``each`` gets every answer and its world, with the proof."""
    census = Census()
    names = Counter[str]()
    for item in maps:
        if isinstance(item, Refused):
            census.refused.append(item)
            continue
        names[item.name] += 1
        again = "" if names[item.name] == 1 else f"-{names[item.name]}"
        _judge(census, replace(item, name=f"{item.name}{again}"), options, each)
    return census


def _judge(
    census: Census,
    item: CensusMap,
    options: CensusOptions,
    each: Callable[[CensusCase, World], object] | None,
) -> None:
    """Answer every question about one map, or none if the map has a fault."""
    try:
        ends = item.ends or _drawn(item, options)
        worlds = [World(item.walls, pair.start, pair.target, item.cell_size) for pair in ends]
    except (InvalidWorld, WorldgenError) as error:
        census.refused.append(Refused(item.name, str(error)))
        return
    # Label the regions in which a grid path moves freely, with four and with eight moves.
    four: Any = ndimage.label(~item.walls)[0]
    eight: Any = ndimage.label(~item.walls, structure=np.ones((3, 3)))[0]

    for pair, world in zip(ends, worlds, strict=True):
        joined = (_joined(four, item, pair), _joined(eight, item, pair))
        for radius in options.radii:
            question, judged = _answer(item, pair, world, radius, joined)
            census.questions.append(question)
            if each is not None:
                each(question, judged)
    census.maps += 1


def _joined(regions: npt.NDArray[Any], item: CensusMap, pair: Ends) -> bool:
    """Return True if start and target are in the same region; region 0 is the walls."""
    start, target = (
        regions[cell_at(item.walls, item.cell_size, place.x, place.y)]
        for place in (pair.start, pair.target)
    )
    return bool(start != 0 and start == target)


def _drawn(item: CensusMap, options: CensusOptions) -> tuple[Ends, ...]:
    rng = RandomStream(options.seed).child("census", item.name)
    widest: Fraction | None = None
    if options.clear_ends:
        widest = max(radius.in_cells(item.cell_size) for radius in options.radii)
    return draw_ends(item, options.pairs, rng, widest)


def _answer(
    item: CensusMap, pair: Ends, world: World, radius: Radius, joined: tuple[bool, bool]
) -> tuple[CensusCase, World]:
    """Return one question with its answers, and the world with its certificate."""
    world = replace(world, robot_radius=radius.metres(item.cell_size))
    began = time.perf_counter()
    decision = decide(world)
    cut = decision.certificate
    world = replace(world, certificate=cut)
    proved = cut is not None and check_certificate(world).valid
    seconds = time.perf_counter() - began
    # A cut of one cell only occurs where the cell is too near to the start or blocks every target
    # pose.
    room = not (isinstance(cut, Cut) and len(cut.cells) == 1)
    side = max(world.width, world.height)
    question = CensusCase(
        item.name, pair.named, radius, side, decision.result, proved, room, *joined, seconds
    )
    return question, world


def counts(questions: Sequence[CensusCase]) -> Counter[str]:
    """Return the number of questions in each of :data:`ROWS`."""
    total = Counter[str]()
    for question in questions:
        if not question.proved:
            total["undecided"] += 1
        elif question.result == REACHABLE:
            total["reachable"] += 1
        else:
            total["blocked"] += 1
            total["no_room"] += not question.room
            for name, path in (("four", question.four), ("eight", question.eight)):
                total[f"{name}_only"] += path
                total[f"{name}_parted"] += path and question.room
    return total
