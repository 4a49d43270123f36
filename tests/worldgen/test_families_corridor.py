"""Corridors have exactly the requested bends, dead ends and loops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.corridor import corridor
from worldgen.family import stream_for

SEEDS = st.integers(0, 2**64 - 1)
THIN = {"robot_radius": 0.05}  # one cell wide: every free cell is a step of the path
STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))


def layout(seed=0, **params):
    return corridor.build(stream_for(seed, "corridor", 0), **corridor.complete(params))


def cell(world, point):
    return int(point.y / world.cell_size), int(point.x / world.cell_size)


def ways_from(walls, at):
    return [step for step in STEPS if not walls[at[0] + step[0], at[1] + step[1]]]


def counted(world):
    """Bends on the path from start to target in a one-cell corridor without branches."""
    at, end, bends = cell(world, world.start), cell(world, world.target), 0
    (heading,) = ways_from(world.walls, at)
    while at != end:
        at = (at[0] + heading[0], at[1] + heading[1])
        onward = [step for step in ways_from(world.walls, at) if step != (-heading[0], -heading[1])]
        if at != end:
            (step,) = onward
            bends, heading = bends + (step != heading), step
    return bends


def network(world):
    """Return the free cells, links between them, and cells with one link, of a one-cell network."""
    free = ~world.walls
    links = int((free[1:] & free[:-1]).sum() + (free[:, 1:] & free[:, :-1]).sum())
    around = sum(np.roll(free, shift, axis) for shift in (1, -1) for axis in (0, 1))
    return int(free.sum()), links, free & (around == 1)


@given(seed=SEEDS, size=st.integers(10, 60), data=st.data())
def test_a_corridor_has_exactly_the_bends_asked_for(seed, size, data):
    lines = (size - 1) // 2
    bends = data.draw(st.integers(0, lines * lines // 4))
    assert counted(layout(seed, size=size, bends=bends, **THIN)) == bends


@given(seed=SEEDS, size=st.integers(20, 60), bends=st.integers(0, 10), branches=st.integers(0, 8))
def test_dead_ends_are_as_many_as_asked_for(seed, size, bends, branches):
    world = layout(seed, size=size, shape="dead-ends", bends=bends, branches=branches, **THIN)
    cells, links, ends = network(world)
    assert links == cells - 1  # a tree
    assert ends[cell(world, world.start)] and ends[cell(world, world.target)]
    assert ends.sum() == branches + 2


@given(seed=SEEDS, size=st.integers(20, 60), bends=st.integers(0, 10), branches=st.integers(0, 8))
def test_junctions_close_as_many_loops_as_asked_for(seed, size, bends, branches):
    world = layout(seed, size=size, shape="junctions", bends=bends, branches=branches, **THIN)
    cells, links, ends = network(world)
    assert links - cells + 1 == branches
    ends[cell(world, world.start)] = ends[cell(world, world.target)] = False
    assert not ends.any()


@pytest.mark.parametrize(("shape", "drawn"), [("bends", (3, 12)), ("dead-ends", (3, 12))])
def test_bends_left_out_are_drawn(shape, drawn):
    seen = {counted(layout(seed, size=40, **THIN)) for seed in range(60)}
    assert seen == set(range(drawn[0], drawn[1] + 1))


@pytest.mark.parametrize(
    ("shape", "branches"), [("bends", -1), ("dead-ends", 100), ("junctions", 100)]
)
def test_the_most_bends_and_branches_that_are_allowed_can_be_had(shape, branches):
    for seed in range(10):
        world = layout(seed, size=60, shape=shape, bends=210, branches=branches, **THIN)
        assert not world.walls.all()


@given(seed=SEEDS, width=st.integers(2, 6), wall=st.integers(1, 4))
def test_width_and_wall_are_kept_everywhere(seed, width, wall):
    world = layout(seed, size=50, shape="junctions", width=width, wall=wall)
    for rows in (world.walls[1:-1], world.walls[:, 1:-1].T):
        edges = np.diff(rows.astype(int), axis=1)
        for row in edges:
            begins, ends = np.flatnonzero(row == -1), np.flatnonzero(row == 1)
            assert (ends - begins >= width).all()
            assert (begins[1:] - ends[:-1] >= wall).all()


@given(seed=SEEDS, size=st.integers(10, 60), bends=st.integers(1, 2))
def test_a_winding_corridor_spans_the_square(seed, size, bends):
    free = ~layout(seed, size=size, bends=bends).walls
    assert free[1].any() and free[-2].any() and free[:, 1].any() and free[:, -2].any()


@given(seed=SEEDS, shape=st.sampled_from(["bends", "dead-ends", "junctions"]))
def test_the_robot_looks_along_the_corridor(seed, shape):
    world = layout(seed, shape=shape)
    ahead = (
        world.start.x + 0.2 * np.cos(world.start.heading),
        world.start.y + 0.2 * np.sin(world.start.heading),
    )
    assert not world.walls[int(ahead[1] / 0.1), int(ahead[0] / 0.1)]


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"bends": -2}, {"code": "out-of-range", "name": "bends", "value": -2, "high": 1000}),
        ({"bends": 21}, {"code": "out-of-range", "name": "bends", "value": 21, "high": 20}),
        (
            {"bends": 1001, "size": 2000},
            {"code": "out-of-range", "name": "bends", "value": 1001, "high": 1000},
        ),
        (
            {"branches": 3},
            {"code": "no-effect", "name": "branches", "value": 3, "setting": "shape=bends"},
        ),
        (
            {"branches": 11, "shape": "dead-ends"},
            {"code": "out-of-range", "name": "branches", "value": 11, "high": 10},
        ),
        (
            {"width": 1},
            {"code": "narrower-than-robot", "name": "width", "width": 1, "robot_width": 1.4},
        ),
        ({"wall": 0}, {"code": "below-minimum", "name": "wall", "low": 1}),
        ({"width": 14}, {"code": "no-room", "size": 30, "least": 31}),
        ({"shape": "zigzag"}, {"code": "unknown-name", "name": "shape", "value": "zigzag"}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)


def test_the_least_size_that_the_message_names_works():
    assert layout(size=31, width=14).width == 31
