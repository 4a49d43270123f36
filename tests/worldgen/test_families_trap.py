"""Traps: depth, mouth and turn are as requested, and the trap is between start and target."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.difficulty import measure
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.trap import Shape, trap
from worldgen.family import stream_for
from worldgen.generation import generate

SEEDS = st.integers(0, 2**64 - 1)
TURNS = st.integers(0, 3)
SHAPES = st.sampled_from(["U", "L", "spiral"])
FACES = st.sampled_from(["start", "target", "side"])


def layout(seed=0, **params):
    return trap.build(stream_for(seed, "trap", 0), **trap.complete(params))


def obstacle(world, turn):
    """Return the obstacle, cut out of the arena and rotated so that its mouth opens to +x."""
    inside = np.rot90(world.walls[1:-1, 1:-1], turn)  # rows go up, so this is clockwise
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    return inside[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def turned_back(world, point, turn):
    """A point in cells, in the frame in which the mouth opens to +x."""
    x, y = point.x / world.cell_size, point.y / world.cell_size
    for _ in range(turn):
        x, y = y, world.width - x
    return x, y


def box(world, turn):
    """First and last edge of the obstacle in x and in y, in cells, in the same frame."""
    inside = np.rot90(world.walls, turn)[1:-1, 1:-1]
    return [
        (int(k[0]) + 1, int(k[-1]) + 2)
        for k in (np.flatnonzero(inside.any(axis=axis)) for axis in (0, 1))
    ]


def run_lengths(cells):
    """Lengths of the runs of free cells."""
    edges = np.flatnonzero(np.diff(np.concatenate([[1], cells.astype(int), [1]])))
    return (edges[1::2] - edges[::2]).tolist()


def corners(cells):
    """Count the turns of a wall one cell thick."""
    wall = np.pad(cells, 1)
    beside = (np.roll(wall, 1, 1) | np.roll(wall, -1, 1)) & (
        np.roll(wall, 1, 0) | np.roll(wall, -1, 0)
    )
    return int((wall & beside).sum())


@given(SEEDS, st.integers(1, 20), st.integers(2, 20), st.integers(1, 3), TURNS)
def test_a_u_has_the_depth_mouth_thickness_and_turn_asked_for(seed, depth, mouth, thickness, turn):
    world = layout(seed, size=40, depth=depth, mouth=mouth, thickness=thickness, turn=turn)
    expected = np.ones((mouth + 2 * thickness, depth + thickness), bool)
    expected[thickness:-thickness, thickness:] = False
    assert np.array_equal(obstacle(world, turn), expected)


@given(SEEDS, st.integers(1, 20), st.integers(2, 20), st.integers(1, 3), TURNS)
def test_an_l_is_a_u_without_one_arm(seed, depth, mouth, thickness, turn):
    world = layout(
        seed, size=40, shape="L", depth=depth, mouth=mouth, thickness=thickness, turn=turn
    )
    expected = np.ones((mouth + thickness, depth + thickness), bool)
    expected[thickness:, thickness:] = False
    assert any(np.array_equal(obstacle(world, turn), shape) for shape in (expected, expected[::-1]))


@given(SEEDS, st.integers(1, 6), st.integers(2, 5), st.integers(1, 8), TURNS)
def test_a_spiral_winds_as_often_as_asked_for(seed, depth, mouth, turns, turn):
    world = layout(seed, size=80, shape="spiral", depth=depth, mouth=mouth, turns=turns, turn=turn)
    assert corners(obstacle(world, turn)) == 2 + turns  # the U itself has two


@given(SEEDS, st.integers(1, 6), st.integers(2, 5), st.integers(1, 8), TURNS)
def test_a_spiral_opens_to_where_it_was_turned_with_the_mouth_asked_for(
    seed, depth, mouth, turns, turn
):
    world = layout(seed, size=80, shape="spiral", depth=depth, mouth=mouth, turns=turns, turn=turn)
    cells = obstacle(world, turn)
    assert run_lengths(cells[:, -1])[:1] == [mouth] or run_lengths(cells[:, -1])[-1:] == [mouth]
    assert cells[:, 0].all() and cells[0].all() and cells[-1].all()  # closed on the other sides


@given(SEEDS, st.integers(1, 6), st.integers(2, 5), st.integers(1, 8))
def test_a_spiral_is_as_wide_as_its_mouth_all_along(seed, depth, mouth, turns):
    world = layout(seed, size=80, shape="spiral", depth=depth, mouth=mouth, turns=turns, turn=0)
    cells = obstacle(world, 0)
    inner = [length for rows in (cells, cells.T) for row in rows for length in run_lengths(row)]
    assert min(inner) >= min(mouth, depth)


@given(SEEDS, SHAPES, TURNS, st.booleans())
def test_the_mouth_faces_the_start_and_the_target_is_behind(seed, shape, turn, inside):
    world = layout(seed, size=40, shape=shape, turn=turn, inside=inside)
    (x0, x1), (y0, y1) = box(world, turn)
    start, target = (turned_back(world, point, turn) for point in (world.start, world.target))
    assert target[0] < x0 and y0 < target[1] < y1
    assert (x0 < start[0] < x1) if inside else (start[0] > x1)
    assert y0 < start[1] < y1


@pytest.mark.gate
@given(seed=SEEDS, shape=st.sampled_from(get_args(Shape)))
def test_behind_the_mouth_the_signal_has_a_local_maximum(seed, shape):
    assert measure(generate("trap", seed, shape=shape)).concavity > 0


@given(SEEDS, SHAPES, TURNS)
def test_the_mouth_can_face_the_target(seed, shape, turn):
    world = layout(seed, size=40, shape=shape, turn=turn, faces="target")
    (x0, x1), _ = box(world, turn)
    assert turned_back(world, world.start, turn)[0] < x0
    assert turned_back(world, world.target, turn)[0] > x1


@given(SEEDS, SHAPES, TURNS)
def test_the_mouth_can_face_aside(seed, shape, turn):
    world = layout(seed, size=40, shape=shape, turn=turn, faces="side")
    _, (y0, y1) = box(world, turn)
    ends = sorted(turned_back(world, point, turn)[1] for point in (world.start, world.target))
    assert ends[0] < y0 and ends[1] > y1


@given(SEEDS, SHAPES, FACES, st.booleans(), st.sampled_from([0.02, 0.07, 0.2]))
def test_the_obstacle_bars_the_straight_way(seed, shape, faces, inside, robot_radius):
    assume(not (inside and faces == "target"))
    world = layout(seed, shape=shape, faces=faces, inside=inside, robot_radius=robot_radius)
    steps = np.linspace(0.0, 1.0, 4000)
    x = world.start.x + steps * (world.target.x - world.start.x)
    y = world.start.y + steps * (world.target.y - world.start.y)
    assert world.walls[(y / 0.1).astype(int), (x / 0.1).astype(int)].any()


@given(SEEDS, SHAPES, FACES)
def test_gaps_to_the_border_are_closed_or_let_the_robot_through(seed, shape, faces):
    world = layout(seed, size=16, shape=shape, faces=faces)
    for low, high in box(world, 0):
        assert low - 1 != 1 and world.width - 1 - high != 1  # the robot needs two cells


def test_turn_left_out_is_drawn():
    headings = {round(layout(seed).start.heading, 3) for seed in range(40)}
    assert headings == {0.0, 1.571, 3.142, -1.571}


def test_depth_and_mouth_left_out_are_drawn():
    shapes = {obstacle(layout(seed, turn=0), 0).shape for seed in range(40)}
    assert len(shapes) > 20


@pytest.mark.parametrize("shape", ["U", "L", "spiral"])
def test_a_small_square_has_room_for_every_shape(shape):
    for seed in range(10):
        assert generate("trap", seed, size=10, shape=shape).walls.shape == (10, 10)


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"depth": 0}, {"code": "below-minimum", "name": "depth", "low": 1}),
        (
            {"depth": 1, "inside": True},
            {"code": "below-minimum", "name": "depth", "value": 1, "low": 2},
        ),
        (
            {"depth": 3, "faces": "side", "robot_radius": 0.25},
            {"code": "below-minimum", "name": "depth", "value": 3, "low": 4},
        ),
        ({"inside": True, "faces": "target"}, {"code": "no-effect"}),
        ({"mouth": 1}, {"code": "narrower-than-robot", "name": "mouth", "width": 1}),
        ({"thickness": 0}, {"code": "below-minimum", "name": "thickness", "low": 1}),
        ({"turn": 4}, {"code": "out-of-range", "name": "turn", "value": 4, "high": 3}),
        ({"turn": -2}, {"code": "out-of-range", "name": "turn", "value": -2, "high": 3}),
        ({"turns": 2}, {"code": "no-effect", "name": "turns", "value": 2, "setting": "shape=U"}),
        ({"turns": 0, "shape": "spiral"}, {"code": "below-minimum", "name": "turns", "low": 1}),
        (
            {"turns": 20, "shape": "spiral"},
            {"code": "no-room", "size": 30, "shape": "spiral", "turns": 20},
        ),
        ({"depth": 24}, {"code": "no-room", "size": 30, "shape": "U", "mouth": 2}),
        ({"mouth": 27}, {"code": "no-room", "depth": 2}),
        ({"mouth": 2**40}, {"code": "no-room", "size": 30, "shape": "U"}),
        (
            {"turns": 2**40, "shape": "spiral"},
            {"code": "out-of-range", "name": "turns", "low": 1, "high": 28},
        ),
        ({"shape": "W"}, {"code": "unknown-name", "name": "shape", "value": "W"}),
        ({"parts": 2}, {"code": "no-effect", "name": "parts", "value": 2, "setting": "shape=U"}),
        ({"parts": 0, "shape": "comb"}, {"code": "below-minimum", "name": "parts", "low": 1}),
        (
            {"parts": 9, "shape": "nested"},
            {"code": "no-room", "size": 30, "shape": "nested", "mouth": 2},
        ),
        (
            {"turns": 2, "shape": "V"},
            {"code": "no-effect", "name": "turns", "value": 2, "setting": "shape=V"},
        ),
        ({"angle": 90}, {"code": "out-of-range", "name": "angle", "value": 90, "high": 89}),
        ({"angle": 45, "depth": 28}, {"code": "no-room", "mouth": 2}),
        ({"faces": "away"}, {"code": "unknown-name", "name": "faces", "value": "away"}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)
