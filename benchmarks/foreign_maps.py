"""Maps of other projects for the census: from files and folders, and from generators.

A generator is a function ``maps(seed, **options)`` of a file in ``benchmarks/generators``. For each
map it yields a name, the walls and, if the project has them, the cells of start and target.
``walls`` is a 2D array, True where solid; row 0 is the top row, and a cell is (row, column) in it.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.interop import read_map
from worldgen.interop.format.foreign_map import ForeignMap, without_file
from worldgen.interop.formats.movingai import read_scenario, scenario_contents
from worldgen.interop.formats.text import cell_centre
from worldgen.interop.recognising import looks_like_a_map
from worldgen.lattice import UNIT, in_cells, lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Pose, Target


@dataclass(frozen=True)
class Ends:
    """A start and a target; ``named`` is False if they were drawn."""

    start: Pose
    target: Target
    named: bool = True


@dataclass(frozen=True, eq=False)
class CensusMap:
    """A map to judge.

    Args:
        name: Part of the seed of drawn ends; a census adds a number to a repeated name.
        walls: (height, width) bool, True is solid; row 0 is the lowest y.
        cell_size: Side of a cell, m.
        ends: Starts and targets that the map names; if it names none, they are drawn.
    """

    name: str
    walls: Bools
    cell_size: float = DEFAULT_CELL_SIZE
    ends: tuple[Ends, ...] = ()


@dataclass(frozen=True)
class Refused:
    """A map that could not be judged: its name, and a sentence that gives the reason."""

    name: str
    reason: str


def cell_ends(
    start: tuple[int, int], target: tuple[int, int], cell_size: float, *, named: bool = True
) -> Ends:
    """Return ends from the centre of one cell to the disc inscribed in another.

    Cells are (column, row); row 0 is the lowest.
    """
    half = lattice_to_metres(UNIT // 2, cell_size)
    at = cell_centre(*start, cell_size)
    return Ends(Pose(*at), Target(*cell_centre(*target, cell_size), half), named)


def cell_at(walls: Bools, cell_size: float, x: float, y: float) -> tuple[int, int]:
    """Return the row and column of the cell that holds a point, m.

    A point on the map's far sides belongs to the last cell.
    """
    column, row = (math.floor(in_cells(value, cell_size)) for value in (x, y))
    height, width = walls.shape
    return min(row, height - 1), min(column, width - 1)


def draw_ends(
    case: CensusMap, pairs: int, rng: RandomStream, clear_for: Fraction | None
) -> tuple[Ends, ...]:
    """Draw pairs of different free cells, all equally likely.

    Args:
        case: The map.
        pairs: Number of pairs to draw.
        rng: The only source of randomness.
        clear_for: Radius, cells, of a disc that must be clear at the centres of both cells, if any.

    Raises:
        InvalidParameter: If there are no two such cells.
    """
    # Ends are free cells, with room for the disc if requested.
    free = ~case.walls
    if clear_for is not None:
        free &= _clear_centres(case.walls, clear_for)
    places = np.flatnonzero(free)
    if len(places) < 2:
        raise InvalidParameter("no-room", "the map does not have two free cells with enough room")
    # Draw two different cells for each pair, without bias.
    drawn = []
    for _ in range(pairs):
        first = rng.below(len(places))
        second = rng.below(len(places) - 1)
        second += second >= first
        (row, column), (to_row, to_column) = (
            divmod(int(places[index]), free.shape[1]) for index in (first, second)
        )
        drawn.append(cell_ends((column, row), (to_column, to_row), case.cell_size, named=False))
    return tuple(drawn)


def _clear_centres(walls: Bools, radius: Fraction) -> Bools:
    # The disc is wider than the map, so no centre is clear.
    if 2 * radius > max(walls.shape):
        return np.zeros_like(walls)
    return build_graph(walls, radius, 2).clear[1::2, 1::2]


def folder_maps(
    paths: Sequence[Path], *, pairs: int = 1, seed: int = 0
) -> Iterator[CensusMap | Refused]:
    """Yield the maps in folders and their subfolders, in alphabetical order.

    Args:
        paths: Folders with maps, and perhaps with MovingAI scenario files for them.
        pairs: Number of problems to take from a map's scenario files, if it has any.
        seed: Seed of the draw.
    """
    files = [
        (file.relative_to(path).as_posix(), file)
        for path in paths
        for file in sorted(path.rglob("*"))
        if file.is_file()
    ]
    # Scenarios find their maps by name.
    scenarios: dict[str, list[tuple[Path, int]]] = {}
    for name, file in files:
        if file.suffix.lower() == ".scen":
            try:
                map_name, count = scenario_contents(file)
                scenarios.setdefault(map_name, []).append((file, count))
            except FormatError as error:
                yield Refused(name, without_file(error))
    for name, file in files:
        if file.suffix.lower() == ".scen" or not looks_like_a_map(file):
            continue
        try:
            found = read_map(file)
            if found.unread:
                raise InvalidParameter("unread", "has obstacles that are not read")
            ends = _own_ends(found)
        except WorldgenError as error:
            yield Refused(name, without_file(error))
            continue
        if not ends:
            try:
                rng = RandomStream(seed).child("census", name, "scenarios")
                ends = _scenario_ends(scenarios.get(file.name, []), found, pairs, rng)
            # The map itself can still be judged.
            except WorldgenError as error:
                yield Refused(f"{name} (its scenarios)", without_file(error))
        yield CensusMap(name, found.walls, found.cell_size, ends)


def _own_ends(found: ForeignMap) -> tuple[Ends, ...]:
    """Return the start and the target, if the format stores both."""
    if found.world is not None:
        if found.world.is_dynamic:
            raise InvalidParameter("world-changes", "the world changes with time")
        return (Ends(found.world.start, found.world.target),)
    start, target = found.robot.start, found.robot.target
    if start is None or target is None:
        return ()
    half = lattice_to_metres(UNIT // 2, found.cell_size)
    x, y, radius = (*target, half)[:3]
    return (Ends(Pose(*start), Target(x, y, radius)),)


def _scenario_ends(
    files: Sequence[tuple[Path, int]], found: ForeignMap, pairs: int, rng: RandomStream
) -> tuple[Ends, ...]:
    """Return problems of the map's scenario files, drawn without repetition, in file order."""
    problems = [(file, row + 1) for file, count in files for row in range(count)]
    left = list(range(len(problems)))
    rng.shuffle(left)
    height, width = found.walls.shape
    half = lattice_to_metres(UNIT // 2, found.cell_size)
    ends = []
    for number in sorted(left[:pairs]):
        problem = read_scenario(*problems[number], width, height, found.cell_size)
        ends.append(Ends(Pose(*problem.start), Target(*problem.goal, half)))
    return tuple(ends)


def generated_maps(adapter: str, *, count: int, seed: int, **options: Any) -> Iterator[CensusMap]:
    """Yield the first maps of a generator: a module of ``benchmarks.generators``.

    Raises:
        ImportError: If the project that it wraps is not installed.
    """
    generator = importlib.import_module(f"benchmarks.generators.{adapter}").maps
    for name, given, *cells in islice(generator(seed=seed, **options), count):
        walls = np.asarray(given, np.bool_)
        # From (row, column), row 0 the top, to column and row from below.
        below = [(int(column), walls.shape[0] - 1 - int(row)) for row, column in cells]
        ends = (cell_ends(below[0], below[1], DEFAULT_CELL_SIZE),) if below else ()
        yield CensusMap(name, flip_rows(walls), ends=ends)
