"""Find how much later a witness may begin.

Like every checker, it uses none of the code that made the witness.
"""

from __future__ import annotations

import numpy as np
import shapely

from worldgen.reach.check.certificate import TOLERANCE, WitnessPoints, blocked_spans, path_of
from worldgen.support.arrays import Floats, Indices, Ints
from worldgen.world import Witness, World


def witness_margin(world: World, witness: Witness, *, radius: float | None = None) -> float:
    """Return the delay, s, up to which every delayed copy of a valid witness is valid.

    The delay may be infinite. The robot waits at the start for that time, and must be safe there.
    If the disc is too near to a cell from time u to time v, and the cell is blocked from b to e,
    they collide at delays between b - v and e - u.

    Args:
        world: The world.
        witness: A witness that :func:`check_certificate` accepts for this radius.
        radius: Radius of the disc, m; the robot's if omitted.
    """
    radius = world.robot_radius if radius is None else radius
    path = path_of(world, witness)
    spans = blocked_spans(world)
    # Half, so that the result is within the checker's own tolerance.
    reach = radius / world.cell_size - TOLERANCE / 2
    boxes = shapely.box(spans.ix, spans.iy, spans.ix + 1, spans.iy + 1)
    cell, piece = shapely.STRtree(path.shapes()).query(boxes, predicate="dwithin", distance=reach)
    first, last = _near(path, piece, spans.ix[cell], spans.iy[cell], reach)
    met = first < last
    begin = path.times[piece]
    length = np.diff(path.times)[piece]
    since = begin + first * length
    until = begin + last * length
    # Earlier spans end before the disc comes near.
    ahead = met & (spans.end[cell] > (since + until) / 2)
    left = spans.begin[cell][ahead] - until[ahead]
    return float(max(left.min(initial=np.inf), 0.0))


def _near(
    path: WitnessPoints, piece: Indices, ix: Ints, iy: Ints, reach: float
) -> tuple[Floats, Floats]:
    """Return the interval of shares of each piece that is nearer than ``reach`` to a cell.

    The interval is 1 to 0 if there is none. The points within that distance of a square are in two
    rectangles and in four discs around its corners. They form a convex set, so the shares are an
    interval.
    """
    x = path.x[piece]
    y = path.y[piece]
    dx = np.diff(path.x)[piece]
    dy = np.diff(path.y)[piece]
    first = np.ones(len(piece))
    last = np.zeros(len(piece))
    parts = [
        _in_box(x - ix, y - iy, dx, dy, wide, high) for wide, high in ((reach, 0.0), (0.0, reach))
    ]
    parts += [
        _in_disc(x - ix - right, y - iy - up, dx, dy, reach) for right in (0, 1) for up in (0, 1)
    ]
    for low, high in parts:
        some = low < high
        first = np.where(some, np.minimum(first, low), first)
        last = np.where(some, np.maximum(last, high), last)
    return first, last


def _in_box(
    x: Floats, y: Floats, dx: Floats, dy: Floats, wide: float, high: float
) -> tuple[Floats, Floats]:
    """Return the shares at which a piece enters and leaves the widened unit square."""
    first = np.zeros(len(x))
    last = np.ones(len(x))
    with np.errstate(all="ignore"):
        for at, step, more in ((x, dx, wide), (y, dy, high)):
            ends = np.stack([(-more - at) / step, (1.0 + more - at) / step])
            inside = (at > -more) & (at < 1.0 + more)
            stands = np.abs(step) < 1e-12
            low = np.where(stands, np.where(inside, 0.0, 1.0), ends.min(axis=0))
            high_ = np.where(stands, np.where(inside, 1.0, 0.0), ends.max(axis=0))
            first = np.maximum(first, low)
            last = np.minimum(last, high_)
    return first, last


def _in_disc(x: Floats, y: Floats, dx: Floats, dy: Floats, reach: float) -> tuple[Floats, Floats]:
    """Return the shares between which a piece is nearer than ``reach`` to the origin."""
    length_sq = dx * dx + dy * dy
    half = x * dx + y * dy
    apart = x * x + y * y - reach * reach
    stands = length_sq < 1e-24
    with np.errstate(all="ignore"):
        # nan if the line misses it.
        root = np.sqrt(half * half - length_sq * apart)
        low = np.maximum((-half - root) / length_sq, 0.0)
        high = np.minimum((-half + root) / length_sq, 1.0)
    low = np.where(np.isnan(low), 1.0, low)
    high = np.where(np.isnan(high), 0.0, high)
    return np.where(stands, np.where(apart < 0, 0.0, 1.0), low), np.where(
        stands, np.where(apart < 0, 1.0, 0.0), high
    )
