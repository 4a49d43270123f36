"""Mazes: uniform where promised, filled, braided as asked, the same compiled or not."""

import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from worldgen.errors import InvalidParameter
from worldgen.families._spanning_tree import open_sides, spanning_tree, tree_from
from worldgen.families.maze import maze
from worldgen.family import stream_for
from worldgen.generation import generate
from worldgen.random_streams import RandomStream

ALGORITHMS = ("wilson", "backtracker")
SPANNING_TREES_OF_3_BY_3 = 192
every_algorithm = pytest.mark.parametrize("algorithm", ALGORITHMS)


def layout(seed=0, **params):
    return maze.build(stream_for(seed, "maze", 0), **maze.complete(params))


def chi_square(algorithm, draws=40 * SPANNING_TREES_OF_3_BY_3):
    """Distance of the 3 x 3 trees drawn from all being equally often; 191 degrees of freedom."""
    counts = Counter(open_sides(spanning_tree(RandomStream(seed), 3, 3, algorithm)).tobytes() for seed in range(draws))
    expected = draws / SPANNING_TREES_OF_3_BY_3
    unseen = SPANNING_TREES_OF_3_BY_3 - len(counts)
    return sum((count - expected) ** 2 / expected for count in counts.values()) + unseen * expected


def test_wilson_draws_every_tree_equally_often():
    assert chi_square("wilson") < 257.1  # exceeded by one fair sampler in a thousand


def test_the_backtracker_does_not():
    assert chi_square("backtracker") > 1000.0


def test_there_are_as_many_trees_as_kirchhoff_counts():
    seen = {open_sides(spanning_tree(RandomStream(seed), 3, 3, "wilson")).tobytes() for seed in range(4000)}
    assert len(seen) == SPANNING_TREES_OF_3_BY_3


@every_algorithm
@given(seed=st.integers(0, 2**64 - 1), columns=st.integers(1, 12), rows=st.integers(1, 12))
def test_a_tree_joins_all_rooms_without_a_loop(algorithm, seed, columns, rows):
    sides = open_sides(spanning_tree(RandomStream(seed), columns, rows, algorithm))
    plan = np.zeros((2 * rows - 1, 2 * columns - 1), bool)
    plan[::2, ::2] = True
    plan[::2, 1::2], plan[1::2, ::2] = sides[:, :-1, 0], sides[:-1, :, 1]
    assert ndimage.label(plan)[1] == 1
    assert sides.sum() == 2 * (rows * columns - 1)


@every_algorithm
@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (2, 2), (3, 40), (40, 3), (37, 41)])
def test_a_compiled_tree_is_the_same_to_the_bit(algorithm, columns, rows):
    for seed in range(3):
        streams = RandomStream(seed), RandomStream(seed)
        plain = tree_from(streams[0], columns, rows, algorithm, compiled=False)
        compiled = tree_from(streams[1], columns, rows, algorithm, compiled=True)
        assert np.array_equal(plain, compiled)
        assert streams[0].next64() == streams[1].next64()


