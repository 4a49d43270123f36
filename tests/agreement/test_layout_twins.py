"""The core draws the worlds of layout bytes, and floods them, like the specification."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from sim.runners.core_calls import near_masks
from tests.helpers.layouts import draw
from tests.reference.fuzz.layouts import MARGIN, ROWS, draw_layout, fill_arena, flood_length

LAYOUT = st.binary(min_size=LAYOUT_BYTES, max_size=LAYOUT_BYTES)


@given(LAYOUT)
def test_a_drawn_layout_has_the_cells_of_its_world(data):
    walls = decode_world(data).walls.astype(np.uint8)
    drawn = draw(data)
    assert (drawn.cells == walls).all() and drawn.solid == walls.sum()
    assert (drawn.near == near_masks(np.ascontiguousarray(walls))).all() and not drawn.visited.any()


@given(LAYOUT)
@settings(max_examples=20)
def test_a_layout_is_drawn_and_flooded_as_specified(data):
    layouts = np.frombuffer(data, np.uint8)[None, :]
    solid = np.zeros(ROWS, np.int64)
    draw_layout(layouts, 0, solid)
    drawn = draw(data)
    cells = np.zeros_like(drawn.cells)
    near = np.zeros_like(drawn.near)
    assert fill_arena(solid, cells, near) == drawn.solid
    assert cells.tolist() == drawn.cells.tolist() and near.tolist() == drawn.near.tolist()
    length = flood_length(layouts, 0, solid, np.zeros((3, ROWS), np.int64))
    assert drawn.distance == (length + 2 if length >= 0 else -1)


@given(LAYOUT)
def test_the_flood_counts_steps_between_corners_of_four_free_cells(data):
    walls = np.pad(decode_world(data).walls, MARGIN, constant_values=True)
    clear = ~(walls[1:, 1:] | walls[:-1, 1:] | walls[1:, :-1] | walls[:-1, :-1])
    world = decode_world(data)
    (sx, sy), (tx, ty) = (
        (int(p.x * 10) + MARGIN - 1, int(p.y * 10) + MARGIN - 1)
        for p in (world.start, world.target)
    )
    reached, goal, steps = np.zeros_like(clear), np.zeros_like(clear), 0
    reached[sy : sy + 2, sx : sx + 2] = goal[ty : ty + 2, tx : tx + 2] = True
    while not (reached & goal).any():
        wider = np.pad(reached, 1)
        more = (
            wider[2:, 1:-1] | wider[:-2, 1:-1] | wider[1:-1, 2:] | wider[1:-1, :-2] | reached
        ) & clear
        if (more == reached).all():
            steps = -1
            break
        reached, steps = more, steps + 1
    assert draw(data).distance == (steps + 2 if steps >= 0 else -1)
