"""Check swept moves against a foreign referee: shapely tests every piece of the path of many robots.

``python -m benchmarks.referee`` reports how many moves were tried and how many cut a wall, first for
discs, then for convex bodies, which also turn; ``--json`` prints one object, and ``--moves`` sets
their number (default 100,000). Rooms are random, from sparse to dense, some with walls one cell
thick and diagonal gaps; radii range from 0.05 to 6 cells, moves from a lattice unit to 300 cells.

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

from tests.helpers.core_parts import (
    MOST_CORNERS,
    body_is_clear,
    clear_turn,
    footprint_of,
    pose_is_clear,
    swept_body_move,
    swept_move,
)
from worldgen.lattice import TURN, UNIT, clear_distance_sq
from worldgen.random_streams import RandomStream
from worldgen.timeline import CellState

# The words of a round that takes seconds; the gate runs it.
TINY = ("--moves", "100")

SOLID = int(CellState.SOLID)
# Lattice units.
TOLERANCE = 1e-6
# Lattice units by which a body may seem to cut a wall: the table of headings puts its corners up to
# R * 2^-30 away from where shapely does, and shapely rounds, too.
BODY_TOLERANCE = 1e-3
# Between two headings of the table no corner moves more than this share of its distance.
TURN_TOLERANCE = 2.0 * math.pi / 65_536
# Poses on each turn that shapely looks at.
LOOKS_A_TURN = 12
MOST_TURN = 32_767
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


def referee_bodies(moves: int, seed: int) -> Report:
    """Try random moves and turns of convex bodies, and return the findings.

    Args:
        moves: Minimum number of moves; as many turns follow them.
        seed: Seed of all randomness.
    """
    stream = RandomStream(seed)
    report = Report()
    begin = time.perf_counter()
    chain = np.zeros((MOST_CORNERS, 3), np.int64)
    while report.moves < moves:
        cells = _room(stream)
        corners = random_body(stream)
        footprint = footprint_of(corners)
        for _ in range(40):
            pose = (
                stream.below(cells.shape[1] * UNIT),
                stream.below(cells.shape[0] * UNIT),
                stream.below(TURN),
            )
            if body_is_clear(cells, footprint, *pose):
                _drive_body(stream, cells, corners, pose, chain, report)
                break
    report.seconds = time.perf_counter() - begin
    return report


def random_body(stream: RandomStream) -> list[tuple[int, int]]:
    """Return the corners of a rectangle, or of the hull of random points, lattice units."""
    size = (200, 700, 1500, 4000)[stream.below(4)]
    while True:
        if stream.below(2) == 0:
            length, width = stream.between(size // 8, size), stream.between(size // 8, size)
            ahead = stream.between(-length, length)
            return [
                (ahead - length, -width),
                (ahead + length, -width),
                (ahead + length, width),
                (ahead - length, width),
            ]
        points = [
            (stream.between(-size, size), stream.between(-size, size))
            for _ in range(stream.between(3, 12))
        ]
        hull = shapely.MultiPoint(points).convex_hull
        if hull.area > 1.0:
            ring = shapely.remove_repeated_points(hull.exterior.normalize())
            found = shapely.Polygon(ring).normalize().exterior
            ordered = list(found.coords)[:-1]
            if not found.is_ccw:
                ordered.reverse()
            return [(int(x), int(y)) for x, y in ordered]


def _placed(corners: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return (n, k, 2) the corners of a body at (n, 3) poses, with shapely's own sines."""
    angles = poses[:, 2] * (2.0 * math.pi / TURN)
    cos, sin = np.cos(angles)[:, np.newaxis], np.sin(angles)[:, np.newaxis]
    x, y = corners[:, 0], corners[:, 1]
    turned = np.stack([x * cos - y * sin, x * sin + y * cos], axis=-1)
    return turned + poses[:, np.newaxis, :2]


def _drive_body(
    stream: RandomStream,
    cells: np.ndarray,
    corners: list[tuple[int, int]],
    pose: tuple[int, int, int],
    chain: np.ndarray,
    report: Report,
) -> None:
    """Check some moves and turns from a pose, all together."""
    footprint = footprint_of(corners)
    x, y, heading = pose
    pieces: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    looks: list[tuple[float, float, float]] = []
    for _ in range(MOVES_A_ROOM):
        length = LENGTHS[stream.below(len(LENGTHS))]
        angle = stream.below(720) * math.pi / 360
        ends = (x, y, round(length * math.cos(angle)), round(length * math.sin(angle)))
        count, nx, ny = swept_body_move(cells, footprint, heading, ends, chain)
        for k in range(count):
            before = (x, y, heading)
            x, y = int(chain[k, 0]), int(chain[k, 1])
            pieces.append((before, (x, y, heading)))
        # Turn, and look at poses on the way, between headings of the table too.
        wanted = stream.between(-MOST_TURN, MOST_TURN) >> stream.below(12)
        turned = clear_turn(cells, footprint, (x, y, heading), wanted)
        looks += [(x, y, heading + turned * stream.random()) for _ in range(LOOKS_A_TURN)]
        heading = (heading + turned) % TURN
        report.moves += 1
        report.contacts += (nx, ny) != (0.0, 0.0) or turned != wanted
    # Let shapely find pieces and poses whose shrunken bodies still meet a wall.
    tree = _walls(cells)
    own = np.array(corners, float)
    if pieces:
        ends_of_pieces = np.array(pieces, float)
        points = np.concatenate([_placed(own, ends_of_pieces[:, k]) for k in (0, 1)], axis=1)
        hulls = shapely.convex_hull(shapely.multipoints(points))
        report.cuts += _cuts(tree, hulls, BODY_TOLERANCE)
        report.pieces += len(pieces)
    reach = float(np.hypot(own[:, 0], own[:, 1]).max())
    bodies = shapely.polygons(_placed(own, np.array(looks)))
    report.cuts += _cuts(tree, bodies, reach * TURN_TOLERANCE + BODY_TOLERANCE)
    report.pieces += len(looks)


def _cuts(tree: shapely.STRtree, shapes: np.ndarray, tolerance: float) -> int:
    """Return how many shapes go deeper into a wall than a tolerance, at a side or a corner."""
    shrunk = shapely.buffer(shapes, -tolerance, join_style="mitre")
    return len(np.unique(tree.query(shrunk, "intersects")[0]))


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
    bodies = referee_bodies(arguments.moves, arguments.seed)
    if arguments.json:
        of_bodies = {name: value for name, value in vars(bodies).items() if name != "deepest"}
        click.echo(json.dumps({**vars(report), "bodies": of_bodies}))
        return
    click.echo(
        f"{report.moves:,} moves of discs, {report.contacts:,} of them bent or stopped, "
        f"{report.pieces:,} straight pieces: "
        f"{report.cuts} cut a wall; the worst came {report.deepest:.2e} lattice units too near "
        f"({report.seconds:.0f} s)"
    )
    click.echo(
        f"{bodies.moves:,} moves and turns of bodies, {bodies.contacts:,} of them bent or stopped, "
        f"{bodies.pieces:,} pieces and poses: {bodies.cuts} cut a wall ({bodies.seconds:.0f} s)"
    )


if __name__ == "__main__":
    main()
