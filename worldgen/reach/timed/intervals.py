"""Find the times at which points of a raster are safe.

They are the intervals between the spans in which nearby cells are blocked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import numpy as np

from worldgen._core import ffi, lib
from worldgen.reach.still.lattice_graph import touching_cells
from worldgen.reach.still.walls import Cell
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, kept, pointer, writable

# Points between two checks for Ctrl-C.
_PORTION = 2_000_000


class Blocked(Protocol):
    """The spans in which each changing cell is blocked, as in :class:`Spans`."""

    changing: Bools
    first: Ints
    begin: Ints
    end: Ints


@dataclass
class CellSpans:
    """The same for spans derived from a world's.

    Args:
        changing: (height, width) bool, cells with spans.
        first: (height * width + 1,) int64, index of each cell's first span.
        begin: (n,) int64, ticks.
        end: (n,) int64, ticks.
    """

    changing: Bools
    first: Ints
    begin: Ints
    end: Ints


@dataclass(frozen=True)
class Intervals:
    """Safe intervals of the points of a raster.

    Point p has intervals first[p] to first[p + 1] - 1, by time, in ticks.
    """

    first: Ints
    begin: Ints
    end: Ints


def touching(radius: Fraction, k: int, half: int) -> list[list[Cell]]:
    """Return, for each place in a cell, the cells within the radius of it.

    Points are at multiples of 1/k or, if ``half`` is 1, 1 / 2k beyond them.
    """
    return [
        touching_cells(2 * a + half, 2 * b + half, 2 * k, radius)
        for b in range(k)
        for a in range(k)
    ]


def safe_intervals(clear: Bools, spans: Blocked, classes: Sequence[Sequence[Cell]]) -> Intervals:
    """Find the times at which the points of a raster are safe.

    Args:
        clear: (rows, columns) bool, points that no cell blocks forever; the others have no
            interval.
        spans: Times at which cells are blocked.
        classes: (k * k) offsets of the cells that make a point unsafe, for each of the k x k points
            of one cell.
    """
    asked = _described(clear, spans, classes)
    first = np.zeros(clear.size + 1, np.int64)
    made = writable(ffi, first, np.int64)
    for begin in range(0, clear.size, _PORTION):
        end = min(begin + _PORTION, clear.size)
        check(lib.wg_safe_intervals(asked, begin, end, made, ffi.NULL, ffi.NULL, False))
    first = np.cumsum(first)
    begins = np.empty(int(first[-1]), np.int64)
    ends = np.empty(int(first[-1]), np.int64)
    outputs = tuple(writable(ffi, array, np.int64) for array in (first, begins, ends))
    for begin in range(0, clear.size, _PORTION):
        end = min(begin + _PORTION, clear.size)
        check(lib.wg_safe_intervals(asked, begin, end, *outputs, True))
    return Intervals(first, begins, ends)


def _described(clear: Bools, spans: Blocked, classes: Sequence[Sequence[Cell]]) -> Any:
    """Return points and spans in the form that C reads."""
    pad = max((max(abs(dx), abs(dy)) for found in classes for dx, dy in found), default=0) + 1
    cells = np.pad(spans.changing, pad)
    number = np.zeros(cells.size, np.int64)
    number[cells.ravel()] = np.diff(spans.first)[spans.changing.ravel()]
    stride = cells.shape[1]
    most = int(number.max(initial=0)) * max(len(found) for found in classes)
    arrays = (
        np.concatenate([[0], np.cumsum([len(found) for found in classes])]).astype(np.int64),
        np.array([dy * stride + dx for found in classes for dx, dy in found], np.int64),
        np.concatenate([[0], np.cumsum(number)]),
        np.ascontiguousarray(spans.begin),
        np.ascontiguousarray(spans.end),
    )
    class_first, steps, span_first, span_begin, span_end = (
        pointer(ffi, array, np.int64) for array in arrays
    )
    rows, columns = clear.shape
    points = np.ascontiguousarray(clear)
    fields = {
        "clear": pointer(ffi, points, np.bool_),
        "rows": rows,
        "columns": columns,
        "k": round(len(classes) ** 0.5),
        "class_first": class_first,
        "steps": steps,
        "pad": pad,
        "stride": stride,
        "cells": cells.size,
        "span_first": span_first,
        "span_begin": span_begin,
        "span_end": span_end,
        "most": most,
    }
    return kept(ffi, ffi.new("WgBlocked *", fields), points, arrays)
