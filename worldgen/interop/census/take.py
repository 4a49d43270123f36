"""Judge every map at every radius: does the disc reach the target, and does a grid path exist?"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from worldgen.errors import InvalidWorld, WorldgenError
from worldgen.interop.census.case import (
    DEFAULT_RADII,
    CensusMap,
    Ends,
    Radius,
    Refused,
    cell_at,
    draw_ends,
)
from worldgen.random_streams import RandomStream
from worldgen.reach import BLOCKED, check_certificate, decide
from worldgen.world import Cut, Provenance, Value, World

# Raise this whenever a seed draws different pairs than before.
VERSION = 1


@dataclass(frozen=True)
class CensusOptions:
    """The questions that a census asks about every map.

    Args:
        radii: Radii of the robot.
        pairs: Starts and targets to draw on a map that names none.
        seed: Seed of the draw.
        clear_ends: True to draw pairs only where the largest disc has room.
    """

    radii: tuple[Radius, ...] = DEFAULT_RADII
    pairs: int = 1
    seed: int = 0
    clear_ends: bool = False


@dataclass(frozen=True)
class CensusCase:
    """One map, one start and target, one radius, and the answers.

    Args:
        map: Name of the map.
        pair: Number of the pair in its map, from 0.
        named: True if the map names them.
        asked: The radius as the user gave it, in m or in cells.
        radius: The same radius in m.
        width: Cells.
        height: Cells.
        cell_size: m.
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
    pair: int
    named: bool
    asked: Radius
    radius: float
    width: int
    height: int
    cell_size: float
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
    """The answers so far.

    Args:
        options: The questions asked about every map.
        questions: The questions with their answers, in the order of the maps.
        refused: Maps that could not be judged.
        maps: Number of maps that were judged.
        interrupted: True if Ctrl-C ended the census.
        fault: Message of the error in a source that ended the census; empty if there was none.
    """

    options: CensusOptions
    questions: list[CensusCase] = field(default_factory=list)
    refused: list[Refused] = field(default_factory=list)
    maps: int = 0
    interrupted: bool = False
    fault: str = ""


def take_census(
    maps: Iterable[CensusMap | Refused],
    options: CensusOptions | None = None,
    *,
    each: Callable[[CensusCase, World], object] | None = None,
    progress: Callable[[], None] | None = None,
) -> Census:
    """Judge maps one after another.

    Ctrl-C, or a source that fails, ends the census; the answers so far are returned.

    Args:
        maps: Maps to judge, and refusals to pass on.
        options: The questions to ask about every map.
        each: Called with every answer and its world, which holds the certificate.
        progress: Called after each map.
    """
    census = Census(options or CensusOptions())
    names = Counter[str]()
    try:
        for item in maps:
            if isinstance(item, CensusMap):
                _judge(census, replace(item, name=once(item.name, names)), each)
            else:
                census.refused.append(item)
            if progress is not None:
                progress()
    except KeyboardInterrupt:
        census.interrupted = True
    except WorldgenError as error:
        census.fault = str(error)
    return census


def once(name: str, taken: Counter[str]) -> str:
    """Make the name unique with a number after it if necessary, and mark it as used."""
    # A file's name may contain bytes that are not valid UTF-8.
    name = name.encode(errors="backslashreplace").decode()
    free = name
    while taken[free]:
        taken[name] += 1
        free = f"{name}-{taken[name]}"
    taken[free] += 1
    return free


def _judge(
    census: Census, item: CensusMap, each: Callable[[CensusCase, World], object] | None
) -> None:
    """Answer every question about one map, or none if the map has a fault."""
    options = census.options
    try:
        ends = item.ends or _drawn(item, options)
        worlds = [World(item.walls, pair.start, pair.target, item.cell_size) for pair in ends]
    except (InvalidWorld, WorldgenError) as error:
        census.refused.append(Refused(item.name, str(error)))
        return
    # Label the regions in which a grid path moves freely, with four and with eight moves.
    four: Any = ndimage.label(~item.walls)[0]
    eight: Any = ndimage.label(~item.walls, structure=np.ones((3, 3)))[0]

    found = []
    for number, (pair, world) in enumerate(zip(ends, worlds, strict=True)):
        joined = (_joined(four, item, pair), _joined(eight, item, pair))
        for radius in options.radii:
            question, judged = _answer(item, number, pair, world, radius, joined)
            found.append(question)
            if each is not None:
                each(question, _with_source(judged, item, question, options.seed))
    census.questions += found
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
    item: CensusMap,
    number: int,
    pair: Ends,
    world: World,
    radius: Radius,
    joined: tuple[bool, bool],
) -> tuple[CensusCase, World]:
    """Return one question with its answers, and the world with its certificate."""
    metres = radius.metres(item.cell_size)
    world = replace(world, robot_radius=metres)
    began = time.perf_counter()
    decision = decide(world)
    world = replace(world, certificate=decision.certificate)
    proved = decision.certificate is not None and check_certificate(world).valid
    seconds = time.perf_counter() - began
    cut = decision.certificate
    # A cut of one cell only occurs where the cell is too near to the start or blocks every target
    # pose.
    room = not (isinstance(cut, Cut) and len(cut.cells) == 1)
    question = CensusCase(
        item.name, number, pair.named, radius, metres, world.width, world.height, item.cell_size,
        decision.result, proved, room, *joined, seconds,
    )  # fmt: skip
    return question, world


def _with_source(world: World, item: CensusMap, question: CensusCase, seed: int) -> World:
    params: dict[str, Value] = {
        **item.params,
        "map": item.name,
        "pair": question.pair,
        "named": question.named,
    }
    return replace(world, provenance=Provenance("census", VERSION, seed, params))
