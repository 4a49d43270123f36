"""Find the largest disc that can get from start to target, without trying disc after disc.

A disc is stopped by a closed chain of cells, with gaps below its diameter, that separates start
from target (docs/explanation/reachability.md). So the gaps are processed from narrow to wide,
uniting the cells on both sides; the first gap that closes such a chain is the bottleneck between
two poses. In addition, start and target must have room for the disc.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from worldgen import _core
from worldgen.lattice import UNIT, exact, in_cells
from worldgen.reach import REACHABLE, decide
from worldgen.reach.still.cut import find_chain, rim_cells
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.target_poses import deciding_poses
from worldgen.reach.still.walls import Walls
from worldgen.support.arrays import Bools, Bytes, Ints
from worldgen.support.ccall import check, pointer, writable
from worldgen.timeline import Timeline
from worldgen.world import World

# Relative precision of the radius where a pose next to the target's centre may take a larger disc.
_CLOSE = 1e-7
# Cells: if the target's centre cannot be reached, smaller discs are not tried.
_LEAST = 1 / 64


def bottleneck(world: World, solid: Bools) -> float:
    """Return the radius, m, of the largest disc that gets from the start to the target.

    It is 0 if no disc of 1/64 cell or more does.

    Args:
        world: Start, target and lengths.
        solid: (height, width) bool, the solid cells.
    """
    walls = Walls(solid, Fraction(1))
    disc = target_disc(world)
    start = (
        in_cells(world.start.x, world.cell_size) * UNIT,
        in_cells(world.start.y, world.cell_size) * UNIT,
    )
    at_start = math.sqrt(walls.nearest(start)[1]) / UNIT
    centre = (disc.x, disc.y)
    at_target = math.sqrt(walls.nearest(centre)[1]) / UNIT
    least = min(at_start, at_target)
    gap_sq = narrowest_gap_sq(solid, start, centre, math.ceil(4 * least * least)) if least else 0
    between = math.inf if gap_sq is None else math.sqrt(gap_sq) / 2
    sure = min(least, between)
    reach = float(disc.radius) / UNIT
    highest = min(at_start, at_target + reach)
    if sure < highest and not (between == sure and at_target - reach > between):
        # A larger disc may reach a pose of the target's disc other than its centre.
        sure = _halved(world, solid, sure, highest)
    return sure * float(exact(world.cell_size))


def _halved(world: World, solid: Bools, low: float, high: float) -> float:
    """Return the largest radius, cells, between two bounds; ``low`` if nothing larger passes."""
    question = _DiscQuery(world, solid)
    if not question.passes(max(low * (1 + _CLOSE), _LEAST)):
        return low
    if question.passes(high):
        return high
    while high - low > _CLOSE * high:
        middle = (low + high) / 2
        low, high = (middle, high) if question.passes(middle) else (low, middle)
    return low


class _DiscQuery:
    """Answers, one radius after another, whether a disc that fits at the start reaches the target.

    It searches for no path: a pose that no chain separates from the start can be reached
    (docs/explanation/reachability.md).
    """

    def __init__(self, world: World, solid: Bools) -> None:
        self.world = world
        self.solid = solid
        self.disc = target_disc(world)
        self.start = tuple(
            in_cells(value, world.cell_size) * UNIT for value in (world.start.x, world.start.y)
        )

    def passes(self, radius: float) -> bool:
        """Return True if a disc of this radius, in cells, gets to the target."""
        # The disc must fit at the start.
        exactly = Fraction(radius)
        start = (self.start[0], self.start[1])
        if radius <= 0.0:
            return False
        walls = Walls(self.solid, exactly)
        if not walls.is_clear(start, start):
            return False
        # Look for a pose of the target that no chain separates from the start.
        poses = deciding_poses(walls, self.disc)
        # Thousands of corners can be near a large target.
        if poses is None:
            still = replace(self.world, walls=self.solid, timeline=Timeline(), certificate=None)
            metres = radius * self.world.cell_size
            return decide(still, radius=metres, certificate=False).result == REACHABLE
        chains: list[Ints] = []
        index = 0
        while index < len(poses):
            unparted = max(
                (poses.first_unparted(chain, start, index) for chain in chains), default=index
            )
            if unparted > index:
                index = unparted
                continue
            found = find_chain(self.solid, exactly, start, [poses[index]])
            if found is None:
                return True
            chains.append(found)
            index += 1
        return False


def narrowest_gap_sq(solid: Bools, start: Any, target: Any, below: int) -> int | None:
    """Return the squared width, cells, of the narrowest gap that closes a chain between two poses.

    Return None if it is ``below`` or more.

    Args:
        solid: (height, width) bool.
        start: A pose outside the cells, 1/1024 cell.
        target: Another such pose.
        below: Limit on the squared widths of interest.
    """
    cells, number, stride, pad = _rim(solid, below)
    ffi = _core.ffi
    lib = _core.lib
    parent = np.arange(len(cells), dtype=np.int64)
    bit = np.zeros(len(cells), np.uint8)
    tree = (writable(ffi, parent, np.int64), writable(ffi, bit, np.uint8), len(cells))
    closed = ffi.new("int64_t *")
    place = cells[:, 1] * stride + cells[:, 0]
    rays = [(pose, _below_ray(cells, pad, pose)) for pose in (start, target)]
    odd = np.zeros(len(cells), np.uint8)
    for gap_sq, offsets in _by_gap(below):
        for dx, dy in offsets:
            other = number[place + (dy * stride + dx)]
            near = np.flatnonzero(other >= 0)

            # Only links near the rays upwards from the two poses can cross them, and few cells are
            # near them.
            for pose, close in rays:
                odd[close] ^= _crosses(cells[close] - pad, dx, dy, pose)
            crossing = odd[near]
            for _, close in rays:
                odd[close] = 0
            ends = (pointer(ffi, near, np.int64), pointer(ffi, other[near], np.int64))
            check(lib.wg_unite(*ends, pointer(ffi, crossing, np.uint8), len(near), *tree, closed))
            if closed[0]:
                return gap_sq
    return None


def _rim(solid: Bools, below: int) -> tuple[Ints, Ints, int, int]:
    """Return solid cells next to free ones, a table of their numbers, its stride and the padding.

    The cells are (n, 2), column and row in the padded grid, whose places index the table.
    """
    pad = math.isqrt(max(below - 1, 0)) + 2
    rim = np.pad(rim_cells(solid), pad - 1)
    rows, columns = np.nonzero(rim)
    number = np.full(rim.size, -1, np.int64)
    number[rows * rim.shape[1] + columns] = np.arange(len(rows))
    return np.stack((columns, rows), axis=1), number, int(rim.shape[1]), pad


def _by_gap(below: int) -> Iterator[tuple[int, list[tuple[int, int]]]]:
    """Yield the offsets between two cells by their squared gap, narrowest first, each pair once."""
    found: dict[int, list[tuple[int, int]]] = {}
    reach = math.isqrt(max(below - 1, 0)) + 1
    for dy in range(reach + 1):
        for dx in range(-reach, reach + 1):
            gap_sq = max(abs(dx) - 1, 0) ** 2 + max(dy - 1, 0) ** 2
            if gap_sq < below and (dy > 0 or dx > 0):
                found.setdefault(gap_sq, []).append((dx, dy))
    yield from sorted(found.items())


def _below_ray(cells: Ints, pad: int, pose: Any) -> Ints:
    """Return indices of cells that one of their links can join across the ray above a pose."""
    column = math.floor(Fraction(pose[0]) / UNIT) + pad
    return np.flatnonzero(np.abs(cells[:, 0] - column) <= pad + 1)


def _crosses(cells: Ints, dx: int, dy: int, pose: Any) -> Bytes:
    """Return, per cell, if its link at an offset crosses the ray upwards an odd number of times."""
    # Find a unit in which all coordinates are integers.
    fine = math.lcm(*(Fraction(value).denominator for value in pose))
    unit = UNIT * fine
    half = UNIT * fine // 2
    px, py = (int(value * fine) for value in pose)
    # Only cells near the ray's column can have links that cross it.
    close = np.flatnonzero(
        (cells[:, 0] + max(dx, 0) >= px // unit - 1) & (cells[:, 0] + min(dx, 0) <= px // unit + 1)
    )
    found = np.zeros(len(cells), np.uint8)
    chosen = cells[close].astype(object if unit > UNIT else np.int64)
    ax = unit * chosen[:, 0] + half
    ay = unit * chosen[:, 1] + half
    sx = (dx > 0) - (dx < 0)
    sy = (dy > 0) - (dy < 0)
    # Count the crossings of the link's three pieces.
    corners = [
        (0, 0),
        (half * sx, half * sy),
        (unit * dx - half * sx, unit * dy - half * sy),
        (unit * dx, unit * dy),
    ]
    for (fx, fy), (gx, gy) in itertools.pairwise(corners):
        qx = ax + fx
        qy = ay + fy
        ex = gx - fx
        ey = gy - fy
        astride = (qx <= px) != (qx + ex <= px)
        above = (qy - py) * ex + ey * (px - qx)
        found[close] ^= (astride & ((above > 0) == (ex > 0)) & (above != 0)).astype(np.uint8)
    return found
