"""What a robot on its way has round it: the averages along a path by which BARN's authors describe a world.

Coordinates are cells in float64. Samples are multiples of a power of two not below 2**-23, so that every sum,
difference and comparison here is exact, and a world turned or mirrored gives the same numbers to the last bit.

Source: Perille, Truong, Xiao, Stone, "Benchmarking Metric Ground Navigation", 2020; docs/difficulty.md says where this
differs from the authors' program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from worldgen.difficulty.way import Ints, Way
from worldgen.lattice import UNIT

__all__ = ["Samples", "samples_of", "surroundings"]

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

_APART = 0.5  # cells: most between two samples
_MOST = 50_000  # samples; on longer ways they are farther apart
_PART = 20_000  # samples looked at together: 30 MB
_REACH = 3  # cells along the longer axis, within which walls count for the dispersion; the authors' radius
# Sixteen directions, counter-clockwise; every second one is along an axis or a diagonal.
_DIRECTIONS = np.array(
    [
        (1, 0), (2, 1), (1, 1), (1, 2), (0, 1), (-1, 2), (-1, 1), (-2, 1),
        (-1, 0), (-2, -1), (-1, -1), (-1, -2), (0, -1), (1, -2), (1, -1), (2, -1),
    ]
)  # fmt: skip
_ROOT_2 = math.sqrt(2.0)


@dataclass(frozen=True, eq=False)
class Samples:
    """Places along a way: the middles of equal parts of each piece.

    Args:
        x: (n,) cells.
        y: (n,) cells.
        weight: (n,) length of the part, cells.
    """

    x: Floats
    y: Floats
    weight: Floats

    def nodes(self) -> Ints:
        """(m, 2) int64, column and row of the nodes at the corners of the half cells that hold a sample."""
        low, high = ([np.floor(2 * v), np.ceil(2 * v)] for v in (self.x, self.y))
        pairs = [np.stack((a, b), axis=1) for a in low for b in high]
        return np.unique(np.concatenate(pairs).astype(np.int64), axis=0)


def samples_of(way: Way) -> Samples:
    """At most half a cell apart, on long ways farther; the point itself for a way without a length."""
    if len(way.x) == 1:
        return Samples(way.x / UNIT, way.y / UNIT, np.ones(1))
    lengths = np.array(way.pieces) / UNIT
    apart = _APART
    while math.fsum(lengths.tolist()) / apart > _MOST:
        apart *= 2.0
    share, power = np.frexp(np.maximum(lengths / apart, 1.0))
    parts = 2 ** np.where(share == 0.5, power - 1, power).astype(np.int64)  # the next power of two, without logarithms
    piece = np.repeat(np.arange(len(parts)), parts)
    number = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = (2 * number + 1) / (2 * parts[piece])
    x, y = ((v[:-1][piece] + np.diff(v)[piece] * share) / UNIT for v in (way.x, way.y))
    return Samples(x, y, lengths[piece] / parts[piece])


def surroundings(solid: Bools, samples: Samples) -> dict[str, float]:
    """Averages along the way, weighted by its length: distances in cells, and changes."""
    near, seen, narrow, changes = (np.zeros(len(samples.x)) for _ in range(4))
    table = _Walls(solid)
    for first in range(0, len(samples.x), _PART):
        part = slice(first, first + _PART)
        x, y = samples.x[part], samples.y[part]
        near[part] = table.nearest(x, y)
        far = table.rays(x, y)
        straight, slanted = far[:, 0::4], far[:, 2::4]
        seen[part] = (straight.sum(axis=1) + _ROOT_2 * slanted.sum(axis=1)) / 8.0
        widths = np.concatenate(
            (straight[:, :2] + straight[:, 2:], _ROOT_2 * (slanted[:, :2] + slanted[:, 2:])), axis=1
        )
        narrow[part] = widths.min(axis=1)
        walled = far * np.abs(_DIRECTIONS).max(axis=1) <= _REACH
        changes[part] = (walled != np.roll(walled, 1, axis=1)).sum(axis=1)
    total = math.fsum(samples.weight.tolist())
    means = [math.fsum((values * samples.weight).tolist()) / total for values in (near, seen, narrow, changes)]
    return dict(zip(("wall_distance", "visibility", "characteristic_dimension", "dispersion"), means, strict=True))


class _Walls:
    """Solid cells with the outside, for many points at once."""

    def __init__(self, solid: Bools) -> None:
        self.height, self.width = solid.shape
        self.solid = np.pad(solid, 1, constant_values=True)
        columns = np.arange(self.width + 2)
        self._left = np.maximum.accumulate(np.where(self.solid, columns, 0), axis=1)
        right = np.where(self.solid, columns, self.width + 1)
        self._right = np.minimum.accumulate(right[:, ::-1], axis=1)[:, ::-1]

    def nearest(self, x: Floats, y: Floats) -> Floats:
        """Distance from each point to the nearest wall, cells."""
        column, row = np.floor(x).astype(np.int64) + 1, np.floor(y).astype(np.int64) + 1
        best, step = np.full(len(x), np.inf), 0
        while step == 0 or (max(step - 1, 0) ** 2 < best).any():
            for other in (row - step, row + step):
                inside = np.clip(other, 0, self.height + 1)
                across = np.maximum(
                    np.minimum(x - self._left[inside, column], self._right[inside, column] - 1 - x), 0.0
                )
                up = np.maximum(np.maximum(inside - 1 - y, y - inside), 0.0)
                best = np.minimum(best, across * across + up * up)
            step += 1
        found: Floats = np.sqrt(best)
        return found

    def rays(self, x: Floats, y: Floats) -> Floats:
        """(n, 16) how far each ray gets before it touches a solid cell, in steps of its direction.

        Cells are closed: a ray that touches a corner or runs along a wall ends there. Slanted rays between the axes
        and diagonals are followed for ``_REACH`` cells along the longer axis only.
        """
        count = len(_DIRECTIONS)
        dx, dy = (np.tile(_DIRECTIONS[:, axis], len(x)) for axis in (0, 1))
        a, b = np.abs(dx).astype(np.float64), np.abs(dy).astype(np.float64)
        # Each ray is followed to the upper right, in a world mirrored for it.
        px, py = np.repeat(x, count), np.repeat(y, count)
        px, py = np.where(dx < 0, self.width - px, px), np.where(dy < 0, self.height - py, py)
        column, row = np.floor(px).astype(np.int64), np.floor(py).astype(np.int64)
        most = np.where(a + b > 2, _REACH / np.maximum(a, b), np.inf)
        far = np.full(len(px), np.inf)
        alive = np.arange(len(px))
        at_x, at_y = column == px, row == py  # on the line between two columns, or two rows
        here = self._solid(column, row, dx, dy, alive) | (at_x & self._solid(column - 1, row, dx, dy, alive))
        here |= at_y & (
            self._solid(column, row - 1, dx, dy, alive) | (at_x & self._solid(column - 1, row - 1, dx, dy, alive))
        )
        along_x, along_y = at_x & (a == 0), at_y & (b == 0)
        far[alive[here]] = 0.0
        alive = alive[~here]
        with np.errstate(divide="ignore"):
            while len(alive):
                i, j = column[alive], row[alive]
                tx, ty = (i + 1 - px[alive]) / a[alive], (j + 1 - py[alive]) / b[alive]
                t = np.minimum(tx, ty)
                right, up = tx <= ty, ty <= tx
                touched = (right & self._solid(i + 1, j, dx, dy, alive)) | (up & self._solid(i, j + 1, dx, dy, alive))
                touched |= right & up & self._solid(i + 1, j + 1, dx, dy, alive)
                touched |= up & along_x[alive] & self._solid(i - 1, j + 1, dx, dy, alive)
                touched |= right & along_y[alive] & self._solid(i + 1, j - 1, dx, dy, alive)
                far[alive[touched]] = t[touched]
                column[alive], row[alive] = i + right, j + up
                alive = alive[~touched & (t <= most[alive])]
        return far.reshape(len(x), count)

    def _solid(self, column: Ints, row: Ints, dx: Ints, dy: Ints, alive: Ints) -> Bools:
        """Whether cells of each ray's mirrored world are solid."""
        i = np.where(dx[alive] < 0, self.width - 1 - column, column)
        j = np.where(dy[alive] < 0, self.height - 1 - row, row)
        found: Bools = self.solid[np.clip(j + 1, 0, self.height + 1), np.clip(i + 1, 0, self.width + 1)]
        return found
