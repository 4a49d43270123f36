"""Parts of a step of the simulator's core, as functions of arrays and numbers.

What ``wg_parts.h`` declares.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.runners.core_calls import MOST_CORNERS, CoreArena, beam_tables, grid_of, headings
from worldgen.support.ccall import pointer, writable

Cells = npt.NDArray[np.uint8]
Chain = npt.NDArray[np.int64]


def pose_is_clear(cells: Cells, state: int, clear_sq: int, reach: int, x: int, y: int) -> bool:
    """Return True if the disc at (x, y) is clear of every cell in ``state``.

    Cells outside the grid are solid.

    Args:
        cells: (height, width) cell states.
        state: Which cells count.
        clear_sq: Squared clear distance, lattice units squared.
        reach: Its root, rounded up.
        x: Lattice units.
        y: Lattice units.
    """
    return bool(
        lib.wg_disc_is_clear(grid_of(cells), state, {"clear_sq": clear_sq, "reach": reach}, x, y)
    )


def segment_first_not_clear(
    cells: Cells, state: int, clear_sq: int, reach: int, ends: tuple[int, int, int, int]
) -> tuple[bool, int, int]:
    """Return the first cell in ``state``, in row order, that the disc swept along a segment cuts.

    Args:
        cells: (height, width) cell states.
        state: Which cells count.
        clear_sq: Squared clear distance, lattice units squared.
        reach: Its root, rounded up.
        ends: px, py, qx, qy; p is taken as clear.

    Returns:
        Whether a cell is cut, and its ix and iy.
    """
    found = lib.wg_first_not_clear(
        grid_of(cells), state, {"clear_sq": clear_sq, "reach": reach}, ends
    )
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
        during: When the move begins and ends, as fractions of the step.
        wall_friction: Fraction of a slide that is lost to the wall, 0 to 1.
        chain: (n, 3) int64; rows x, y, time in the step are filled with the clear lattice points of
            the path after the start.
        count: Rows that are already filled; at most ``MOST_CORNERS`` follow.

    Returns:
        The number of filled rows, and the normal of the last contact (0, 0: none).

    Raises:
        ValueError: If the chain has too few rows.
    """
    if len(chain) < count + MOST_CORNERS:
        raise ValueError(
            f"a chain of {len(chain)} rows has no room for {MOST_CORNERS} corners after {count}"
        )
    x, y, dx, dy = ends
    corners = ffi.cast("WgCorner *", writable(ffi, chain, np.int64))
    disc = {"clear_sq": clear_sq, "reach": reach}
    way = (x, y, x + dx, y + dy)
    moved = lib.wg_swept_move(grid_of(cells), disc, way, *during, wall_friction, corners, count)
    return int(moved.count), float(moved.contact.x), float(moved.contact.y)


def footprint_of(corners: Sequence[tuple[int, int]]) -> Any:
    """Return a WgFootprint with corners in lattice units, counter-clockwise."""
    footprint = ffi.new("WgFootprint *")
    footprint.count = len(corners)
    for k, (x, y) in enumerate(corners):
        footprint.x[k] = x
        footprint.y[k] = y
    return footprint


def _table() -> Any:
    return pointer(ffi, headings(), np.int64)


def body_is_clear(cells: Cells, footprint: Any, x: int, y: int, heading: int) -> bool:
    """Return True if a body at a pose is clear of every solid cell."""
    return bool(lib.wg_body_is_clear(grid_of(cells), 1, _table(), footprint, x, y, heading))


def body_first_not_clear(
    cells: Cells, footprint: Any, ends: tuple[int, int, int, int], heading: int
) -> tuple[bool, int, int]:
    """Return the first solid cell that a body cuts on its way from p to q."""
    found = lib.wg_body_first_not_clear(grid_of(cells), 1, _table(), footprint, ends, heading)
    return bool(found.found), int(found.ix), int(found.iy)


def clear_turn(cells: Cells, footprint: Any, pose: tuple[int, int, int], turn: int) -> int:
    """Return how far a body turns before a solid cell stops it, heading units."""
    stopped = ffi.new("WgStopped *")
    return int(lib.wg_clear_turn(grid_of(cells), 1, _table(), footprint, *pose, turn, stopped))


