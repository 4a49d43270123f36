"""Kernels that draw layouts agree with the Python that they were compiled from, and with the worlds of the bytes."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzz.features import LAYOUT_BYTES, decode_world
from fuzz.kernels.layouts import MARGIN, ROWS, draw_layout, fill_arena, flood_length
from sim.kernels.geometry import near_masks
from sim.kernels.lattice_state import Arena
from tests.helpers.twins import twin

LAYOUT = st.binary(min_size=LAYOUT_BYTES, max_size=LAYOUT_BYTES)


def drawn(data):
    layouts, solid = np.frombuffer(data, np.uint8)[None, :].copy(), np.zeros(ROWS, np.int64)
    draw_layout(layouts, 0, solid)
    return layouts, solid


def arena_for(walls):
    cells, near, table = walls.astype(np.uint8), np.zeros(walls.shape, np.int32), np.zeros((0, 0), np.int32)
    return Arena(cells, near, table, np.zeros((0, 5), np.int64), np.zeros(1, np.int64), np.ones(walls.shape, np.uint8))


@given(LAYOUT)
def test_a_drawn_layout_has_the_cells_of_its_world(data):
    walls, (_, solid) = decode_world(data).walls, drawn(data)
    arena, expected = arena_for(np.zeros_like(walls)), arena_for(walls)
    near_masks(expected.cells, expected.near)
    assert fill_arena(solid, arena) == walls.sum()
    assert (arena.cells == expected.cells).all() and (arena.near == expected.near).all() and not arena.visited.any()


@given(LAYOUT)
@settings(max_examples=20)
def test_layout_kernels_equal_their_python_twins(data):
    layouts, solid = drawn(data)
    plain, rooms = np.zeros(ROWS, np.int64), (np.zeros((3, ROWS), np.int64), np.zeros((3, ROWS), np.int64))
    twin(draw_layout)(layouts, 0, plain)
    assert plain.tolist() == solid.tolist()
    steps = flood_length(layouts, 0, solid, rooms[0])
    assert (steps, rooms[0].tolist()) == (twin(flood_length)(layouts, 0, plain, rooms[1]), rooms[1].tolist())


@given(LAYOUT)
def test_the_flood_counts_steps_between_corners_of_four_free_cells(data):
    layouts, solid = drawn(data)
    walls = np.pad(decode_world(data).walls, MARGIN, constant_values=True)
    clear = ~(walls[1:, 1:] | walls[:-1, 1:] | walls[1:, :-1] | walls[:-1, :-1])
    world = decode_world(data)
    (sx, sy), (tx, ty) = ((int(p.x * 10) + MARGIN - 1, int(p.y * 10) + MARGIN - 1) for p in (world.start, world.target))
    reached, goal, steps = np.zeros_like(clear), np.zeros_like(clear), 0
    reached[sy : sy + 2, sx : sx + 2] = goal[ty : ty + 2, tx : tx + 2] = True
    while not (reached & goal).any():
        wider = np.pad(reached, 1)
        more = (wider[2:, 1:-1] | wider[:-2, 1:-1] | wider[1:-1, 2:] | wider[1:-1, :-2] | reached) & clear
        if (more == reached).all():
            steps = -1
            break
        reached, steps = more, steps + 1
    assert flood_length(layouts, 0, solid, np.zeros((3, ROWS), np.int64)) == steps
