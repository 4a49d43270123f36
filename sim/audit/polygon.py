"""Measure convex bodies against boxes: how far apart they are, and how deep a box is in a body.

Lengths are in cells. Everything is in arrays with one row for each pair of body and box, and shares
nothing with the simulator or with the prover.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from worldgen.lattice import UNIT, footprint_on_lattice
from worldgen.support.arrays import Floats, Indices
from worldgen.world import Robot

# Relative size of rounding errors, far above those of float64.
_NEARLY = 1e-12


@dataclass(frozen=True)
class Body:
    """A convex polygon in the robot's frame: x ahead, y to the left, the origin at its axle.

    A point p is inside if ``offsets - normals @ p`` is positive for all sides; each of these is the
    distance to a side.

    Args:
        corners: (k, 2) Corners, counter-clockwise.
        normals: (k, 2) Outward normals of the sides, of length 1.
        offsets: (k,) Distance of each side from the origin along its normal.
        reach: Distance of the farthest corner from the origin.
        middle: (2,) A point inside that is as far from all sides as any.
        inner: Distance of that point from the nearest side.
    """

    corners: Floats
    normals: Floats
    offsets: Floats
    reach: float
    middle: Floats
    inner: float

    @classmethod
    def of(cls, robot: Robot, cell_size: float) -> Body:
        """Return the body of a robot with a footprint: its corners are on the pose lattice."""
        corners = footprint_on_lattice(robot.footprint, cell_size).astype(np.float64) / UNIT
        along = np.roll(corners, -1, axis=0) - corners
        normals = np.column_stack((along[:, 1], -along[:, 0])) / np.hypot(*along.T)[:, None]
        offsets = np.einsum("ij,ij->i", normals, corners)
        reach = float(np.hypot(*corners.T).max())
        return cls(corners, normals, offsets, reach, *_deepest_point(normals, offsets))

    @property
    def holds_axle(self) -> bool:
        """True if the origin is inside or on a side."""
        return bool((self.offsets >= 0.0).all())

    def depths(self, points: Floats) -> Floats:
        """Return each point's distance to each side, negative outside: (..., k) of (..., 2)."""
        depths: Floats = self.offsets - points @ self.normals.T
        return depths


def _deepest_point(normals: Floats, offsets: Floats) -> tuple[Floats, float]:
    """Return the centre and the radius of a largest disc in a convex polygon."""
    # It touches three sides, so it is the largest of the discs through three that stays inside.
    triples = np.array(list(itertools.combinations(range(len(offsets)), 3)))
    matrix = np.concatenate((normals[triples], np.ones((len(triples), 3, 1))), axis=2)
    solvable = np.abs(np.linalg.det(matrix)) > _NEARLY
    found = np.linalg.solve(matrix[solvable], offsets[triples[solvable]][..., None])[..., 0]
    slack = offsets - found[:, :2] @ normals.T - found[:, 2:]
    radius = np.where(slack.min(axis=1) > -1e-9, found[:, 2], -np.inf)
    best = int(radius.argmax())
    return found[best, :2], float(radius[best])


def turned(points: Floats, heading: Floats) -> Floats:
    """Return points (..., 2) rotated by headings (...), rad."""
    cos = np.cos(heading)
    sin = np.sin(heading)
    x = points[..., 0]
    y = points[..., 1]
    return np.stack((x * cos - y * sin, x * sin + y * cos), axis=-1)


def box_corners(boxes: Floats) -> Floats:
    """Return the corners (n, 4, 2), in order around, of boxes (n, 4): left, low, right, high."""
    return boxes[:, [[0, 1], [2, 1], [2, 3], [0, 3]]]


