"""Paths and walls in fractions: the specification of ``segments.c``."""

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

from worldgen.lattice import UNIT
from worldgen.reach.still.path import merge_straight
from worldgen.reach.still.walls import ExactPoint, Walls, segment_box_sq

_PATIENCE = 6
_TESTS = 6_000


def shorten(walls: Walls, points: list[ExactPoint]) -> list[ExactPoint]:
    """Replace corners by straight lines along which the disc is clear."""
    points = merge_straight(points)
    patience = max(1, min(_PATIENCE, _TESTS // len(points)))
    kept = [points[0]]
    at = 0
    while at < len(points) - 1:
        seen = at + 1
        far = at + 2
        while far < len(points) and far <= seen + patience:
            if walls.is_clear(points[at], points[far]):
                seen = far
            far += 1
        kept.append(points[seen])
        at = seen
    return merge_straight(kept)


def clearance_sq(walls: Walls, points: Sequence[ExactPoint]) -> Fraction:
    """Return the squared distance from a path to the nearest solid cell, lu squared, exactly."""
    pieces = list(itertools.pairwise(points)) or [(points[0], points[0])]
    reach = 2 * math.ceil(walls.radius * UNIT)
    while True:
        best = Fraction(reach * reach)
        for p, q in pieces:
            for cell in walls.near(p, q, math.isqrt(math.ceil(best)) + 1):
                distance, over = segment_box_sq(p, q, cell)
                best = min(best, Fraction(distance) / over)
        if best < reach * reach:
            return best
        reach *= 2
