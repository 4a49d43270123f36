"""Parts of a step of the simulator's core, as functions of arrays and numbers: what ``wg_parts.h`` declares."""

from typing import Any

import numpy as np

from sim._core import ffi, lib
from sim.lattice_core import Arena, beam_tables, grid_of, headings
from sim.lattice_parts import pose_is_clear, segment_first_not_clear, swept_move  # noqa: F401 - as the others
from worldgen.ccall import pointer, writable


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
    moved = lib.wg_endpoint_move(grid_of(cells), (clear_sq, reach), (x, y, x + dx, y + dy), _chain_of(chain), count)
    return moved.count, moved.contact.x, moved.contact.y


def ray_distance(cells, table, x, y, heading, longest):
    return lib.wg_ray_distance(grid_of(cells), pointer(ffi, table, np.int64), x, y, heading, longest)


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
    """Return what beams measure that look up how far cells are free, lattice units."""
    settings = ffi.new("WgSettings *", {"beams": beams, "beam_field": field, "beam_range": longest, "metres": 1.0})
    settings.senses = lib.WG_SENSE_BEAMS
    near, nothing = np.zeros(cells.shape, np.int32), np.zeros((0, 0), np.int32)
    events, visited = np.zeros((0, 5), np.int64), np.zeros_like(cells)
    arena = Arena(cells, near, nothing, events, visited, beam_tables(cells, settings))
    state = ffi.new("WgState *", pose)
    found = np.zeros(beams)
    observation, odometry = ffi.new("WgObservation *"), ffi.new("WgOdometry *")
    out = writable(ffi, found, np.float64)
    lib.wg_sense_at(arena.c, settings, state, odometry, (0.0, 0.0), 0, observation, out)
    return found.tolist()


def trigonometry(x):
    """Return fdlibm's sine, cosine and arc tangent of a number."""
    of, found = np.array([x], np.float64), np.zeros((3, 1))
    parts = [writable(ffi, row, np.float64) for row in found]
    lib.wg_trigonometry(pointer(ffi, of, np.float64), 1, *parts)
    return tuple(found[:, 0].tolist())


def sin(x):
    return trigonometry(x)[0]


def cos(x):
    return trigonometry(x)[1]


def atan(x):
    return trigonometry(x)[2]
