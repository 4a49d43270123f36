"""The largest disc that fits into a map, for messages about robots that don't."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.lattice import UNIT, exact, lattice_to_metres
from worldgen.reach.still.grid_search import squared_distances
from worldgen.support.arrays import Bools

_HALF = UNIT // 2
# Limit on the places whose distance to the walls is computed.
_MOST_MEASURED = 1 << 26
Point: TypeAlias = tuple[float, float]


class Fit(NamedTuple):
    """The largest disc that fits somewhere: its radius, rounded down, and its centre, m."""

    radius: float
    centre: Point


def largest_disc(walls: Bools, cell_size: float, among: Bools | None = None) -> Fit | None:
    """Return the largest disc that is clear at a multiple of half a cell.

    Args:
        walls: (height, width) bool, row 0 the lowest y.
        cell_size: m.
        among: (2 * height + 1, 2 * width + 1) bool: the places to consider; all if omitted.

    Returns:
        None if there is none, or the map is too large to tell quickly.
    """
    # Mark every place in a solid cell, or on the map's border.
    height, width = walls.shape
    if (2 * height + 1) * (2 * width + 1) > _MOST_MEASURED:
        return None
    padded = np.pad(walls, 1, constant_values=True)
    solid = np.zeros((2 * height + 1, 2 * width + 1), np.bool_)
    # A place at a corner or in the middle of a side belongs to all cells around it.
    for dj, di in ((0, 0), (0, 1), (1, 0), (1, 1)):
        solid[::2, ::2] |= padded[dj : dj + height + 1, di : di + width + 1]
    solid[1::2, 1::2] = walls
    solid[::2, 1::2] = padded[:-1, 1:-1] | padded[1:, 1:-1]
    solid[1::2, ::2] = padded[1:-1, :-1] | padded[1:-1, 1:]

    squares = squared_distances(solid)
    if among is not None:
        squares = np.where(among, squares, 0)
    best = int(np.argmax(squares))
    square = int(squares.ravel()[best])
    radius = _rounded_down(square, cell_size)
    if radius <= 0.0:
        return None
    j, i = divmod(best, squares.shape[1])
    return Fit(
        radius, (lattice_to_metres(i * _HALF, cell_size), lattice_to_metres(j * _HALF, cell_size))
    )


def _rounded_down(square: int, cell_size: float) -> float:
    """Return a length, m, with three digits, of a square in half cells."""
    length = math.sqrt(square) * cell_size / 2
    if length == 0.0:
        return 0.0
    unit = Fraction(10) ** (math.floor(math.log10(length)) - 2)
    units = math.floor(Fraction(length) / unit)
    while units and (2 * units * unit / exact(cell_size)) ** 2 > square:
        units -= 1
    return float(units * unit)


def no_room(walls: Bools, cell_size: float, radius: float) -> InvalidWorld:
    """Return the error for a disc that fits nowhere, with the largest one that does."""
    fit = largest_disc(walls, cell_size)
    is_full = bool(walls.all())
    return InvalidWorld(
        "no-room",
        "a disc of radius {radius:g} m does not fit anywhere in the map"
        + (", all of whose cells are solid" if is_full else ""),
        ("" if is_full else "use a smaller radius")
        if fit is None
        else "use a radius of up to {fits:g} m, which fits at {clear[0]!r},{clear[1]!r}",
        radius=radius,
        **({} if fit is None else {"fits": fit.radius, "clear": fit.centre}),
    )
