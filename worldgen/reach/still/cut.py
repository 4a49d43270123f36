"""Find a cut: a closed chain of solid cells, gaps below 2 r, around either the start or the target.

Two cells are linked if their gap is below 2 r. Each link carries a bit: 1 if its line (centre,
closest point, closest point, centre) crosses the ray upwards from the start, xor the same for the
target. A cycle whose bits add up to an odd number separates start from target, and one exists
exactly if the two are in different components of the clear poses
(docs/notes/reachability.md). A breadth-first search over (cell, bit) in C decides whether
there is one, and then finds a short one.

Several targets get a bit each; then only a cycle with all bits odd separates the start from them
all.

Poses are whole numbers of 1/1024 cell, or of a finer unit if a target is not a multiple of that and
a link passes close to it, so every crossing is decided exactly.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT
from worldgen.reach.still.walls import ExactPoint, described_walls
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, writable

MOST_TARGETS = 6
"""Limit on the poses that one search handles."""

# Steps between two checks for Ctrl-C.
_PORTION = 20_000_000
# Number of doublings from 1/1024 cell to half a cell.
_HALF_BITS = 9
_LIMB_BITS = 32


def find_chain(
    solid: Bools, radius: Fraction, start: ExactPoint, targets: Sequence[ExactPoint]
) -> Ints | None:
    """Return a chain of cells that separates one clear pose from others, or None if there is none.

    Args:
        solid: (height, width) bool, the solid cells.
        radius: Radius of the disc, cells.
        start: A clear pose, 1/1024 cell.
        targets: One other pose, or up to :data:`MOST_TARGETS`, each of which can be separated from
            the start.

    Returns:
        (n, 2) cells ix, iy in chain order; -1 and the grid's sides stand for cells just outside.
    """
    whole, limbs, rest = _digits(radius, (start, *targets))
    walls = described_walls(solid)
    made = ffi.new("WgCutSearch **")
    progress = ffi.new("WgProgress *")
    check(lib.wg_cut_search_new(walls, link_limit(radius), len(targets), whole, limbs, rest, made))
    try:
        while True:
            check(lib.wg_cut_search_advance(made[0], _PORTION, progress))
            if progress[0] != lib.WG_GOING:
                break
        if progress[0] != lib.WG_FOUND:
            return None
        cells = np.empty((lib.wg_cut_length(made[0]), 2), np.int64)
        lib.wg_cut_cells(made[0], writable(ffi, cells, np.int64))
    finally:
        lib.wg_cut_search_free(made[0])
    return cells


def _digits(radius: Fraction, points: Sequence[ExactPoint]) -> tuple[list[int], int, list[int]]:
    """Return points in half cells, rounded down.

    Also return the number of digits cut off, and these digits.
    """
    values = [value for point in points for value in point]
    finer = 0 if all(value == int(value) for value in values) else refinement(radius)
    bits = _HALF_BITS + finer
    limbs = -(-bits // _LIMB_BITS)
    whole = []
    rest = []
    for value in values:
        units = round(value * (1 << finer))
        whole.append(units >> bits)
        left = (units & ((1 << bits) - 1)) << (limbs * _LIMB_BITS - bits)
        rest += [left >> (_LIMB_BITS * place) & 0xFFFFFFFF for place in reversed(range(limbs))]
    return whole, limbs, rest


@functools.lru_cache(maxsize=256)
def link_limit(radius: Fraction) -> int:
    """Return the smallest squared gap, an integer, in cells, that a disc fits through."""
    return math.ceil((2 * radius) ** 2)


@functools.lru_cache(maxsize=256)
def refinement(radius: Fraction) -> int:
    """Return how often to halve 1/1024 cell so that a rounded pose stays on its side of each link.

    A clear pose is farther from a link than the radius minus half its gap.
    """
    widest_sq = link_limit(radius) - 1
    least = (radius**2 - Fraction(widest_sq, 4)) / (2 * radius)
    return max(0, math.ceil(1 / (least * UNIT)) - 1).bit_length()


def rim_cells(solid: Bools) -> Bools:
    """Return a (height + 2, width + 2) bool array: solid cells with a free one next to them."""
    wide = np.pad(solid, 2, constant_values=True)
    free = ~wide
    rows = free[:-2] | free[1:-1] | free[2:]
    rim: Bools = wide[1:-1, 1:-1] & (rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:])
    return rim
