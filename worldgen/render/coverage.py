"""Cells to pixels: how much of each pixel is covered, whatever the two sizes are."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.rows import flip_rows

__all__ = ["coverage"]

FINE = 4  # where cells are larger than pixels, each pixel is sampled at this many places a side


def coverage(mask: npt.NDArray[np.bool_], width: int, height: int) -> npt.NDArray[np.uint8]:
    """How much of each pixel the set cells cover, top row first.

    Args:
        mask: (rows, columns) bool, row 0 the lowest y.
        width: Pixels across.
        height: Pixels down.

    Returns:
        (height, width) uint8, 0 to 255; exact where a cell is a whole number of pixels or of pixel parts.
    """
    share: npt.NDArray[Any] = flip_rows(mask)
    for axis, pixels in ((0, height), (1, width)):
        cells = share.shape[axis]
        if cells <= pixels:
            samples = pixels * FINE
            share = np.take(share, (np.arange(samples) * cells) // samples, axis=axis)
        share = _pooled(share, axis, pixels)
    return np.asarray(np.rint(share * 255.0), np.uint8)


def _pooled(values: npt.NDArray[Any], axis: int, pixels: int) -> npt.NDArray[np.float32]:
    """The mean of each of ``pixels`` neighbouring groups along one axis, as equal as whole numbers allow."""
    side = values.shape[axis]
    first = (np.arange(pixels) * side) // pixels
    counts = np.diff(np.append(first, side)).astype(np.float32)
    sums = np.add.reduceat(values, first, axis=axis, dtype=np.float32)
    return np.asarray(sums / (counts[:, None] if axis == 0 else counts), np.float32)