def swept_body_move(
    cells: Cells, footprint: Any, heading: int, ends: tuple[int, int, int, int], chain: Chain
) -> tuple[int, float, float]:
    """Move a body by a displacement; arguments and result as for :func:`swept_move`."""
    x, y, dx, dy = ends
    moved = lib.wg_swept_body_move(
        grid_of(cells),
        _table(),
        footprint,
        heading,
        (x, y, x + dx, y + dy),
        0.0,
        1.0,
        0.0,
        _chain_of(chain),
        0,
    )
    return int(moved.count), float(moved.contact.x), float(moved.contact.y)


def heading_table() -> Any:
    return headings()


def segment_crosses_box(*numbers):
    return lib.wg_segment_crosses_box(numbers[:4], *numbers[4:])


def segment_box_depth(radius, *numbers):
    return lib.wg_segment_box_depth(radius, numbers[:4], *numbers[4:])


def _chain_of(chain):
    return ffi.cast("WgCorner *", writable(ffi, chain, np.int64))


def endpoint_move(cells, clear_sq, reach, ends, chain, count):
    x, y, dx, dy = ends
    moved = lib.wg_endpoint_move(
        grid_of(cells), (clear_sq, reach), (x, y, x + dx, y + dy), _chain_of(chain), count
    )
    return moved.count, moved.contact.x, moved.contact.y


def ray_distance(cells, table, x, y, heading, longest):
    return lib.wg_ray_distance(
        grid_of(cells), pointer(ffi, table, np.int64), x, y, heading, longest
    )


def walls_on_the_way(cells, x, y, to_x, to_y):
    return lib.wg_walls_on_the_way(grid_of(cells), x, y, to_x, to_y)


def smoke_on_the_way(cells, x, y, to_x, to_y, reach):
    return lib.wg_smoke_on_the_way(grid_of(cells), x, y, to_x, to_y, reach)


beam_heading = lib.wg_heading_of_beam
heading_of = lib.wg_heading_of


def signal_heading(cells, x, y, target_x, target_y, heading):
    return lib.wg_signal_heading(grid_of(cells), x, y, target_x, target_y, heading)


def displacement(table, heading, distance):
    by = lib.wg_drive_displacement(pointer(ffi, table, np.int64), heading, distance)
    return by.x, by.y


def random_draw(seed, index):
    return lib.wg_draw_of_stream(seed % 2**64, index)


def near_masks(cells, near):
    lib.wg_near_masks(grid_of(cells), writable(ffi, near, np.int32))


def chessboard_clearance(cells, clearance):
    lib.wg_chessboard_clearance(grid_of(cells), writable(ffi, clearance, np.int32))


def mark_near(cells, near, ix, iy):
    lib.wg_mark_near(grid_of(cells), writable(ffi, near, np.int32), ix, iy)


def window_is_free(near, reach, ends):
    arena = ffi.new("WgArena *", {"height": near.shape[0], "width": near.shape[1]})
    arena.near = writable(ffi, near, np.int32)
    return lib.wg_box_of_path_is_free(arena, reach, ends)


def beams_with_tables(cells, pose, beams, field, longest):
    """Return what beams measure when they use the table of free distances, lattice units."""
    settings = ffi.new(
        "WgSettings *", {"beams": beams, "beam_field": field, "beam_range": longest, "metres": 1.0}
    )
    settings.senses = lib.WG_SENSE_BEAMS
    near = np.zeros(cells.shape, np.int32)
    nothing = np.zeros((0, 0), np.int32)
    events = np.zeros((0, 5), np.int64)
    visited = np.zeros_like(cells)
    arena = CoreArena(cells, near, nothing, events, visited, beam_tables(cells, settings))
    state = ffi.new("WgState *", pose)
    found = np.zeros(beams)
    observation = ffi.new("WgObservation *")
    odometry = ffi.new("WgOdometry *")
    out = writable(ffi, found, np.float64)
    lib.wg_sense_at(arena.c, settings, state, odometry, (0.0, 0.0), 0, observation, out)
    return found.tolist()


def trigonometry(x):
    """Return fdlibm's sine, cosine and arc tangent of a number."""
    of = np.array([x], np.float64)
    found = np.zeros((3, 1))
    parts = [writable(ffi, row, np.float64) for row in found]
    lib.wg_trigonometry(pointer(ffi, of, np.float64), 1, *parts)
    return tuple(found[:, 0].tolist())


def sin(x):
    return trigonometry(x)[0]


def cos(x):
    return trigonometry(x)[1]


def atan(x):
    return trigonometry(x)[2]
