"""The outline of a set of cells, as closed rectilinear lines."""

from __future__ import annotations

import numpy as np

from worldgen.support.arrays import Bools, Ints


def _parity(mask: Bools) -> Bools:
    padded = np.pad(mask, 1)
    return padded[:-1, :-1] ^ padded[:-1, 1:] ^ padded[1:, :-1] ^ padded[1:, 1:]


def corner_count(mask: Bools) -> int:
    """Return the total number of corners of the outlines."""
    return int(np.count_nonzero(_parity(mask)))


def outlines(mask: Bools) -> list[Ints]:
    """Return closed lines that, filled by the even-odd rule, cover exactly the cells that are set.

    A corner is a grid point with an odd number of set cells around it. Along each row of grid
    points the first corner is joined to the second, the third to the fourth, and so on; the same
    applies along each column. Lines may cross where two cells touch diagonally, which the even-odd
    rule handles.

    Args:
        mask: (height, width) bool.

    Returns:
        One (n, 2) int64 array per line: grid points (x, y), the last joined to the first.
    """
    y, x = np.nonzero(_parity(mask))
    by_column = np.lexsort((y, x))
    # The other end of the vertical edge; rows pair 0-1, 2-3, ...
    partner = np.empty(len(x), np.int64)
    partner[by_column] = by_column[np.arange(len(x)) ^ 1]
    vertical = partner.tolist()
    seen = bytearray(len(x))
    lines = []
    for first in range(len(x)):
        if seen[first]:
            continue
        order = []
        at = first
        while not seen[at]:
            other = at ^ 1
            seen[at] = seen[other] = 1
            order += [at, other]
            at = vertical[other]
        lines.append(np.column_stack((x[order], y[order])).astype(np.int64))
    return lines
