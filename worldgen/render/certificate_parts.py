"""Draw why nothing fits: a chain of walls, or the places where a body fits in no heading."""

from __future__ import annotations

import numpy as np

from worldgen.lattice import TURN, UNIT
from worldgen.render.frame import BAND, Frame
from worldgen.render.marks import Mark
from worldgen.render.primitives import DrawnCircle, DrawnLine, Primitive
from worldgen.support.arrays import Floats, Ints
from worldgen.world import Cut, World

# Places per cell and axis at which a cut of poses is sampled; fewer in a large world.
FINENESS = 4
# Share of the headings that are all: boxes end a step before the next.
_ALL = 0.995
_MOST_PLACES = 2_000_000
_OUTLINE = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))


def cut_chain(proof: Cut, frame: Frame, mark: Mark) -> list[Primitive]:
    """Return a chain of walls through their middles; those outside the grid on the wall around it.

    A single cell has its outline, and a chain that is too small to see has a ring around it.
    """
    points = frame.corners(proof.cells + 0.5 if len(proof.cells) > 1 else proof.cells + _OUTLINE)
    beyond = BAND / 2 * frame.unit
    corner = np.array((frame.left, frame.top))
    ends = corner + np.array((frame.width, frame.height))
    clipped: Floats = np.clip(points, corner - beyond, ends + beyond)
    paints = mark.lines(frame.unit)
    parts: list[Primitive] = [DrawnLine(clipped, paint, closed=True) for paint in paints]
    middle = (clipped.min(axis=0) + clipped.max(axis=0)) / 2
    least = mark.size * frame.unit
    if np.ptp(clipped, axis=0).max() < 2 * least:
        parts += [DrawnCircle(float(middle[0]), float(middle[1]), least, paint) for paint in paints]
    return parts


def blocked_share(world: World, boxes: Ints) -> Floats:
    """Return at which share of headings a cut of poses stops the robot, by place.

    The boxes of a cut overlap at their bounds only, so the shares of their headings add up.

    Args:
        world: The world.
        boxes: (n, 6) as in :class:`worldgen.world.Cut`.

    Returns:
        (fineness * height, fineness * width) float64, 0 to 1, for places in the middle of equal
        parts of the cells; 0 where a wall is, because nothing need be shown there.
    """
    fineness = FINENESS
    while fineness > 1 and world.walls.size * fineness**2 > _MOST_PLACES:
        fineness -= 1
    height, width = (side * fineness for side in world.walls.shape)
    part = UNIT / fineness
    _, span, side, y, begin, end = boxes.T

    def bounds(low: Ints, high: Ints, most: int) -> tuple[Ints, Ints]:
        # The places whose middles are between two bounds.
        first = np.ceil(low / part - 0.5).astype(np.int64)
        after = np.floor(high / part - 0.5).astype(np.int64) + 1
        return np.clip(first, 0, most), np.clip(after, 0, most)

    left, right = bounds(begin, end, width)
    low, high = bounds(y, y + side, height)
    some = (left < right) & (low < high)
    # Corners of each rectangle in a table whose sums along both axes are the headings in all.
    table = np.zeros((height + 1, width + 1))
    for rows, columns, sign in (
        (low, left, 1),
        (low, right, -1),
        (high, left, -1),
        (high, right, 1),
    ):
        np.add.at(table, (rows[some], columns[some]), sign * span[some])
    sums = table.cumsum(axis=0).cumsum(axis=1)[:-1, :-1]
    sums[np.kron(world.walls, np.ones((fineness, fineness), bool))] = 0.0
    # A heading between two boxes may be in neither, by a step.
    shares: Floats = np.where(sums >= _ALL * TURN, 1.0, sums / TURN)
    return shares