def separations(body: Body, corners: Floats, place: Floats, heading: Floats) -> Floats:
    """Return the gap between bodies and boxes along the axis that shows most of it.

    It is at most their distance, and negative if and only if they overlap.

    Args:
        body: The body.
        corners: (n, 4, 2) Corners of the boxes.
        place: (n, 2) Places of the robot's origin.
        heading: (n,) rad.
    """
    seen = corners - place[:, None]
    gap = -body.depths(turned(seen, -heading[:, None])).max(axis=1).min(axis=1)
    outline = turned(body.corners, heading[:, None])
    for axis in (0, 1):
        low = outline[..., axis].min(axis=1)
        high = outline[..., axis].max(axis=1)
        np.maximum(gap, seen[..., axis].min(axis=1) - high, out=gap)
        np.maximum(gap, low - seen[..., axis].max(axis=1), out=gap)
    found: Floats = gap
    return found


def deepest_on_segments(body: Body, begin: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Return the greatest depth in the body on each segment, and the share at which it is reached.

    The depth of a point is its distance to the nearest side, which is concave along a segment: the
    lowest of k lines. Start with the lines that are lowest at the ends; where they cross, either no
    other is lower, or that one replaces one of them.

    Args:
        body: The body.
        begin: (n, m, 2) Points in the robot's frame.
        end: (n, m, 2) Points.
    """
    low = body.depths(begin)
    slope = body.depths(end) - low

    def at(share: Floats) -> tuple[Floats, Indices]:
        heights = low + share[..., None] * slope
        line = heights.argmin(axis=-1)
        return np.take_along_axis(heights, line[..., None], axis=-1)[..., 0], line

    def pick(values: Floats, line: Indices) -> Floats:
        return np.take_along_axis(values, line[..., None], axis=-1)[..., 0]

    share = np.zeros(begin.shape[:-1])
    best, rising = at(share)
    end_height, falling = at(np.ones_like(share))
    # A line that falls from the beginning, or rises to the end, has its greatest value there.
    ends = end_height > best
    share[ends] = 1.0
    best = np.maximum(best, end_height)
    climbs = (pick(slope, rising) > 0.0) & (pick(slope, falling) < 0.0)
    for _ in range(len(body.offsets)):
        if not climbs.any():
            break
        steeper = pick(slope, rising) - pick(slope, falling)
        gap = pick(low, falling) - pick(low, rising)
        crossing = np.where(climbs, gap / np.where(climbs, steeper, 1.0), share)
        height, line = at(np.clip(crossing, 0.0, 1.0))
        better = climbs & (height >= best)
        share = np.where(better, np.clip(crossing, 0.0, 1.0), share)
        best = np.where(better, height, best)
        goes_up = pick(slope, line) > 0.0
        known = (line == rising) | (line == falling)
        rising = np.where(climbs & goes_up, line, rising)
        falling = np.where(climbs & ~goes_up, line, falling)
        climbs &= ~known & (pick(slope, line) != 0.0)
    return best, share


def distances(body: Body, begin: Floats, end: Floats) -> Floats:
    """Return the distance of the body from the nearest of each row's segments; none may enter it.

    Args:
        body: The body.
        begin: (n, m, 2) Points in the robot's frame.
        end: (n, m, 2) Points; equal ones are points.
    """
    side_begin = body.corners
    side_end = np.roll(body.corners, -1, axis=0)
    points = np.concatenate((begin, end), axis=1)
    to_sides = _to_segment(points[:, :, None], side_begin, side_end).min(axis=(1, 2))
    to_corners = _to_segment(side_begin, begin[:, :, None], end[:, :, None]).min(axis=(1, 2))
    found: Floats = np.minimum(to_sides, to_corners)
    return found


def _to_segment(point: Floats, begin: Floats, end: Floats) -> Floats:
    """Return the distance of points from segments, all of shape (..., 2)."""
    along = end - begin
    square = (along * along).sum(axis=-1)
    share = ((point - begin) * along).sum(axis=-1) / np.where(square > 0.0, square, 1.0)
    gap = point - begin - np.clip(share, 0.0, 1.0)[..., None] * along
    found: Floats = np.sqrt((gap * gap).sum(axis=-1))
    return found
