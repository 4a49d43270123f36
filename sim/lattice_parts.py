"""Single parts of a step on the lattice, as the C core has them: for tests, benchmarks, and whoever needs one alone."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.lattice_core import MOST_CORNERS, grid_of
from worldgen.ccall import writable

__all__ = ["MOST_CORNERS", "pose_is_clear", "segment_first_not_clear", "swept_move"]

Cells = npt.NDArray[np.uint8]
Chain = npt.NDArray[np.int64]


def pose_is_clear(cells: Cells, state: int, clear_sq: int, reach: int, x: int, y: int) -> bool:
    """Return True if the disc at (x, y) is clear of every cell in ``state``; cells outside the grid are solid.

    Args:
        cells: (height, width) cell states.
        state: Which cells count.
        clear_sq: Squared clear distance, lattice units squared.
        reach: Its root, rounded up.
        x: Lattice units.
        y: Lattice units.
    """
    return bool(lib.wg_disc_is_clear(grid_of(cells), state, {"clear_sq": clear_sq, "reach": reach}, x, y))


def segment_first_not_clear(
    cells: Cells, state: int, clear_sq: int, reach: int, ends: tuple[int, int, int, int]
) -> tuple[bool, int, int]:
    """Return the first cell in ``state``, in order of rows, that the disc swept along a segment cuts.

    Args:
        cells: (height, width) cell states.
        state: Which cells count.
        clear_sq: Squared clear distance, lattice units squared.
        reach: Its root, rounded up.
        ends: px, py, qx, qy; p is taken as clear.

    Returns:
        Whether a cell is cut, and its ix and iy.
    """
    found = lib.wg_first_not_clear(grid_of(cells), state, {"clear_sq": clear_sq, "reach": reach}, ends)
    return bool(found.found), int(found.ix), int(found.iy)


def swept_move(
    cells: Cells,
    clear_sq: int,
    reach: int,
    ends: tuple[int, int, int, int],
    during: tuple[float, float],
    wall_friction: float,
    chain: Chain,
    count: int,
) -> tuple[int, float, float]:
    """Move a disc, stopping at walls and sliding along them.

    Args:
        cells: (height, width) cell states.
        clear_sq: Squared clear distance, lattice units squared.
        reach: Its root, rounded up.
        ends: Start, a clear lattice pose, and displacement, lattice units: x, y, dx, dy.
        during: When the move begins and ends, in shares of the step.
        wall_friction: Share of a slide that the wall takes, 0 to 1.
        chain: (n, 3) int64; rows x, y, time in the step are filled with the clear lattice points of the path
            after the start.
        count: Rows that are already filled; at most ``MOST_CORNERS`` follow.

    Returns:
        Rows filled then, and the normal of the last contact (0, 0: none).

    Raises:
        ValueError: If the chain has too few rows.
    """
    if len(chain) < count + MOST_CORNERS:
        raise ValueError(f"a chain of {len(chain)} rows has no room for {MOST_CORNERS} corners after {count}")
    x, y, dx, dy = ends
    corners = ffi.cast("WgCorner *", writable(ffi, chain, np.int64))
    disc = {"clear_sq": clear_sq, "reach": reach}
    way = (x, y, x + dx, y + dy)
    moved = lib.wg_swept_move(grid_of(cells), disc, way, *during, wall_friction, corners, count)
    return int(moved.count), float(moved.contact.x), float(moved.contact.y)
