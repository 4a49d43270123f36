"""Is there a clear pose in the target's disc that a cut leaves on the start's side?"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from worldgen.lattice import UNIT, in_cells
from worldgen.reach.walls import Cell, ExactPoint, Point, Walls, point_box_sq, segment_meets_box
from worldgen.world import World

__all__ = ["COVER_MARGIN", "Disc", "Search", "chain_lines", "look_for_open_pose", "target_disc"]

COVER_MARGIN = Fraction(1, 512)  # "covered" means by this share of the radius; leaves the checker's float test room
_FINEST = 256  # a square is not divided below 1/256 of the disc's width
_WORK = 20_000  # squares looked at before the answer is "unknown"


class Disc(NamedTuple):
    """Centre and radius, 1/1024 cell, exact."""

    x: Fraction
    y: Fraction
    radius: Fraction

    def holds(self, p: ExactPoint) -> bool:
        """Whether a point lies in the closed disc."""
        return (p[0] - self.x) ** 2 + (p[1] - self.y) ** 2 <= self.radius**2

    def meets(self, x: int, y: int, side: int) -> bool:
        """Whether the closed disc touches the closed square [x, x + side] x [y, y + side]."""
        dx = max(x - self.x, Fraction(0), self.x - x - side)
        dy = max(y - self.y, Fraction(0), self.y - y - side)
        return dx * dx + dy * dy <= self.radius**2


class Search(NamedTuple):
    """What was found: ``shut`` is a proof that there is no such pose, ``pose`` is one; neither if unknown.

    ``covered`` says that the proof needs cells to cover poses on the near side, so it holds for radii down to
    ``1 - COVER_MARGIN`` of the robot's; without it the chain's gaps alone say which discs are stopped.
    """

    shut: bool
    pose: Point | None
    covered: bool = False


def target_disc(world: World) -> Disc:
    """The target as the world's decimals say it."""
    target = world.target
    return Disc(*(in_cells(value, world.cell_size) * UNIT for value in (target.x, target.y, target.radius)))


def chain_lines(chain: Sequence[Cell]) -> list[tuple[Point, Point]]:
    """The closed line of a chain: each cell's centre, closest point, closest point, next centre."""
    half, corners = UNIT // 2, []
    for (ax, ay), (bx, by) in zip(chain, [*chain[1:], *chain[:1]], strict=True):
        sx, sy = (bx > ax) - (bx < ax), (by > ay) - (by < ay)
        centre = (UNIT * ax + half, UNIT * ay + half)
        corners += [
            centre,
            (centre[0] + half * sx, centre[1] + half * sy),
            (UNIT * bx + half - half * sx, UNIT * by + half - half * sy),
        ]
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _inside(lines: Sequence[tuple[Point, Point]], p: ExactPoint) -> bool:
    odd = False
    for (ax, ay), (bx, by) in lines:
        if (ax <= p[0]) != (bx <= p[0]):
            rise = (ay - p[1]) * (bx - ax) + (by - ay) * (p[0] - ax)
            odd ^= (rise > 0) == (bx > ax) and rise != 0
    return odd


def look_for_open_pose(walls: Walls, disc: Disc, chain: Sequence[Cell], start: Point) -> Search:
    """Divides the disc into squares until each is covered by a cell's neighbourhood or lies beyond the chain.

    Args:
        walls: The walls with the robot's radius.
        disc: The target's disc.
        chain: A cut; empty for "on neither side".
        start: The start; it defines the near side.
    """
    lines = chain_lines(chain) if chain else []
    home = _inside(lines, start)
    width, height = walls.width * UNIT, walls.height * UNIT
    whole = 1 << min(2 * int(disc.radius) + 4, max(width, height)).bit_length()
    # Squares on multiples of their side: then corners and middles fall on halves of cells, where a passage
    # exactly as wide as the robot has its only clear poses.
    x0, y0 = (max(0, int(value - disc.radius)) // whole * whole for value in (disc.x, disc.y))
    close = [line for line in lines if segment_meets_box(*line, x0, y0, 2 * whole)]
    todo = [(x0 + i * whole, y0 + j * whole, whole) for i in (0, 1) for j in (0, 1)]
    shut, covered, work = True, False, _WORK
    while todo and work:
        x, y, side = todo.pop()
        work -= 1
        if not disc.meets(x, y, side) or x > width or y > height:
            continue
        beyond = chain and _inside(lines, (x, y)) != home
        if beyond and not any(segment_meets_box(*line, x, y, side) for line in close):
            continue
        if _covered(walls, x, y, side):
            covered = True
            continue
        for pose in ((x, y), (x + side // 2, y + side // 2)):
            if disc.holds(pose) and _inside(lines, pose) == home and walls.is_clear(pose, pose):
                return Search(False, pose)
        if side <= max(1, whole // _FINEST):
            shut = False
            continue
        half = side // 2
        todo += [(x, y, half), (x + half, y, half), (x, y + half, half), (x + half, y + half, half)]
    return Search(shut and not todo, None, covered)


def _covered(walls: Walls, x: int, y: int, side: int) -> bool:
    """Whether one cell's neighbourhood, a margin narrower than the radius, holds the whole square."""
    reach = walls.radius * UNIT
    if side > 2 * reach + UNIT:
        return False
    limit = (reach * (1 - COVER_MARGIN)) ** 2
    middle = (x + side // 2, y + side // 2)
    corners = ((x, y), (x + side, y), (x, y + side), (x + side, y + side))
    return any(
        all(point_box_sq(corner, cell) < limit for corner in corners)
        for cell in walls.near(middle, middle, int(reach) + side)
    )
