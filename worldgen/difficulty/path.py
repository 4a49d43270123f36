"""The witness as a line of whole numbers: length, turning, and places along it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from worldgen.lattice import UNIT
from worldgen.support.arrays import Ints
from worldgen.world import Witness, World


@dataclass(frozen=True, eq=False)
class WitnessPath:
    """A witness without its pauses.

    Args:
        x: (n,) int64, 1/1024 cell, n at least 1; no two neighbours are the same point.
        y: (n,) int64, 1/1024 cell.
        duration: Time of arrival, s.
        waiting: How long it pauses, s.
    """

    x: Ints
    y: Ints
    duration: float
    waiting: float

    @property
    def pieces(self) -> list[float]:
        """Length of each piece, 1/1024 cell."""
        dx = np.diff(self.x)
        dy = np.diff(self.y)
        lengths: list[float] = np.sqrt((dx * dx + dy * dy).astype(np.float64)).tolist()
        return lengths

    @property
    def length(self) -> float:
        """Length, 1/1024 cell; rounded once, so that a mirrored path is exactly as long."""
        return math.fsum(self.pieces)

    @property
    def turning(self) -> float:
        """Sum of the angles between consecutive pieces, rad."""
        dx = np.diff(self.x)
        dy = np.diff(self.y)
        dot = dx[:-1] * dx[1:] + dy[:-1] * dy[1:]
        cross = dx[:-1] * dy[1:] - dy[:-1] * dx[1:]
        return math.fsum(
            angle(*pair) for pair in zip(dot.tolist(), np.abs(cross).tolist(), strict=True)
        )


def witness_path_of(world: World, witness: Witness) -> WitnessPath:
    """Round the witness's points to 1/1024 cell, the unit of the prover.

    Args:
        world: The world, for its cell size.
        witness: The witness, of at least one point.
    """
    points = [
        np.rint(np.asarray(values) / world.cell_size * UNIT).astype(np.int64)
        for values in (witness.x, witness.y)
    ]
    moves = (np.diff(points[0]) != 0) | (np.diff(points[1]) != 0)
    waits = np.diff(witness.times)[~moves]
    kept = np.concatenate(([True], moves))
    return WitnessPath(
        points[0][kept], points[1][kept], witness.duration, math.fsum(waits.tolist())
    )


def distance(ax: float, ay: float, bx: float, by: float) -> float:
    """Return the straight distance.

    It uses a square root because the last bit of ``hypot`` differs between machines.
    """
    return math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))


def angle(dot: int, cross: int) -> float:
    """Return the angle between two vectors, 0 to pi rad, from their dot and |cross| products.

    The tangent's angle is halved four times, until its series converges fast. That needs only ``+ -
    * /`` and square roots, which are the same on every machine, unlike the arc tangents of C
    libraries. The error is below 1e-14.
    """
    if cross == 0:
        return math.pi if dot < 0 else 0.0
    size = math.sqrt(float(dot * dot + cross * cross))
    # Neither term cancels.
    tangent = cross / (size + dot) if dot > 0 else (size - dot) / cross
    for _ in range(3):
        tangent = tangent / (1.0 + math.sqrt(1.0 + tangent * tangent))
    square = tangent * tangent
    term = tangent
    total = 0.0
    for odd in range(1, 25, 2):
        total += term / odd
        term *= -square
    return 16.0 * total
