"""Where a disc is clear, for each point of a graph, by doubling windows of cells.

The specification of ``rasters.c``.
"""

import math
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from worldgen.reach.still.lattice_graph import Graph


def build_graph(solid: npt.NDArray[np.bool_], radius: Fraction, k: int) -> Graph:
    """Return the graph of a grid for a disc of ``radius`` cells."""
    height, width = solid.shape
    clear = np.zeros((k * height + 1, k * width + 1), np.bool_)
    middle = np.zeros(clear.shape, np.bool_)
    if 2 * radius > min(height, width):  # nothing is clear
        return Graph(k, clear, middle)
    window = _Windows(solid, math.ceil(radius) + 1)
    for b in range(k):
        for a in range(k):
            clear[b::k, a::k] = clear_raster(
                window, 2 * a, 2 * b, 2 * k, radius, clear[b::k, a::k].shape
            )
            middle[b:-1:k, a:-1:k] = clear_raster(
                window, 2 * a + 1, 2 * b + 1, 2 * k, radius, (height, width)
            )
    return Graph(k, clear, middle)


class _Windows:
    """Return whether any of n cells in a row, counted from a cell to the right, is solid; by
    doubling.
    """

    def __init__(self, solid: npt.NDArray[np.bool_], pad: int) -> None:
        self.pad = pad
        self._powers = [np.pad(solid, pad, constant_values=True)]

    def any_of(self, count: int) -> npt.NDArray[np.bool_]:
        """Array w with w[j, i] = any of the padded cells i .. i + count - 1 of row j."""
        level = count.bit_length() - 1
        while len(self._powers) <= level:
            half = self._powers[-1]
            step = 1 << (len(self._powers) - 1)
            self._powers.append(half[:, :-step] | half[:, step:])
        base = self._powers[level]
        rest = count - (1 << level)
        return base if rest == 0 else base[:, : base.shape[1] - rest] | base[:, rest:]


def clear_raster(
    windows: _Windows, a: int, b: int, m: int, radius: Fraction, shape: tuple[int, int]
) -> npt.NDArray[np.bool_]:
    """Return whether the disc is clear at the points (i + a/m, j + b/m), for j, i below ``shape``.

    The squared distance from such a point to a cell is an integer in units of 1/m cell squared, so
    the comparison with the radius is exact.
    """
    limit = math.ceil((m * radius) ** 2)  # clear means: squared distance >= limit
    blocked = np.zeros(shape, np.bool_)
    reach = math.isqrt(limit - 1)
    made: dict[int, npt.NDArray[np.bool_]] = {}
    for dj in range(-((reach + m - b) // m), (reach + b) // m + 1):
        dy = max(m * dj - b, 0, b - m * dj - m)
        across = math.isqrt(limit - dy * dy - 1)
        low = -((across + m - a) // m)
        high = (across + a) // m
        count = high - low + 1
        if count not in made:
            made[count] = windows.any_of(count)
        row = windows.pad + dj
        column = windows.pad + low
        blocked |= made[count][row : row + shape[0], column : column + shape[1]]
    return ~blocked
