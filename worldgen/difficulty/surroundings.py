"""Measure the surroundings of a robot along its path.

These are the averages along a path by which BARN's authors describe a world. Coordinates are cells
in float64. Samples are multiples of a power of two that is at least 2**-23, so every sum,
difference and comparison here is exact, and a rotated or mirrored world gives the same numbers to
the last bit.

Source: Perille, Truong, Xiao, Stone, "Benchmarking Metric Ground Navigation", 2020;
    docs/howto/difficulty.md lists the differences from the authors' program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from worldgen import _core
from worldgen.difficulty.path import WitnessPath
from worldgen.lattice import UNIT
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.support.ccall import check, pointer, writable

# Maximum number of cells between two samples.
_APART = 0.5
# Maximum number of samples; on longer paths they are farther apart.
_MOST = 50_000
# Samples processed together: 30 MB.
_PART = 20_000
# Cells along the longer axis within which walls count for the dispersion: the authors' radius.
_REACH = 3
# Sixteen directions, counter-clockwise; every second one is along an axis or a diagonal.
_DIRECTIONS = np.array(
    [
        (1, 0), (2, 1), (1, 1), (1, 2), (0, 1), (-1, 2), (-1, 1), (-2, 1),
        (-1, 0), (-2, -1), (-1, -1), (-1, -2), (0, -1), (1, -2), (1, -1), (2, -1),
    ],
    np.int64,
)  # fmt: skip
_ROOT_2 = math.sqrt(2.0)


@dataclass(frozen=True, eq=False)
class Samples:
    """Places along a path: the middles of equal parts of each piece.

    Args:
        x: (n,) x, cells.
        y: (n,) y, cells.
        weight: (n,) length of the part, cells.
    """

    x: Floats
    y: Floats
    weight: Floats

    def nodes(self) -> Ints:
        """Return a (m, 2) int64 array: column and row of corners of half cells with samples."""
        low, high = ([np.floor(2 * v), np.ceil(2 * v)] for v in (self.x, self.y))
        # Sorting one number per pair is ten times as fast as sorting pairs.
        pairs = [a.astype(np.int64) << 32 | b.astype(np.int64) for a in low for b in high]
        found = np.unique(np.concatenate(pairs))
        return np.stack((found >> 32, found & 0xFFFFFFFF), axis=1)


def samples_of(way: WitnessPath) -> Samples:
    """Return samples at most half a cell apart, farther on long paths.

    A path of no length has its point as the only sample.
    """
    if len(way.x) == 1:
        return Samples(way.x / UNIT, way.y / UNIT, np.ones(1))
    lengths = np.array(way.pieces) / UNIT
    apart = _APART
    while math.fsum(lengths.tolist()) / apart > _MOST:
        apart *= 2.0
    share, power = np.frexp(np.maximum(lengths / apart, 1.0))
    # The next power of two, found without logarithms.
    parts = 2 ** np.where(share == 0.5, power - 1, power).astype(np.int64)
    piece = np.repeat(np.arange(len(parts)), parts)
    number = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = (2 * number + 1) / (2 * parts[piece])
    x, y = ((v[:-1][piece] + np.diff(v)[piece] * share) / UNIT for v in (way.x, way.y))
    return Samples(x, y, lengths[piece] / parts[piece])


def surroundings(solid: Bools, samples: Samples) -> dict[str, float]:
    """Return averages along the path, weighted by length: distances in cells, and changes."""
    near, seen, narrow, changes = (np.zeros(len(samples.x)) for _ in range(4))
    table = _Walls(solid)
    # In parts, because the rays take memory in proportion to the samples.
    for first in range(0, len(samples.x), _PART):
        part = slice(first, first + _PART)
        x = samples.x[part]
        y = samples.y[part]
        near[part] = table.nearest(x, y)
        far = table.rays(x, y)
        # Every fourth direction is axis-parallel; of the others, only diagonals are taken.
        straight = far[:, 0::4]
        slanted = far[:, 2::4]
        seen[part] = (straight.sum(axis=1) + _ROOT_2 * slanted.sum(axis=1)) / 8.0
        widths = np.concatenate(
            (straight[:, :2] + straight[:, 2:], _ROOT_2 * (slanted[:, :2] + slanted[:, 2:])), axis=1
        )
        narrow[part] = widths.min(axis=1)
        walled = far * np.abs(_DIRECTIONS).max(axis=1) <= _REACH
        changes[part] = (walled != np.roll(walled, 1, axis=1)).sum(axis=1)
    total = math.fsum(samples.weight.tolist())
    means = [
        math.fsum((values * samples.weight).tolist()) / total
        for values in (near, seen, narrow, changes)
    ]
    return dict(
        zip(
            ("wall_distance", "visibility", "characteristic_dimension", "dispersion"),
            means,
            strict=True,
        )
    )


class _Walls:
    """Solid cells, for queries about many points; everything outside is solid."""

    def __init__(self, solid: Bools) -> None:
        self._solid = np.ascontiguousarray(solid)

    def nearest(self, x: Floats, y: Floats) -> Floats:
        """Return the distance from each point to the nearest wall, cells."""
        ffi = _core.ffi
        lib = _core.lib
        found = np.empty(len(x), np.float64)
        check(lib.wg_nearest_walls(*self._asked(x, y), writable(ffi, found, np.float64)))
        return found

    def rays(self, x: Floats, y: Floats) -> Floats:
        """Return a (n, 16) array: steps in its direction before each ray hits a solid cell.

        Cells are closed: a ray that touches a corner or runs along a wall ends there. Slanted rays
        between the axes and diagonals are followed for only ``_REACH`` cells along the longer axis.
        """
        ffi = _core.ffi
        lib = _core.lib
        far = np.empty((len(x), len(_DIRECTIONS)), np.float64)
        directions = pointer(ffi, _DIRECTIONS, np.int64)
        check(
            lib.wg_rays(
                *self._asked(x, y),
                directions,
                len(_DIRECTIONS),
                _REACH,
                writable(ffi, far, np.float64),
            )
        )
        return far

    def _asked(self, x: Floats, y: Floats) -> tuple[Any, ...]:
        """Return walls and points in the core's form."""
        points = [pointer(_core.ffi, np.ascontiguousarray(values), np.float64) for values in (x, y)]
        return pointer(_core.ffi, self._solid, np.bool_), *self._solid.shape, *points, len(x)