@every_algorithm
def test_a_small_maze_loads_no_compiler(algorithm):
    code = (
        "import sys; from worldgen.generation import generate; "
        f"generate('maze', 1, size=60, algorithm='{algorithm}'); "
        "print([name for name in ('numba', 'scipy', 'shapely') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@every_algorithm
def test_a_maze_of_2000_cells_is_made_without_recursion(algorithm):
    world = layout(size=2000, algorithm=algorithm, robot_radius=0.05)
    free = ~world.walls
    assert ndimage.label(free)[1] == 1
    assert free.mean() > 0.49  # rooms and the doors between them, every second cell


@given(seed=st.integers(0, 2**64 - 1), size=st.integers(10, 60), passage=st.integers(2, 5), wall=st.integers(1, 4))
def test_rooms_fill_the_square_up_to_one_cell_each(seed, size, passage, wall):
    rooms = (size - 2 + wall) // (passage + wall)
    if rooms < 2:
        return
    world = layout(seed, size=size, passage=passage, wall=wall)
    spare = size - 2 - rooms * passage - (rooms - 1) * wall
    widest = passage + -(-spare // rooms)
    assert thickest(world.walls) == max(wall, 1)
    assert passage <= thinnest_passage(world.walls) and thickest(~world.walls) <= widest


def thickest(cells):
    """Side of the largest full square."""
    side = 0
    while ndimage.binary_erosion(cells, np.ones((side + 1, side + 1)), border_value=0).any():
        side += 1
    return side


def thinnest_passage(walls):
    """Shortest run of free cells along x or y."""
    lengths = []
    for rows in (walls, walls.T):
        edges = np.diff(rows.astype(int), axis=1)
        begins, ends = np.argwhere(edges == -1), np.argwhere(edges == 1)
        lengths += (ends[:, 1] - begins[:, 1]).tolist()
    return min(lengths)


def dead_ends(world):
    """Rooms with one way out, in a maze of one-cell passages and walls."""
    free = ~world.walls
    around = sum(np.roll(free, shift, axis) for shift in (1, -1) for axis in (0, 1))
    return int((free & (around == 1)).sum())


@every_algorithm
@pytest.mark.parametrize("braid", [0.0, 0.3, 0.5, 1.0])
def test_braiding_removes_the_share_of_dead_ends(algorithm, braid):
    for seed in range(5):
        plain, braided = (
            dead_ends(layout(seed, size=41, algorithm=algorithm, passage=1, robot_radius=0.05, braid=share))
            for share in (0.0, braid)
        )
        assert plain - round(braid * plain) - 1 <= braided <= plain - round(braid * plain)


def test_a_fully_braided_maze_has_no_dead_end():
    assert [dead_ends(layout(seed, size=31, passage=1, robot_radius=0.05, braid=1.0)) for seed in range(10)] == [0] * 10


def test_wilson_has_more_dead_ends_than_the_backtracker():
    count = {
        name: sum(dead_ends(layout(seed, size=61, algorithm=name, passage=1, robot_radius=0.05)) for seed in range(5))
        for name in ALGORITHMS
    }
    assert count["wilson"] > 2 * count["backtracker"]


@given(seed=st.integers(0, 2**64 - 1), size=st.integers(10, 40))
def test_start_and_target_are_in_opposite_corners(seed, size):
    world = layout(seed, size=size)
    middle = size * world.cell_size / 2
    assert (world.start.x < middle) != (world.target.x < middle)
    assert (world.start.y < middle) != (world.target.y < middle)


@given(seed=st.integers(0, 2**64 - 1))
def test_the_robot_faces_an_open_side(seed):
    world = layout(seed)
    ahead = world.start.x + 0.2 * np.cos(world.start.heading), world.start.y + 0.2 * np.sin(world.start.heading)
    assert not world.walls[int(ahead[1] / 0.1), int(ahead[0] / 0.1)]


@given(seed=st.integers(0, 2**64 - 1), size=st.integers(10, 40), braid=st.floats(0.0, 1.0))
@settings(max_examples=25)
def test_no_maze_needs_a_second_attempt(seed, size, braid):
    first = layout(seed, size=size, braid=braid)
    assert np.array_equal(generate("maze", seed, size=size, braid=braid).walls, first.walls)


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"passage": 1}, "passage=1 is narrower than the robot, 1.4 cells wide; give at least 2, or -1"),
        ({"passage": 0}, "passage=0 is narrower"),
        ({"passage": -2}, "passage=-2 is narrower"),
        ({"wall": 0}, "wall=0 cells is below 1 cells"),
        ({"braid": -0.1}, "braid=-0.1 is outside 0 to 1"),
        ({"braid": 1.1}, "braid=1.1 is outside 0 to 1"),
        ({"algorithm": "prim"}, "algorithm='prim' is not one of wilson, backtracker"),
        ({"size": 10, "wall": 5}, "leave no 2 x 2 rooms in size=10 cells; give a size of at least 11"),
        ({"size": 30, "robot_radius": 0.7}, "passage=14 and wall=1 leave no 2 x 2 rooms"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, message):
    with pytest.raises(InvalidParameter, match=message):
        layout(**params)


def test_the_least_size_that_the_message_names_works():
    assert layout(size=11, wall=5).width == 11
