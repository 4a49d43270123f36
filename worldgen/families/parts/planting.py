"""Place discs at random until no more fit, with a minimum gap between any two."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from worldgen import _core
from worldgen.support.arrays import Bools, Bytes, Ints
from worldgen.support.ccall import check, pointer, writable


def disc_cells(diameter: int) -> Ints:
    """Return the cells whose centres are in a disc, as rows (dx, dy).

    A disc of odd diameter is centred on the centre of cell (0, 0), one of even diameter on that
    cell's lower left corner.
    """
    reach = diameter // 2 + 1
    offsets = np.arange(-reach, reach + 1)
    halves = 2 * offsets + (diameter % 2 == 0)
    inside = halves[:, np.newaxis] ** 2 + halves[np.newaxis, :] ** 2 <= diameter * diameter
    rows, columns = np.nonzero(inside)
    return np.stack([offsets[columns], offsets[rows]], axis=1)


def _halo(cells: Ints, gap: Fraction) -> Ints:
    """Return the cells less than ``gap`` from a disc, including its own, as rows (dx, dy).

    Args:
        cells: (n, 2) rows (dx, dy) of the disc.
        gap: Minimum distance to keep, cells.
    """
    # The largest square of an integer below gap * gap.
    limit = math.ceil(gap * gap) - 1
    reach = math.isqrt(limit) + 1
    rows = {
        int(dy): (int(dx.min()), int(dx.max()))
        for dy in set(cells[:, 1])
        for dx in [cells[cells[:, 1] == dy, 0]]
    }

    # For each row, join the spans that the disc's rows block there. They all contain the disc's
    # middle column, so their union has no gaps.
    pieces = []
    for y in range(min(rows) - reach, max(rows) + reach + 1):
        spans = []
        for dy, (low, high) in rows.items():
            above = max(abs(y - dy) - 1, 0)
            if above * above <= limit:
                beside = 1 + math.isqrt(limit - above * above)
                spans.append((low - beside, high + beside))
        x = np.arange(min(low for low, _ in spans), max(high for _, high in spans) + 1)
        pieces.append(np.stack([x, np.full(len(x), y)], axis=1))
    return np.concatenate(pieces)


def plant(free: Bools, places: Ints, kinds: Ints, diameters: range, gap: Fraction) -> Bools:
    """Try to place a disc at each place in turn, and return which attempts succeed.

    Args:
        free: (rows, columns) bool, cells that a disc may cover.
        places: (m, 2) columns and rows of the discs' centres, in the order of the attempts.
        kinds: (m,) diameter of each disc, as an index into ``diameters``.
        diameters: Diameters, cells; :func:`disc_cells` defines the discs.
        gap: Minimum distance between the cells of two discs, cells.

    Returns:
        (m,) bool, True where a disc was placed.

    Source: dart throwing, Cook, "Stochastic sampling in computer graphics", 1986. Trying every
        place once, in random order, makes it stop.
    """
    shapes = [disc_cells(diameter) for diameter in diameters]
    halos = [_halo(shape, gap) for shape in shapes]
    margin = int(max(np.abs(halo).max() for halo in halos))
    barred = np.pad(~free, margin, constant_values=True).astype(np.uint8)
    stride = barred.shape[1]
    at = (places[:, 1] + margin) * stride + places[:, 0] + margin
    offsets = [[each[:, 1] * stride + each[:, 0] for each in kind] for kind in (shapes, halos)]
    return put_down(barred, at, kinds, *offsets)


def put_down(
    barred: Bytes, places: Ints, kinds: Ints, cells: list[Ints], halos: list[Ints]
) -> Bools:
    """Visit places in turn, and place an object wherever none of its cells is blocked.

    Args:
        barred: (rows, columns) uint8, 1 where no object's cell may be; every placed object adds its
            halo, in place.
        places: (m,) flat cells to try, in order.
        kinds: (m,) kind of the object to try at each place.
        cells: Flat offsets of the cells of each kind.
        halos: Flat offsets of the cells that an object of each kind blocks.

    Returns:
        (m,) bool, True where an object was placed.
    """
    ffi = _core.ffi
    lib = _core.lib
    turns = [pointer(ffi, np.ascontiguousarray(numbers), np.int64) for numbers in (places, kinds)]
    tables = []
    for offsets in (cells, halos):
        ends = np.cumsum([len(each) for each in offsets])
        tables += [pointer(ffi, np.concatenate(offsets), np.int64), pointer(ffi, ends, np.int64)]
    stands = np.zeros(len(places), dtype=np.bool_)
    grid = (writable(ffi, barred, np.uint8), barred.size)
    check(
        lib.wg_plant(
            *grid, *turns, len(places), *tables, len(cells), writable(ffi, stands, np.bool_)
        )
    )
    return stands
