"""Convert cells to pixels of any size: the share of each pixel that is covered."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.support.arrays import Bools, Bytes, Floats
from worldgen.support.rows import flip_rows

# Rows shrunk together, which bounds the memory for worlds of 20,000 cells per side.
BLOCK = 1024


def coverage(mask: Bools, width: int, height: int) -> Bytes:
    """Return how much of each pixel the set cells cover, top row first.

    Args:
        mask: (rows, columns) bool, row 0 the lowest y.
        width: Pixels across.
        height: Pixels down.

    Returns:
        (height, width) uint8: the covered share of the area, times 255, rounded.
    """
    top_first = flip_rows(mask)
    blocks = [_means(top_first[row : row + BLOCK], width) for row in range(0, len(mask), BLOCK)]
    share = _means(np.concatenate(blocks).T, height).T
    return np.asarray(np.rint(share * 255.0), np.uint8)


def _means(values: npt.NDArray[Any], pixels: int) -> Floats:
    """Return a (rows, pixels) float64 array of means.

    Each is a row's mean over equal stretches, which may cut through its values.
    """
    rows, cells = values.shape
    sums = np.zeros((rows, cells + 1))
    np.cumsum(values, axis=1, out=sums[:, 1:])
    edges = np.arange(pixels + 1) * (cells / pixels)
    left = np.minimum(edges.astype(np.int64), cells - 1)
    part = edges - left
    until = sums[:, left] * (1.0 - part) + sums[:, left + 1] * part
    return np.asarray(np.diff(until, axis=1) * (pixels / cells), np.float64)
