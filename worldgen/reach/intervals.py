"""When points of a raster are safe: the intervals between the spans in which cells near them are blocked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from worldgen.jit import lazy_kernel
from worldgen.reach.lattice_graph import touching_cells
from worldgen.reach.spans import FOREVER
from worldgen.reach.walls import Cell

__all__ = ["Blocked", "CellSpans", "Intervals", "safe_intervals", "touching"]

Ints = npt.NDArray[np.int64]


class Blocked(Protocol):
    """The spans in which each cell that changes is blocked, as :class:`Spans` has them."""

    changing: npt.NDArray[np.bool_]
    first: Ints
    begin: Ints
    end: Ints


@dataclass
class CellSpans:
    """The same, of spans that were made from those of a world.

    Args:
        changing: (height, width) bool, cells with spans.
        first: (height * width + 1,) int64, where each cell's spans begin.
        begin: (n,) int64, ticks.
        end: (n,) int64, ticks.
    """

    changing: npt.NDArray[np.bool_]
    first: Ints
    begin: Ints
    end: Ints


@dataclass(frozen=True)
class Intervals:
    """Safe intervals of the points of a raster: point p has first[p] to first[p + 1] - 1, by time, in ticks."""

    first: Any
    begin: Any
    end: Any


def touching(radius: Fraction, k: int, half: int) -> list[list[Cell]]:
    """Per place in a cell, the cells nearer than the radius to it: at multiples of 1/k, or ``half`` 1 / 2k beyond."""
    return [touching_cells(2 * a + half, 2 * b + half, 2 * k, radius) for b in range(k) for a in range(k)]


def safe_intervals(
    clear: npt.NDArray[np.bool_], spans: Blocked, classes: Sequence[Sequence[Cell]], plain: bool
) -> Intervals:
    """When the points of a raster are safe.

    Args:
        clear: (rows, columns) bool, points that no cell blocks for ever; the others have no interval.
        spans: When cells are blocked.
        classes: (k * k) offsets of the cells that make a point unsafe, for each of the k x k points of one cell.
        plain: Whether plain Python does it, or a compiled kernel.
    """
    inputs, most = _points_and_spans(clear, spans, classes)
    first, work, nothing = np.zeros(clear.size + 1, np.int64), np.zeros(most + 2, np.int64), np.zeros(0, np.int64)
    if plain:
        lists = [array.tolist() for array in inputs]
        counts, low, high = first.tolist(), work.tolist(), work.tolist()
        arguments: Any = (*lists, counts, [], [], low, high, False)
        _safe_intervals(*arguments)
        total = np.cumsum(counts).tolist()
        begin, end = [0] * total[-1], [0] * total[-1]
        arguments = (*lists, total, begin, end, low, high, True)
        _safe_intervals(*arguments)
        return Intervals(total, begin, end)
    arguments = (*inputs, first, nothing, nothing, work, work.copy(), False)
    _safe_intervals_compiled(*arguments)
    first = np.cumsum(first)
    begins, ends = np.zeros(int(first[-1]), np.int64), np.zeros(int(first[-1]), np.int64)
    arguments = (*inputs, first, begins, ends, work, work.copy(), True)
    _safe_intervals_compiled(*arguments)
    return Intervals(first, begins, ends)


def _points_and_spans(
    clear: npt.NDArray[np.bool_], spans: Blocked, classes: Sequence[Sequence[Cell]]
) -> tuple[Any, int]:
    """The first eight arguments of ``_safe_intervals``, and how many spans one point may have round it."""
    k = round(len(classes) ** 0.5)
    pad = max((max(abs(dx), abs(dy)) for found in classes for dx, dy in found), default=0) + 1
    cells = np.pad(spans.changing, pad)
    number = np.zeros(cells.size, np.int64)
    number[cells.ravel()] = np.diff(spans.first)[spans.changing.ravel()]
    span_first = np.concatenate([[0], np.cumsum(number)])
    steps = np.array([dy * cells.shape[1] + dx for found in classes for dx, dy in found], np.int64)
    class_first = np.concatenate([[0], np.cumsum([len(found) for found in classes])]).astype(np.int64)
    rows, columns = clear.shape
    y, x = np.arange(rows, dtype=np.int32)[:, None], np.arange(columns, dtype=np.int32)[None, :]
    place = (y // k + pad) * cells.shape[1] + x // k + pad  # 32 bits: there are tens of millions of points
    kind = y % k * k + x % k
    points = [clear.view(np.uint8).ravel(), place.ravel(), kind.ravel()]
    most = int(number.max(initial=0)) * max(len(found) for found in classes)
    return [*points, class_first, steps, span_first, spans.begin, spans.end], most


def _safe_intervals(
    clear: Any, place: Any, kind: Any, class_first: Any, steps: Any,
    span_first: Any, span_begin: Any, span_end: Any, first: Any, begin: Any, end: Any, low: Any, high: Any, fill: Any,
) -> None:  # fmt: skip
    """Counts the safe intervals of point p in first[p + 1], or writes them from first[p] on.

    ``low`` and ``high`` hold the blocked spans round one point, sorted by insertion. The same text runs
    plain and compiled.
    """
    for p in range(len(clear)):
        if clear[p] == 0:
            continue
        count = 0
        for s in range(class_first[kind[p]], class_first[kind[p] + 1]):
            cell = place[p] + steps[s]
            for span in range(span_first[cell], span_first[cell + 1]):
                at = count
                while at > 0 and low[at - 1] > span_begin[span]:
                    low[at], high[at] = low[at - 1], high[at - 1]
                    at -= 1
                low[at], high[at] = span_begin[span], span_end[span]
                count += 1
        free, found = 0, 0  # free: tick from which on nothing seen so far blocks the point
        for i in range(count + 1):
            until = low[i] if i < count else FOREVER
            if until > free:
                if fill:
                    begin[first[p] + found], end[first[p] + found] = free, until
                found += 1
            if i < count and high[i] > free:
                free = high[i]
        if not fill:
            first[p + 1] = found


_safe_intervals_compiled = lazy_kernel(_safe_intervals)
