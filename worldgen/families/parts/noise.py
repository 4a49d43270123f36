"""Smooth noise in integers, so that every machine gives the same result."""

from __future__ import annotations

import numpy as np

from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Ints

_LEVELS = 1024  # number of different heights at lattice points


def smooth_noise(rng: RandomStream, size: int, pitch: int) -> Ints:
    """Return (size, size) heights that vary smoothly.

    Heights are random at the points of a lattice, and interpolated bilinearly between them. The
    result is not divided by ``pitch ** 2``: only sums and products of integers are exact.

    Args:
        rng: The only source of randomness.
        size: Cells per side.
        pitch: Cells between neighbouring lattice points.

    Source: value noise.
    """
    points = size // pitch + 2
    heights = (
        (rng.bits(points * points) % np.uint64(_LEVELS)).astype(np.int64).reshape(points, points)
    )
    cell, within = np.divmod(np.arange(size), pitch)
    rows = (
        heights[cell] * (pitch - within)[:, np.newaxis] + heights[cell + 1] * within[:, np.newaxis]
    )
    smooth: Ints = rows[:, cell] * (pitch - within) + rows[:, cell + 1] * within
    return smooth
