"""How a cut is found: a reference for ``links.c`` and ``cut.c``, over links and bits in NumPy."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from tests.reference.worldgen.cut import odd_walk
from worldgen.lattice import UNIT
from worldgen.reach.still.cut import rim_cells
from worldgen.reach.still.walls import Cell, ExactPoint, Point

_FINE_BITS = 10  # factor by which the unit may be finer before coordinates overflow 64-bit products
_STARTS = 24  # cells from which a short cycle is searched for
_WORK = 20_000_000  # limit on row and cell visits in those searches: 0.1 s

Ints = npt.NDArray[np.int64]


def find_chain(
    solid: npt.NDArray[np.bool_], radius: Fraction, start: ExactPoint, targets: Sequence[ExactPoint]
) -> list[Cell] | None:
    """Return a chain of cells that separates one clear pose from others for a disc, or None.

    Args:
        solid: (height, width) bool.
        radius: cells.
        start: A clear pose, 1/1024 cell.
        targets: One other, or up to :data:`MOST_TARGETS`, each of which can be separated from the
            start.

    Returns:
        Cells (ix, iy) in chain order; -1 and the grid's sides are the cells just outside.
    """
    links = _Links(solid, radius, start, targets)
    if links.bits > 1:
        return _short_cycle(links, np.ones(len(links.cells), np.bool_))
    has_odd = links.in_odd_cycles()
    return _short_cycle(links, has_odd) if has_odd.any() else None


def linked_offsets(radius: Fraction) -> list[Cell]:
    """Every (dx, dy) between two cells whose gap is below ``2 * radius`` cells.

    The first half has no two offsets that are each other's reverse.
    """
    limit = math.ceil(
        (2 * radius) ** 2
    )  # gap squared is whole: gap < 2 r means gap squared < limit
    reach = math.isqrt(limit - 1) + 1
    span = range(-reach, reach + 1)
    found = [
        (dx, dy)
        for dx in span
        for dy in span
        if (dx, dy) != (0, 0) and max(abs(dx) - 1, 0) ** 2 + max(abs(dy) - 1, 0) ** 2 < limit
    ]
    return found[len(found) // 2 :] + found[: len(found) // 2]


class _Links:
    """The cells of the rim, their links, and the bits of those.

    Attributes:
        cells: (n, 2) int64, (ix, iy) of the solid cells that touch a free one, the ring outside
            included; by rows.
        rank: How many cells come before a place of the flat raster, which is wide enough for every
            offset.
        place: (n,) a cell's place in that raster.
        rows: (m, 2) what to add to a place to get to the row of an offset, and how far to either
            side that row is linked.
        bits: Number of targets.
        slot: (n,) number of each cell that has a link across a ray, else -1.
        begins: (k + 1,) where in ``ends`` the links of such a cell begin.
        ends: (l,) the cells that they lead to.
        odd: (l,) uint8, their bits, one for each target; links of all other cells have none.
    """

    def __init__(
        self,
        solid: npt.NDArray[np.bool_],
        radius: Fraction,
        start: ExactPoint,
        targets: Sequence[ExactPoint],
    ) -> None:
        fine = (
            1
            if all(value == int(value) for point in (start, *targets) for value in point)
            else _fineness(radius)
        )
        self.unit, self.bits = UNIT * fine, len(targets)
        self.points: list[Point] = [
            (round(x * fine), round(y * fine)) for x, y in (start, *targets)
        ]
        self.offsets = np.array(linked_offsets(radius), np.int64)
        reach = int(self.offsets.max())
        rim = np.pad(rim_cells(solid), reach)
        stride = rim.shape[1]
        rows, columns = np.nonzero(rim)
        self.cells: Ints = np.stack([columns, rows], axis=1) - (reach + 1)
        self.place: Ints = rows * stride + columns
        self.rank = np.zeros(rim.size + 1, np.int32)
        np.cumsum(rim.ravel(), dtype=np.int32, out=self.rank[1:])
        heights = np.arange(-reach, reach + 1)
        wide = [int(self.offsets[self.offsets[:, 1] == height, 0].max()) for height in heights]
        self.rows: Ints = np.stack([heights * stride, np.array(wide, np.int64)], axis=1)
        self._list_crossing(reach)

    def _list_crossing(self, reach: int) -> None:
        """Sets ``slot``, ``begins``, ``ends`` and ``odd``."""
        near = np.zeros(len(self.cells), np.bool_)
        for x, y in self.points:
            beside, above = (
                np.abs(self.cells[:, 0] - x // self.unit),
                self.cells[:, 1] - y // self.unit,
            )
            near |= (beside <= reach + 1) & (above >= -reach - 1)
        chosen = np.flatnonzero(near)
        row = self.place[chosen, None] + self.rows[:, 0]
        first = self.rank[row - self.rows[:, 1]].ravel()
        count = self.rank[row + self.rows[:, 1] + 1].ravel() - first
        begins = np.repeat(chosen, count.reshape(len(chosen), -1).sum(axis=1))
        ends = np.arange(count.sum()) + np.repeat(first - np.cumsum(count) + count, count)
        begins, ends = begins[begins != ends], ends[begins != ends]
        odd = self._link_bits(self.cells[begins], self.cells[ends])
        crossing = np.zeros(len(self.cells), np.bool_)
        crossing[begins[odd > 0]] = True
        kept = crossing[begins]
        self.ends, self.odd = ends[kept], odd[kept]
        self.slot: Ints = np.where(crossing, np.cumsum(crossing) - 1, -1)
        self.begins = np.searchsorted(
            begins[kept], [*np.flatnonzero(crossing).tolist(), len(self.cells)]
        )

    def search(self, source: int, limit: int, *, thorough: bool = False) -> tuple[list[int], int]:
        """Return the shortest odd cycle through a cell, of under ``limit`` links, and the work.

        A thorough search continues to everything that it can reach, and leaves ``before`` and the
        rows as they are.
        """
        graph, work = self._work
        found, looked = odd_walk(*graph, *work, self.bits, source, limit, thorough)
        return work[-1][:found], looked

    @functools.cached_property
    def _work(self) -> Any:
        """The graph that the walk searches."""
        states = len(self.cells) << self.bits
        layer = len(self.cells) + 1
        arrays = (
            self.rank,
            self.place,
            self.rows.ravel(),
            self.slot,
            self.begins,
            self.ends,
            self.odd,
        )
        self.before = [-1] * states
        work = (self.before, [0] * states, list(range(layer << self.bits)), [0] * states)
        return tuple(array.tolist() for array in arrays), work

    def in_odd_cycles(self) -> npt.NDArray[np.bool_]:
        """(n,) whether a cell has a link across a ray, and is joined to a cycle whose bits add up
        to an odd number.
        """
        sources = np.nonzero(self.slot >= 0)[0].tolist()
        has_odd = np.zeros(len(self.cells), np.bool_)
        if sources:
            _ = self._work
            for source in sources:
                if self.before[2 * source] < 0 and self.before[2 * source + 1] < 0:
                    self.search(source, 2 * len(self.cells), thorough=True)
            seen = np.array(self.before).reshape(-1, 2) >= 0
            has_odd[sources] = seen[sources].all(axis=1)
            del self._work
        return has_odd

    def is_odd(self, cells: Ints) -> npt.NDArray[np.bool_]:
        """For each cell of a closed chain, whether its link to the next has bit 1."""
        return self._link_bits(cells, np.roll(cells, -1, axis=0)) > 0

    def _link_bits(self, begins: Ints, ends: Ints) -> npt.NDArray[np.uint8]:
        """(n,) the bits of links between cells, (n, 2) each."""
        bits = np.zeros(len(begins), np.uint8)
        astride = np.zeros(
            len(begins), np.bool_
        )  # few links cross a ray; the others need no arithmetic
        for x, _ in self.points:
            low, high = np.minimum(begins[:, 0], ends[:, 0]), np.maximum(begins[:, 0], ends[:, 0])
            astride |= (low <= x // self.unit) & (high >= x // self.unit)
        (x, y), (to_x, to_y) = begins[astride].T, ends[astride].T
        bits[astride] = self._crossing_bits(x, y, to_x - x, to_y - y)
        return bits

    def _crossing_bits(self, x: Ints, y: Ints, dx: Ints, dy: Ints) -> npt.NDArray[np.uint8]:
        """The bits of links from cells (x, y) to cells (x + dx, y + dy)."""
        if self.unit > UNIT << _FINE_BITS:  # products of coordinates need more than 64 bits
            x, y, dx, dy = (array.astype(object) for array in (x, y, dx, dy))
        unit, half = self.unit, self.unit // 2
        ax, ay = unit * x + half, unit * y + half
        dx_, dy_ = ax + unit * dx, ay + unit * dy
        bx, cx = ax + half * np.sign(dx), dx_ - half * np.sign(dx)
        by, cy = ay + half * np.sign(dy), dy_ - half * np.sign(dy)
        together = np.zeros(x.shape, np.uint8)
        all_bits = (1 << self.bits) - 1
        for px, py, qx, qy in ((ax, ay, bx, by), (bx, by, cx, cy), (cx, cy, dx_, dy_)):
            for point, bit in zip(
                self.points, (all_bits, *(1 << k for k in range(self.bits))), strict=True
            ):
                together ^= _crosses(px, py, qx, qy, *point) * np.uint8(bit)
        return together


def _fineness(radius: Fraction) -> int:
    """Return how much finer than 1/1024 cell the unit must be.

    A clear pose is farther from a link than the radius less half its gap.
    """
    widest_sq = math.ceil(4 * radius**2) - 1
    least = (radius**2 - Fraction(widest_sq, 4)) / (2 * radius)
    return int(1 << max(0, math.ceil(1 / (least * UNIT)) - 1).bit_length())


def _crosses(px: Ints, py: Ints, qx: Ints, qy: Ints, sx: int, sy: int) -> npt.NDArray[np.uint8]:
    """1 where segment pq crosses the ray from s upwards.

    Points level with s count as left of it.
    """
    astride = (px <= sx) != (qx <= sx)
    above = (py - sy) * (qx - px) + (qy - py) * (sx - px)
    crossing: npt.NDArray[np.uint8] = (astride & (np.sign(above) == np.sign(qx - px))).astype(
        np.uint8
    )
    return crossing


def _short_cycle(links: _Links, has_odd: npt.NDArray[np.bool_]) -> list[Cell] | None:
    """The shortest odd cycle through one of a few cells at the rays."""
    sources = np.nonzero(has_odd & (links.slot >= 0))[0]
    x, y = (UNIT * links.cells[sources] + UNIT // 2).T
    near = [
        (x - px * UNIT // links.unit) ** 2 + (y - py * UNIT // links.unit) ** 2
        for px, py in links.points
    ]
    sources = sources[np.argsort(np.min(near, axis=0), kind="stable")]
    few = np.unique(np.linspace(0, len(sources) - 1, _STARTS).astype(np.int64))
    chosen = (
        sources[few] if links.bits == 1 else np.concatenate([sources[few], np.delete(sources, few)])
    )
    size = len(links.cells) << links.bits
    work = (10 if links.bits > 1 else 1) * _WORK
    best: list[int] = []
    for source in chosen.tolist():
        chain, looked = links.search(source, len(best) or size)
        if chain and (not best or len(chain) < len(best)):
            best = chain
        work -= looked
        if work < 0 and (best or links.bits > 1):
            break
    if links.bits > 1:
        return [tuple(cell) for cell in links.cells[best].tolist()] or None
    return _simple(links, best)


def _simple(links: _Links, chain: Sequence[int]) -> list[Cell]:
    """Splits a closed chain at cells that it visits twice, keeping an odd part each time."""
    cells = links.cells[np.array(chain, np.int64)]
    odd = links.is_odd(cells)
    kept: list[tuple[Cell, bool]] = []  # cell, and the sum of bits from it to the next kept one
    where: dict[Cell, int] = {}
    for cell, bit in zip(map(tuple, cells.tolist()), odd.tolist(), strict=True):
        if cell in where:
            loop = kept[where[cell] :]
            if sum(piece[1] for piece in loop) % 2:
                return [piece[0] for piece in loop]
            for piece in loop:
                del where[piece[0]]
            del kept[len(kept) - len(loop) :]
        where[cell] = len(kept)
        kept.append((cell, bit))
    return [piece[0] for piece in kept]
