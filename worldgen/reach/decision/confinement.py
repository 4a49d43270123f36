"""Bounds on where a robot can be, and when: the proof that it cannot be at the target in time."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from worldgen.support.arrays import Ints

NEVER_ENDS = 2**60
"""Last slab of a stay that does not end."""


@dataclass(frozen=True, eq=False)
class Confinement:
    """Stays that contain every robot and are never in the target.

    They prove that the target cannot be reached, or not by a deadline. Space is cut into square
    tiles, time into slabs in which no robot gets farther than one tile's side. A stay means that a
    robot may be in a tile from one slab to another. The stays are closed: a robot in a stay in one
    slab is, in the next slab, in a stay of that tile or of one of its eight neighbours, or where
    the disc cannot be, or too far away to arrive in time. So a robot that begins at the start is
    always in some stay while it could still arrive in time.

    Args:
        k: Tiles per cell side.
        slab: Length of a slab, s.
        deadline: s; None if the target is never reached.
        stays: (n, 4) int64, rows (column of the tile, its row, first slab, last slab).
    """

    k: int
    slab: Fraction
    deadline: float | None
    stays: Ints


@dataclass(frozen=True, eq=False)
class CarConfinement:
    """Boxes of poses that a car which never reverses cannot leave, with the target out of reach.

    From any pose in them, the car is in one of them again, or in a wall, when it has driven a step. Box
    (heading, row, column) has places (column to column + 1, row to row + 1) times ``side``, and
    headings up to half a part of a turn from ``heading`` parts.

    Args:
        side: Side of a box, m.
        step: Length of a step, m.
        headings: Parts of a turn.
        discs: Discs that the body holds, (ahead of the axle, to its left, radius), m; the first one is
            about the axle. The car is in a wall where one of them is.
        boxes: (n, 4) int64, runs of boxes: heading, row, first and last column.
    """

    side: float
    step: float
    headings: int
    discs: tuple[tuple[float, float, float], ...]
    boxes: Ints

    @property
    def count(self) -> int:
        """Number of boxes."""
        return int((self.boxes[:, 3] - self.boxes[:, 2] + 1).sum())
