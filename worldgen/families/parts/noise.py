"""Smooth noise of whole numbers, the same on every machine."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from worldgen.random_streams import RandomStream

__all__ = ["smooth_noise"]

_LEVELS = 1024  # heights at the lattice's points


def smooth_noise(rng: RandomStream, size: int, pitch: int) -> npt.NDArray[np.int64]:
    """(size, size) heights: random ones at the points of a lattice, between them as bilinear interpolation has it.

    Args:
        rng: The only source of chance.
        size: Cells a side.
        pitch: Cells from one point of the lattice to the next.

    Source: value noise; only sums and products of whole numbers, so no rounding.
    """
    points = size // pitch + 2
    heights = (
        (rng.bits(points * points) % np.uint64(_LEVELS)).astype(np.int64).reshape(points, points)
    )
    cell, within = np.divmod(np.arange(size), pitch)
    rows = (
        heights[cell] * (pitch - within)[:, np.newaxis] + heights[cell + 1] * within[:, np.newaxis]
    )
    smooth: npt.NDArray[np.int64] = rows[:, cell] * (pitch - within) + rows[:, cell + 1] * within
    return smooth
