"""Collapsed buildings: ruined where they should be, a survivor in a pocket, and always a path to
it.
"""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.rubble import rubble
from worldgen.family import stream_for
from worldgen.generation import generate

SEEDS = st.integers(0, 2**64 - 1)
COLLAPSES = st.sampled_from(["quake", "blast", "wing"])
SHARES = st.floats(0.0, 1.0)


def layout(seed=0, **params):
    return rubble.build(stream_for(seed, "rubble", 0), **rubble.complete(params))


def cell(world, point):
    """Column and row of the robot's window around a point."""
    return tuple(round(2 * value / world.cell_size - 2) // 2 for value in (point.x, point.y))


def away(world, seed, **params):
    """Cells that differ from the same building undamaged, far from either survivor's pocket."""
    intact = layout(seed, damage=0.0, debris=0.0, pocket=0, size=world.width, **params)
    differ = world.walls != intact.walls
    for survivor in (cell(world, world.target), cell(intact, intact.target)):
        column, row = (max(0, value - 6) for value in survivor)
        differ[row : row + 14, column : column + 14] = False
    return differ


@given(SEEDS, COLLAPSES, st.integers(14, 60), SHARES, SHARES)
def test_the_robots_square_gets_to_the_survivor(seed, collapse, size, damage, debris):
    world = layout(seed, collapse=collapse, size=size, damage=damage, debris=debris)
    places = ndimage.label(ndimage.binary_erosion(~world.walls, np.ones((2, 2)), origin=-1))[0]
    (sx, sy), (tx, ty) = cell(world, world.start), cell(world, world.target)
    assert places[sy, sx] == places[ty, tx] > 0


@given(
    SEEDS,
    COLLAPSES,
    st.integers(10, 50),
    SHARES,
    SHARES,
    st.sampled_from([0.02, 0.05, 0.07, 0.1, 0.13]),
)
@settings(max_examples=40)
def test_no_collapse_needs_a_second_attempt(seed, collapse, size, damage, debris, robot_radius):
    params = {
        "collapse": collapse,
        "size": size,
        "damage": damage,
        "debris": debris,
        "robot_radius": robot_radius,
    }
    assert np.array_equal(generate("rubble", seed, **params).walls, layout(seed, **params).walls)


@pytest.mark.parametrize("pocket", [1, 3])
def test_the_pocket_is_closed_but_for_one_way_in(pocket):
    for seed in range(30):
        world = layout(seed, size=50, pocket=pocket)
        column, row = cell(world, world.target)
        distance = np.maximum(
            *np.meshgrid(*(_outside(np.arange(50), first) for first in (column, row)))
        )
        shell = world.walls[distance == pocket + 1]
        assert world.walls[distance == 0].sum() == 0
        assert 2 <= (~shell).sum() <= 8 < shell.sum()


def _outside(index, first):
    return np.maximum(np.maximum(first - index, index - first - 1), 0)


@pytest.mark.parametrize("collapse", ["quake", "blast", "wing"])
def test_more_damage_brings_more_walls_down(collapse):
    def down(damage):
        worlds = [
            layout(seed, collapse=collapse, damage=damage, debris=0.0, pocket=0, size=60)
            for seed in range(4)
        ]
        return sum(away(world, seed).sum() for seed, world in enumerate(worlds))

    counts = [down(damage) for damage in (0.0, 0.3, 0.6, 1.0)]
    assert counts[0] < counts[1] < counts[2] < counts[3]


def test_more_debris_covers_more_floor():
    def floor(debris):
        return sum((~layout(seed, debris=debris, size=60).walls).sum() for seed in range(4))

    floors = [floor(0.0), floor(0.3), floor(0.7)]
    assert floors == sorted(floors, reverse=True) and floors[0] > 1.2 * floors[2]


def test_undamaged_parts_are_as_they_were():
    for seed in range(5):
        assert 0.0 < away(layout(seed, size=60, damage=0.2), seed).mean() < 0.2


@pytest.mark.gate
def test_a_blast_ruins_one_place_and_a_quake_many():
    def extent(collapse):
        parts = []
        for seed in range(8):
            rows, columns = np.nonzero(
                away(layout(seed, collapse=collapse, damage=0.15, size=90), seed)
            )
            parts.append(rows.std() + columns.std())
        return np.mean(parts)

    assert 1.5 * extent("blast") < extent("quake")


def test_debris_is_thickest_where_walls_were():
    near = far = 0.0
    for seed in range(5):
        walls = layout(seed, size=90, damage=1.0, room=12, debris=0.3).walls
        before = layout(seed, size=90, damage=0.0, room=12, debris=0.0).walls
        beside = ndimage.binary_dilation(before, np.ones((3, 3))) & ~before
        near += walls[beside].mean()
        far += walls[~ndimage.binary_dilation(before, np.ones((3, 3)))].mean()
    assert near > 2 * far


def test_the_robot_starts_where_the_building_stands_and_the_survivor_lies_where_it_fell():
    standing = 0
    for seed in range(20):
        world = layout(seed, size=60, collapse="wing", damage=0.4, debris=0.5, pocket=0)
        solid = ndimage.uniform_filter(world.walls.astype(float), 11, mode="nearest")
        (sx, sy), (tx, ty) = cell(world, world.start), cell(world, world.target)
        standing += solid[sy, sx] < solid[ty, tx]
    assert standing >= 15


@pytest.mark.gate
def test_a_small_collapse_loads_nothing_heavy():
    code = (
        "import sys; from worldgen.generation import generate; generate('rubble', 1, size=60); "
        "print([name for name in ('numba', 'scipy', 'shapely') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"collapse": "fire"}, {"code": "unknown-name", "name": "collapse", "value": "fire"}),
        ({"damage": 1.1}, {"code": "out-of-range", "name": "damage", "value": 1.1}),
        ({"debris": -0.1}, {"code": "out-of-range", "name": "debris", "value": -0.1}),
        ({"wall": 0}, {"code": "below-minimum", "name": "wall", "low": 1}),
        ({"pocket": 29}, {"code": "out-of-range", "name": "pocket", "value": 29, "low": -1}),
        ({"room": 1}, {"code": "below-minimum", "name": "robot", "room": 1, "least": 2}),
        ({"room": 15}, {"code": "no-room", "room": 15, "between": 1, "inside": 28}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)
