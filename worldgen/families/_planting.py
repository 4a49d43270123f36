"""Puts round things down at random until none fits any more, every two a least gap apart.

The planter is one function over indexable buffers: small squares run it as plain Python on lists, large
ones compiled on arrays; both see small integers only.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.families._routes import COMPILE_FROM
from worldgen.jit import lazy_kernel

__all__ = ["disc_cells", "plant"]


def disc_cells(diameter: int) -> npt.NDArray[np.int64]:
    """Cells of a disc, rows (dx, dy): those whose centre is in it.

    An odd disc's centre is the centre of cell (0, 0), an even one's the lower left corner of it.
    """
    reach = diameter // 2 + 1
    offsets = np.arange(-reach, reach + 1)
    halves = 2 * offsets + (diameter % 2 == 0)
    inside = halves[:, np.newaxis] ** 2 + halves[np.newaxis, :] ** 2 <= diameter * diameter
    rows, columns = np.nonzero(inside)
    return np.stack([offsets[columns], offsets[rows]], axis=1)


def _halo(cells: npt.NDArray[np.int64], gap: Fraction) -> npt.NDArray[np.int64]:
    """Cells less than a gap from one of a disc's, those themselves included, rows (dx, dy)."""
    limit = math.ceil(gap * gap) - 1  # squares of whole numbers below gap * gap are at most this
    reach = math.isqrt(limit) + 1
    rows = {int(dy): (int(dx.min()), int(dx.max())) for dy in set(cells[:, 1]) for dx in [cells[cells[:, 1] == dy, 0]]}
    pieces = []
    for y in range(min(rows) - reach, max(rows) + reach + 1):
        spans = []
        for dy, (low, high) in rows.items():  # a disc's rows are whole, and all spans hold its middle
            above = max(abs(y - dy) - 1, 0)
            if above * above <= limit:
                beside = 1 + math.isqrt(limit - above * above)
                spans.append((low - beside, high + beside))
        x = np.arange(min(low for low, _ in spans), max(high for _, high in spans) + 1)
        pieces.append(np.stack([x, np.full(len(x), y)], axis=1))
    return np.concatenate(pieces)


def put_down(
    barred: Any, stands: Any, places: Any, kinds: Any, cells: Any, cell_ends: Any, halos: Any, ends: Any
) -> None:
    """Visits places in turn and puts a thing down wherever none of its cells is barred.

    Args:
        barred: (n,) 1 where no cell of a thing may be; grows with every thing put down.
        stands: (m,) to be filled: 1 where the thing of that turn stands.
        places: (m,) where to try.
        kinds: (m,) what to try there.
        cells: Offsets of the cells of all kinds, one kind after the other.
        cell_ends: Where each kind's offsets end.
        halos: Likewise the offsets that a thing bars.
        ends: Where these end.
    """
    for turn in range(len(places)):
        at, kind = places[turn], kinds[turn]
        if barred[at] != 0:
            continue
        fits = True
        for k in range(cell_ends[kind - 1] if kind > 0 else 0, cell_ends[kind]):
            if barred[at + cells[k]] != 0:
                fits = False
                break
        if fits:
            stands[turn] = 1
            for k in range(ends[kind - 1] if kind > 0 else 0, ends[kind]):
                barred[at + halos[k]] = 1


_put_down_compiled = lazy_kernel(put_down)


def plant(
    free: npt.NDArray[np.bool_],
    places: npt.NDArray[np.int64],
    kinds: npt.NDArray[np.int64],
    diameters: range,
    gap: Fraction,
) -> npt.NDArray[np.bool_]:
    """Which turns put a disc down: (m,) bool.

    Args:
        free: Cells that a disc may cover.
        places: (m, 2) columns and rows of the discs' centres, in the order in which they are tried.
        kinds: (m,) the disc's diameter, as its index in ``diameters``.
        diameters: Cells; all are odd or even discs as :func:`disc_cells` says.
        gap: Least distance between two discs' cells, in cells.

    Source: dart throwing until nothing fits, Cook, "Stochastic sampling in computer graphics", 1986; that
    every place is tried once, in random order, is what makes it stop.
    """
    shapes = [disc_cells(diameter) for diameter in diameters]
    halos = [_halo(shape, gap) for shape in shapes]
    margin = int(max(np.abs(halo).max() for halo in halos))
    barred = np.pad(~free, margin, constant_values=True).astype(np.uint8)
    stride = barred.shape[1]
    at = (places[:, 1] + margin) * stride + places[:, 0] + margin
    tables: list[npt.NDArray[Any]] = [at, kinds]
    for offsets in (shapes, halos):
        tables.append(np.concatenate([each[:, 1] * stride + each[:, 0] for each in offsets]))
        tables.append(np.cumsum([len(each) for each in offsets]))
    stands = np.zeros(len(places), dtype=np.uint8)
    if len(places) >= COMPILE_FROM:
        _put_down_compiled(barred.reshape(-1), stands, *tables)
        return stands.view(np.bool_)
    plain = bytearray(len(places))
    put_down(bytearray(barred.tobytes()), plain, *(table.tolist() for table in tables))
    return np.frombuffer(plain, dtype=np.bool_)
