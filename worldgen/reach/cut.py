"""Finds a cut: a closed chain of solid cells, gaps below 2 r, that winds round start or target but not both.

Two cells are linked when their gap is below 2 r. Each link carries a bit: whether its line (centre, closest
point, closest point, centre) crosses the ray from the start upwards, xor the same for the target. A cycle
whose bits add up to an odd number parts start from target, and there is one exactly if the two lie in
different components of the clear poses (docs/reachability.md). A union-find that keeps bits tells whether
there is one; a breadth-first search over (cell, bit) then finds a short one.

Several targets get a bit each; then only a cycle all of whose bits are odd parts the start from them all.

Lengths are whole numbers of 1/1024 cell, or of a finer unit where a target is no multiple of that and a link passes it
closely, so every crossing is decided exactly.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.jit import lazy_kernel
from worldgen.lattice import UNIT
from worldgen.reach.walls import Cell, ExactPoint, Point

__all__ = ["MOST_TARGETS", "find_chain", "linked_offsets", "rim_cells"]

MOST_TARGETS = 6
"""Poses that a chain is sought for at once; no more than a byte has bits."""

_SMALL = 400_000  # links that plain Python unites in less time than loading numba takes
_FINE_BITS = 10  # by which the unit may be finer before coordinates outgrow 64-bit products
_STARTS = 24  # cells from which a short cycle is sought
_WORK = 2_000_000  # links that those searches may follow in plain Python; 200 times that when compiled

Ints = npt.NDArray[np.int64]


def find_chain(
    solid: npt.NDArray[np.bool_], radius: Fraction, start: ExactPoint, targets: Sequence[ExactPoint]
) -> list[Cell] | None:
    """A chain of cells that parts one clear pose from others for a disc of ``radius`` cells, or None if there is none.

    Args:
        solid: (height, width) bool.
        radius: cells.
        start: A clear pose, 1/1024 cell.
        targets: One other, or up to :data:`MOST_TARGETS`, of which each can be parted from the start.

    Returns:
        Cells (ix, iy) in chain order; -1 and the grid's sides stand for the cells just outside.
    """
    links = _Links(solid, radius, start, targets)
    if links.bits > 1:
        return _short_cycle(links, np.ones(len(links.cells), np.bool_))
    cells = len(links.cells)
    parent, bit, odd_one = np.arange(cells), np.zeros(cells, np.uint8), np.zeros(cells, np.uint8)
    graph: Any = links.arrays()
    if links.plain:
        lists: Any = (parent.tolist(), bit.tolist(), odd_one.tolist())
        _unite(*graph, *lists)
        parent, odd_one = np.array(lists[0]), np.array(lists[2])
    else:
        tree: Any = (parent, bit, odd_one)
        _unite_compiled(*graph, *tree)
    if not odd_one.any():
        return None
    return _short_cycle(links, odd_one[_roots(parent)] > 0)


def linked_offsets(radius: Fraction) -> list[Cell]:
    """Every (dx, dy) between two cells whose gap is below ``2 * radius`` cells.

    The first half has no two offsets that are each other's reverse.
    """
    limit = math.ceil((2 * radius) ** 2)  # gap squared is whole: gap < 2 r means gap squared < limit
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
        cells: (n, 2) int64, (ix, iy) of the solid cells that touch a free one, the ring outside included.
        number: Flat raster, wide enough for every offset, with each cell's number or -1.
        place: (n,) where in ``number`` a cell is.
        steps: (m,) what each offset adds to a place.
        slot: (n,) row of ``odd`` for cells near a ray, else -1.
        odd: (k, m) uint8, bits of each link of these cells, one for each target; all other links have 0.
        bits: How many targets there are.
    """

    def __init__(
        self, solid: npt.NDArray[np.bool_], radius: Fraction, start: ExactPoint, targets: Sequence[ExactPoint]
    ) -> None:
        fine = 1 if all(value == int(value) for point in (start, *targets) for value in point) else _fineness(radius)
        self.unit, self.bits = UNIT * fine, len(targets)
        self.points: list[Point] = [(round(x * fine), round(y * fine)) for x, y in (start, *targets)]
        self.offsets = np.array(offsets := linked_offsets(radius), np.int64)
        reach = int(self.offsets.max())
        rim = np.pad(rim_cells(solid), reach)
        stride = rim.shape[1]
        rows, columns = np.nonzero(rim)
        self.cells: Ints = np.stack([columns, rows], axis=1) - (reach + 1)
        self.place: Ints = rows * stride + columns
        self.number: Ints = np.full(rim.size, -1, np.int64)
        self.number[self.place] = np.arange(len(rows))
        self.steps: Ints = self.offsets[:, 1] * stride + self.offsets[:, 0]
        near = np.zeros(len(rows), np.bool_)
        for x, _ in self.points:
            near |= np.abs(self.cells[:, 0] - x // self.unit) <= reach + 1
        chosen = self.cells[near]
        self.odd = self._link_bits(chosen[:, :1], chosen[:, 1:], self.offsets[:, 0], self.offsets[:, 1])
        some = self.odd.any(axis=1)
        self.odd = self.odd[some]
        self.slot: Ints = np.full(len(rows), -1, np.int64)
        self.slot[np.nonzero(near)[0][some]] = np.arange(int(np.count_nonzero(some)))
        self.plain = len(rows) * len(offsets) // 2 <= _SMALL

    def arrays(self) -> tuple[Any, ...]:
        """What the searches read; lists where plain Python reads them."""
        arrays = (self.number, self.place, self.steps, self.slot, self.odd.ravel())
        return tuple(array.tolist() for array in arrays) if self.plain else arrays

    def is_odd(self, cells: Ints) -> npt.NDArray[np.bool_]:
        """For each cell of a closed chain, whether its link to the next has bit 1."""
        delta = np.roll(cells, -1, axis=0) - cells
        return self._link_bits(cells[:, 0], cells[:, 1], delta[:, 0], delta[:, 1]) > 0

    def _link_bits(self, x: Ints, y: Ints, dx: Ints, dy: Ints) -> npt.NDArray[np.uint8]:
        """The bits of links from cells (x, y) to cells (x + dx, y + dy); the arrays are broadcast."""
        if self.unit > UNIT << _FINE_BITS:  # products of coordinates need more than 64 bits
            x, y, dx, dy = (array.astype(object) for array in (x, y, dx, dy))
        unit, half = self.unit, self.unit // 2
        ax, ay = unit * x + half, unit * y + half
        dx_, dy_ = ax + unit * dx, ay + unit * dy
        bx, cx = ax + half * np.sign(dx), dx_ - half * np.sign(dx)
        by, cy = ay + half * np.sign(dy), dy_ - half * np.sign(dy)
        together = np.zeros(np.broadcast_shapes(x.shape, dx.shape), np.uint8)
        all_bits = (1 << self.bits) - 1
        for px, py, qx, qy in ((ax, ay, bx, by), (bx, by, cx, cy), (cx, cy, dx_, dy_)):
            for point, bit in zip(self.points, (all_bits, *(1 << k for k in range(self.bits))), strict=True):
                together ^= _crosses(px, py, qx, qy, *point) * np.uint8(bit)
        return together


def rim_cells(solid: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """(height + 2, width + 2) bool: solid cells with a free one among their eight neighbours."""
    wide = np.pad(solid, 2, constant_values=True)
    free = ~wide
    rows = free[:-2] | free[1:-1] | free[2:]
    rim: npt.NDArray[np.bool_] = wide[1:-1, 1:-1] & (rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:])
    return rim


def _fineness(radius: Fraction) -> int:
    """How much finer than 1/1024 cell the unit must be for a rounded clear pose to stay on its side of each link.

    A clear pose is farther from a link than the radius less half its gap.
    """
    widest_sq = math.ceil(4 * radius**2) - 1
    least = (radius**2 - Fraction(widest_sq, 4)) / (2 * radius)
    return int(1 << max(0, math.ceil(1 / (least * UNIT)) - 1).bit_length())


def _crosses(px: Ints, py: Ints, qx: Ints, qy: Ints, sx: int, sy: int) -> npt.NDArray[np.uint8]:
    """1 where segment pq crosses the ray from s upwards; points level with s count as left of it."""
    astride = (px <= sx) != (qx <= sx)
    above = (py - sy) * (qx - px) + (qy - py) * (sx - px)
    crossing: npt.NDArray[np.uint8] = (astride & (np.sign(above) == np.sign(qx - px))).astype(np.uint8)
    return crossing


def _unite(number: Any, place: Any, steps: Any, slot: Any, odd: Any, parent: Any, bit: Any, odd_one: Any) -> None:
    """Unites linked cells; ``odd_one`` is 1 at the root of each set that has a cycle of odd sum.

    ``bit[u]`` is the sum along the tree from u to ``parent[u]``. The same text runs plain and compiled.
    """
    width = len(steps)
    for u in range(len(place)):
        for o in range(width // 2):
            v = number[place[u] + steps[o]]
            if v < 0:
                continue
            total = odd[slot[u] * width + o] if slot[u] >= 0 else 0
            a, b = u, v
            while parent[a] != a:
                bit[a] ^= bit[parent[a]]
                parent[a] = parent[parent[a]]
                total ^= bit[a]
                a = parent[a]
            while parent[b] != b:
                bit[b] ^= bit[parent[b]]
                parent[b] = parent[parent[b]]
                total ^= bit[b]
                b = parent[b]
            if a != b:
                if a > b:
                    a, b = b, a
                parent[b] = a
                bit[b] = total
                odd_one[a] |= odd_one[b]
            elif total == 1:
                odd_one[a] = 1


def _roots(parent: Ints) -> Ints:
    while True:
        further = parent[parent]
        if np.array_equal(further, parent):
            return parent
        parent = further


def _short_cycle(links: _Links, has_odd: npt.NDArray[np.bool_]) -> list[Cell] | None:
    """The shortest odd cycle through one of a few cells at the rays."""
    sources = np.nonzero(has_odd & (links.slot >= 0))[0]
    x, y = (UNIT * links.cells[sources] + UNIT // 2).T
    near = [(x - px * UNIT // links.unit) ** 2 + (y - py * UNIT // links.unit) ** 2 for px, py in links.points]
    sources = sources[np.argsort(np.min(near, axis=0), kind="stable")]
    few = np.unique(np.linspace(0, len(sources) - 1, _STARTS).astype(np.int64))
    chosen = sources[few] if links.bits == 1 else np.concatenate([sources[few], np.delete(sources, few)])
    bits, all_odd = links.bits, (1 << links.bits) - 1
    size = len(links.cells) << bits
    graph: Any = links.arrays()
    work = _WORK if links.plain else 200 * _WORK
    search: Any = _odd_cycle if links.plain else _odd_cycle_compiled
    best: list[int] = []
    for source in chosen.tolist():
        before: Any = [-1] * size if links.plain else np.full(size, -1, np.int64)
        order: Any = [0] * size if links.plain else np.zeros(size, np.int64)
        looked = int(search(*graph, bits, source, len(best) or size, before, order))
        state, chain = (source << bits) + all_odd, list[int]()
        while before[state] >= 0 and (state != source << bits or not chain):
            chain.append(state >> bits)
            state = int(before[state])
        if chain and (not best or len(chain) < len(best)):
            best = chain
        work -= looked
        if work < 0 and (best or bits > 1):
            break
    if bits > 1:
        return [tuple(cell) for cell in links.cells[best].tolist()] or None
    return _simple(links, best)


def _odd_cycle(
    number: Any,
    place: Any,
    steps: Any,
    slot: Any,
    odd: Any,
    bits: Any,
    source: Any,
    limit: Any,
    before: Any,
    order: Any,
) -> Any:
    """Breadth-first search from (source, no bit) to (source, all bits), below ``limit`` links.

    ``before[state]`` is the state before it. Returns the number of links looked at.
    """
    width, full = len(steps), (1 << bits) - 1
    order[0] = source << bits
    before[source << bits] = source << bits
    head, tail, level_end, depth, looked = 0, 1, 1, 0, 0
    while head < tail:
        if head == level_end:
            depth += 1
            level_end = tail
            if depth + 1 >= limit:
                return looked
        state = order[head]
        head += 1
        u = state >> bits
        for o in range(width):
            v = number[place[u] + steps[o]]
            if v < 0:
                continue
            looked += 1
            total = odd[slot[u] * width + o] if slot[u] >= 0 else 0
            other = (v << bits) + ((state & full) ^ total)
            if before[other] < 0:
                before[other] = state
                if other == (source << bits) + full:
                    return looked
                order[tail] = other
                tail += 1
    return looked


def _simple(links: _Links, chain: Sequence[int]) -> list[Cell]:
    """Splits a closed chain at cells that it visits twice, and keeps an odd part each time."""
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


_unite_compiled = lazy_kernel(_unite)
_odd_cycle_compiled = lazy_kernel(_odd_cycle)
