"""Put round things down at random until none fits any more, every two a least gap apart."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.support.ccall import check, pointer, writable

__all__ = ["disc_cells", "plant", "put_down"]


def disc_cells(diameter: int) -> npt.NDArray[np.int64]:
    """Return the cells of a disc, rows (dx, dy): those whose centre is in it.

    An odd disc's centre is the centre of cell (0, 0), an even one's the lower left corner of it.
    """
    reach = diameter // 2 + 1
    offsets = np.arange(-reach, reach + 1)
    halves = 2 * offsets + (diameter % 2 == 0)
    inside = halves[:, np.newaxis] ** 2 + halves[np.newaxis, :] ** 2 <= diameter * diameter
    rows, columns = np.nonzero(inside)
    return np.stack([offsets[columns], offsets[rows]], axis=1)


def _halo(cells: npt.NDArray[np.int64], gap: Fraction) -> npt.NDArray[np.int64]:
    """Return the cells less than a gap from one of a disc's, those themselves included, rows.

    Dx, dy.
    """
    limit = math.ceil(gap * gap) - 1  # squares of whole numbers below gap * gap are at most this
    reach = math.isqrt(limit) + 1
    rows = {
        int(dy): (int(dx.min()), int(dx.max()))
        for dy in set(cells[:, 1])
        for dx in [cells[cells[:, 1] == dy, 0]]
    }
    pieces = []
    for y in range(min(rows) - reach, max(rows) + reach + 1):
        spans = []
        for dy, (
            low,
            high,
        ) in rows.items():  # a disc's rows are whole, and all spans hold its middle
            above = max(abs(y - dy) - 1, 0)
            if above * above <= limit:
                beside = 1 + math.isqrt(limit - above * above)
                spans.append((low - beside, high + beside))
        x = np.arange(min(low for low, _ in spans), max(high for _, high in spans) + 1)
        pieces.append(np.stack([x, np.full(len(x), y)], axis=1))
    return np.concatenate(pieces)


def plant(
    free: npt.NDArray[np.bool_],
    places: npt.NDArray[np.int64],
    kinds: npt.NDArray[np.int64],
    diameters: range,
    gap: Fraction,
) -> npt.NDArray[np.bool_]:
    """Return which turns put a disc down: (m,) bool.

    Args:
        free: Cells that a disc may cover.
        places: (m, 2) columns and rows of the discs' centres, in the order in which they are tried.
        kinds: (m,) the disc's diameter, as its index in ``diameters``.
        diameters: Cells; all are odd or even discs as :func:`disc_cells` says.
        gap: Least distance between two discs' cells, in cells.

    Source: dart throwing until nothing fits, Cook, "Stochastic sampling in computer graphics",
        1986; that
    every place is tried once, in random order, is what makes it stop.
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
    barred: npt.NDArray[np.uint8],
    places: npt.NDArray[np.int64],
    kinds: npt.NDArray[np.int64],
    cells: list[npt.NDArray[np.int64]],
    halos: list[npt.NDArray[np.int64]],
) -> npt.NDArray[np.bool_]:
    """Visit places in turn and put a thing down wherever none of its cells is barred.

    Args:
        barred: 1 where no cell of a thing may be; grows with every thing put down.
        places: (m,) where to try, flat.
        kinds: (m,) what to try there.
        cells: Offsets of the cells of each kind.
        halos: Offsets that a thing of each kind bars.

    Returns:
        (m,) where the thing of that turn stands.
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
