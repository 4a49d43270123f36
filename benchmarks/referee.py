"""Check swept moves against a foreign referee: shapely tests every piece of the path of many discs.

``python -m benchmarks.referee`` reports how many moves were tried and how many cut a wall;
``--json`` prints one object, and ``--moves`` sets their number (default 100,000). Rooms are random,
from sparse to dense, some with walls one cell thick and diagonal gaps; radii range from 0.05 to 6
cells, moves from a lattice unit to 300 cells.

Coordinates are lattice units, whole numbers below 2**20, so that shapely's own rounding stays below
a millionth of a unit. That is the tolerance: a nanometre if a cell is a metre.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from dataclasses import dataclass, field
from fractions import Fraction

import click
import numpy as np
import shapely

from tests.helpers.core_parts import MOST_CORNERS, pose_is_clear, swept_move
from worldgen.lattice import UNIT, clear_distance_sq
from worldgen.random_streams import RandomStream
from worldgen.timeline import CellState

# The words of a round that takes seconds; the gate runs it.
TINY = ("--moves", "100")

SOLID = int(CellState.SOLID)
# Lattice units.
TOLERANCE = 1e-6
MOVES_A_ROOM = 200
# Cells.
RADII = tuple(Fraction(k, 20) for k in (1, 5, 9, 10, 13, 14, 15, 20, 27, 40, 70, 120))
# Lattice units.
LENGTHS = (1, 30, 300, 700, 1024, 3000, 20_000, 300 * UNIT)


@dataclass
class Report:
    """The referee's findings.

    Args:
        moves: Moves tried.
        pieces: Straight pieces of their paths.
        contacts: Moves that a wall stopped or bent.
        cuts: Pieces that came nearer to a wall than the radius, by more than the tolerance.
        deepest: How much nearer the worst piece came, lattice units; below 0 it stayed away.
        seconds: Duration.
    """

    moves: int = 0
    pieces: int = 0
    contacts: int = 0
    cuts: int = 0
    deepest: float = -math.inf
    seconds: float = field(default=0.0)


def _room(stream: RandomStream) -> np.ndarray:
    side = stream.between(8, 24)
    cells = np.zeros((side, side), np.uint8)
    for _ in range(stream.between(1, side * side // 6)):
        ix = stream.below(side)
        iy = stream.below(side)
        width, height = (
            (1, stream.between(1, side)) if stream.below(3) == 0 else (stream.between(1, 3),) * 2
        )
        cells[iy : iy + height, ix : ix + width] = SOLID
    return cells


def _walls(cells: np.ndarray) -> shapely.STRtree:
    padded = np.pad(cells, 1, constant_values=SOLID)
    low = (np.argwhere(padded)[:, ::-1] - 1) * UNIT
    return shapely.STRtree(shapely.box(low[:, 0], low[:, 1], low[:, 0] + UNIT, low[:, 1] + UNIT))


def _place(
    stream: RandomStream, cells: np.ndarray, clear_sq: int, reach: int
) -> tuple[int, int] | None:
    for _ in range(40):
        x = stream.below(cells.shape[1] * UNIT)
        y = stream.below(cells.shape[0] * UNIT)
        if pose_is_clear(cells, SOLID, clear_sq, reach, x, y):
            return x, y
    return None


def referee(moves: int, seed: int) -> Report:
    """Try random moves and return the findings.

    Args:
        moves: Minimum number of moves.
        seed: Seed of all randomness.
    """
    stream = RandomStream(seed)
    report = Report()
    begin = time.perf_counter()
    chain = np.zeros((MOST_CORNERS, 3), np.int64)
    while report.moves < moves:
        cells = _room(stream)
        radius = RADII[stream.below(len(RADII))]
        # Square distances are whole numbers, so the referee's comparisons are exact.
        clear_sq = clear_distance_sq(radius)
        reach = math.isqrt(clear_sq - 1) + 1
        place = _place(stream, cells, clear_sq, reach)
        # Some rooms have no clear place for a start.
        if place is not None:
            _drive(stream, cells, clear_sq, reach, place, chain, report)
    report.seconds = time.perf_counter() - begin
    return report


def _drive(
    stream: RandomStream,
    cells: np.ndarray,
    clear_sq: int,
    reach: int,
    place: tuple[int, int],
    chain: np.ndarray,
    report: Report,
) -> None:
    """Check some moves from a place, all together."""
    # Make random moves, and keep every straight piece of their paths.
    pieces: list[list[tuple[int, int]]] = []
    x, y = place
    for _ in range(MOVES_A_ROOM):
        length = LENGTHS[stream.below(len(LENGTHS))]
        angle = stream.below(720) * math.pi / 360
        dx = round(length * math.cos(angle))
        dy = round(length * math.sin(angle))
        count, nx, ny = swept_move(
            cells, clear_sq, reach, (x, y, dx, dy), (0.0, 1.0), 0.0, chain, 0
        )
        for k in range(count):
            to = int(chain[k, 0]), int(chain[k, 1])
            pieces.append([(x, y), to])
            x, y = to
        report.moves += 1
        report.contacts += (nx, ny) != (0.0, 0.0)
    # Let shapely measure how near the pieces come to walls.
    if not pieces:
        return
    lines = shapely.linestrings(np.array(pieces, float))
    tree = _walls(cells)
    radius = math.sqrt(clear_sq)
    which, boxes = tree.query(lines, "dwithin", radius + 1.0)
    gaps = shapely.distance(lines[which], tree.geometries[boxes])
    report.pieces += len(pieces)
    if len(gaps):
        report.cuts += len(np.unique(which[gaps < radius - TOLERANCE]))
        report.deepest = max(report.deepest, float(radius - gaps.min()))


def main() -> None:
    """Run the referee and print the report."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--moves", type=int, default=100_000, help="how many (default 100,000)")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    report = referee(arguments.moves, arguments.seed)
    if arguments.json:
        click.echo(json.dumps(vars(report)))
        return
    click.echo(
        f"{report.moves:,} moves, {report.contacts:,} of them bent or stopped, {report.pieces:,} "
        f"straight pieces: "
        f"{report.cuts} cut a wall; the worst came {report.deepest:.2e} lattice units too near "
        f"({report.seconds:.0f} s)"
    )


if __name__ == "__main__":
    main()
