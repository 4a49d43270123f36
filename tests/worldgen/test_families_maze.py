"""Mazes: uniform where promised, filled, braided as requested, and independent of the number of
words per call.
"""

import dataclasses
import re
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.sparse.csgraph import shortest_path

from tests.helpers.raising import raises
from tests.helpers.tiers import some
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.maze import maze
from worldgen.families.parts.mazes import (
    FIT_ANY_SHAPE,
    METHODS,
    grow,
    open_sides,
    shape_mask,
    winding_tree,
)
from worldgen.families.parts.mazes.board import ROOT, links_of_parents
from worldgen.families.parts.mazes.shapes import LEAST
from worldgen.family import stream_for
from worldgen.generation import generate
from worldgen.random_streams import RandomStream

ALGORITHMS = tuple(METHODS)
BIASED = tuple(name for name in METHODS if name not in ("wilson", "aldous-broder"))
MASKS = tuple(name for name in LEAST if name != "square")
SPANNING_TREES_OF_3_BY_3 = 192
every_algorithm = pytest.mark.parametrize("algorithm", ALGORITHMS)
every_mask = pytest.mark.parametrize("mask", MASKS)


def layout(seed=0, **params):
    return maze.build(stream_for(seed, "maze", 0), **maze.complete(params))


def full(rows, columns):
    return np.ones((rows, columns), bool)


def chi_square(algorithm, draws=40 * SPANNING_TREES_OF_3_BY_3):
    """Return how far the 3 x 3 trees drawn are from equal frequencies; 191 degrees of freedom."""
    counts = Counter(
        grow(RandomStream(seed), full(3, 3), algorithm).tobytes() for seed in range(draws)
    )
    expected = draws / SPANNING_TREES_OF_3_BY_3
    unseen = SPANNING_TREES_OF_3_BY_3 - len(counts)
    return sum((count - expected) ** 2 / expected for count in counts.values()) + unseen * expected


@pytest.mark.gate
@pytest.mark.parametrize("algorithm", ["wilson", "aldous-broder"])
def test_every_tree_is_drawn_equally_often(algorithm):
    assert chi_square(algorithm) < 257.1  # exceeded by one fair sampler in a thousand


@pytest.mark.nightly
@pytest.mark.parametrize("algorithm", some(BIASED, 2))
def test_the_others_favour_some_trees(algorithm):
    assert chi_square(algorithm) > 350.0  # a fair sampler does not get this far in 10**9 tries


def test_there_are_as_many_trees_as_kirchhoff_counts():
    seen = {grow(RandomStream(seed), full(3, 3), "wilson").tobytes() for seed in range(4000)}
    assert len(seen) == SPANNING_TREES_OF_3_BY_3


@pytest.mark.gate
@every_algorithm
@given(seed=st.integers(0, 2**64 - 1), columns=st.integers(1, 12), rows=st.integers(1, 12))
@settings(max_examples=30)
def test_a_maze_joins_all_chambers_without_a_loop(algorithm, seed, columns, rows):
    assert_is_a_tree(grow(RandomStream(seed), full(rows, columns), algorithm), full(rows, columns))


@pytest.mark.parametrize("algorithm", FIT_ANY_SHAPE)
@every_mask
def test_a_maze_in_a_shape_joins_all_its_chambers_without_a_loop(algorithm, mask):
    for side in (LEAST[mask], 13, 20):
        inside = shape_mask(mask, side)
        assert_is_a_tree(grow(RandomStream(side), inside, algorithm), inside)


def assert_is_a_tree(links, mask):
    sides = open_sides(links)
    rows, columns = mask.shape
    plan = np.zeros((2 * rows - 1, 2 * columns - 1), bool)
    plan[::2, ::2] = mask
    plan[::2, 1::2], plan[1::2, ::2] = sides[:, :-1, 0], sides[:-1, :, 1]
    assert ndimage.label(plan)[1] == 1
    assert sides.sum() == 2 * (mask.sum() - 1)
    assert not sides[~mask].any()


class SameStream(RandomStream):
    """A stream that returns itself as its children."""

    def child(self, *labels):
        return self


def test_prim_and_kruskal_find_the_same_lightest_tree_of_the_same_weights():
    mask = shape_mask("disc", 9)
    for seed in range(20):
        grown, joined = (grow(SameStream(seed), mask, name) for name in ("prim", "kruskal"))
        assert np.array_equal(grown, joined)


@pytest.mark.parametrize("words", [1, 16, 1000])
@pytest.mark.parametrize(
    "algorithm", [name for name in METHODS if METHODS[name].words is METHODS["wilson"].words]
)
def test_a_maze_continues_where_its_words_ran_out(monkeypatch, algorithm, words):
    expected = grow(RandomStream(3), full(9, 9), algorithm)
    method = dataclasses.replace(METHODS[algorithm], words=lambda columns, rows: words)
    monkeypatch.setitem(METHODS, algorithm, method)
    assert np.array_equal(grow(RandomStream(3), full(9, 9), algorithm), expected)


def test_a_mask_in_two_parts_is_refused():
    mask = full(5, 5)
    mask[2] = False
    for algorithm in FIT_ANY_SHAPE:
        with pytest.raises(ValueError, match="out of its range"):
            grow(RandomStream(1), mask, algorithm)


def test_a_winding_tree_names_parents_up_to_one_root():
    tree = winding_tree(RandomStream(2), 5, 4)
    assert tree.shape == (4, 5) and (tree == ROOT).sum() == 1
    assert np.array_equal(links_of_parents(tree), grow(RandomStream(2), full(4, 5), "backtracker"))


@pytest.mark.parametrize("algorithm", some(ALGORITHMS))
def test_a_small_maze_loads_no_compiler(algorithm):
    code = (
        "import sys; from worldgen.generation import generate; "
        f"generate('maze', 1, size=60, algorithm='{algorithm}'); "
        "print([name for name in ('numba', 'scipy', 'shapely') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("algorithm", some(ALGORITHMS))
def test_a_maze_of_2000_cells_is_made_without_recursion(algorithm):
    world = layout(size=2000, algorithm=algorithm, robot_radius=0.05)
    free = ~world.walls
    assert ndimage.label(free)[1] == 1
    assert free.mean() > 0.49  # chambers and the doors between them, every second cell


@given(
    seed=st.integers(0, 2**64 - 1),
    size=st.integers(10, 60),
    passage=st.integers(2, 5),
    wall=st.integers(1, 4),
)
def test_chambers_fill_the_square_up_to_one_cell_each(seed, size, passage, wall):
    chambers = (size - 2 + wall) // (passage + wall)
    if chambers < 2:
        return
    world = layout(seed, size=size, passage=passage, wall=wall)
    spare = size - 2 - chambers * passage - (chambers - 1) * wall
    widest = passage + -(-spare // chambers)
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
    """Chambers with one way out, in a maze of one-cell passages and walls."""
    free = ~world.walls
    around = sum(np.roll(free, shift, axis) for shift in (1, -1) for axis in (0, 1))
    return int((free & (around == 1)).sum())


@pytest.mark.parametrize("algorithm", ["wilson", "backtracker", "eller"])
@pytest.mark.parametrize("braid", [0.0, 0.3, 0.5, 1.0])
def test_braiding_removes_the_share_of_dead_ends(algorithm, braid):
    for seed in range(5):
        plain, braided = (
            dead_ends(
                layout(
                    seed, size=41, algorithm=algorithm, passage=1, robot_radius=0.05, braid=share
                )
            )
            for share in (0.0, braid)
        )
        assert plain - round(braid * plain) - 1 <= braided <= plain - round(braid * plain)


def test_a_fully_braided_maze_has_no_dead_end():
    assert [
        dead_ends(layout(seed, size=31, passage=1, robot_radius=0.05, braid=1.0))
        for seed in range(10)
    ] == [0] * 10


def dead_ends_of(**params):
    return sum(
        dead_ends(layout(seed, size=61, passage=1, robot_radius=0.05, **params))
        for seed in range(5)
    )


def test_wilson_has_more_dead_ends_than_the_backtracker():
    assert dead_ends_of(algorithm="wilson") > 2 * dead_ends_of(algorithm="backtracker")


def test_a_growing_tree_goes_from_a_backtracker_to_many_dead_ends_as_its_shares_say():
    ends = [dead_ends_of(algorithm="growing-tree", newest=newest) for newest in (1.0, 0.5, 0.0)]
    assert 2 * ends[0] < ends[1] < ends[2]
    assert abs(ends[0] - dead_ends_of(algorithm="backtracker")) < 0.1 * ends[0]


def test_a_growing_tree_of_the_oldest_alone_goes_the_shortest_way_from_its_root():
    sides = open_sides(grow(RandomStream(3), full(9, 9), "growing-tree", newest=0.0, oldest=1.0))
    graph = np.zeros((81, 81))
    for row, column, way in np.argwhere(sides[:, :, :2]):
        graph[9 * row + column, 9 * row + column + (9 if way else 1)] = 1
    rows, columns = np.divmod(np.arange(81), 9)
    apart = abs(rows - rows[:, None]) + abs(columns - columns[:, None])
    assert (shortest_path(graph, directed=False) == apart).all(axis=1).any()


@every_mask
@pytest.mark.parametrize("braid", [0.0, 1.0])
def test_a_mask_holds_the_maze_and_the_rest_is_rock(mask, braid):
    for seed in range(3):
        world = layout(seed, size=41, mask=mask, braid=braid, passage=1, robot_radius=0.05)
        inside, free = shape_mask(mask, 20), ~world.walls
        assert ndimage.label(free)[1] == 1
        assert free.sum() >= 2 * inside.sum() - 1 if braid else free.sum() == 2 * inside.sum() - 1
        assert not braid or dead_ends(world) == 0


@every_mask
def test_start_and_target_lie_on_opposite_sides_of_a_mask(mask):
    for seed in range(8):
        world = layout(seed, size=40, mask=mask)
        assert (
            np.hypot(world.start.x - world.target.x, world.start.y - world.target.y)
            > 0.5 * 40 * world.cell_size
        )


@pytest.mark.parametrize("rooms", [1, 2, 5, 9, 16])
@pytest.mark.parametrize("mask", ["square", "ring"])
def test_as_many_rooms_as_asked_are_carved_and_none_touches_another(rooms, mask):
    for seed in range(4):
        world = layout(seed, size=61, rooms=rooms, mask=mask, passage=1, robot_radius=0.05)
        halls = ndimage.binary_erosion(
            ~world.walls, np.ones((3, 3))
        )  # 2 x 2 chambers without their walls
        assert ndimage.label(halls, np.ones((3, 3)))[1] == rooms
        assert ndimage.label(~world.walls)[1] == 1


@pytest.mark.parametrize("mask", ["square", "disc"])
def test_the_most_rooms_that_the_message_names_fit(mask):
    with raises(InvalidParameter, "no-room", rooms=9999) as told:
        layout(size=40, mask=mask, rooms=9999)
    most = int(re.search(r"at most (\d+)", str(told.value)).group(1))
    layout(size=40, mask=mask, rooms=most)
    with raises(InvalidParameter, "no-room"):
        layout(size=40, mask=mask, rooms=most + 1)


@pytest.mark.parametrize("mask", LEAST)
def test_a_shape_is_in_one_piece_with_two_ways_out_of_each_chamber(mask):
    for side in range(LEAST[mask], 60):
        inside = np.pad(shape_mask(mask, side), 1)
        around = sum(
            np.roll(inside, shift, axis).astype(int) for shift in (1, -1) for axis in (0, 1)
        )
        assert ndimage.label(inside)[1] == 1 and (around[inside] >= 2).all()
        assert inside[1:-1, 1:-1].all() == (mask == "square")


@given(seed=st.integers(0, 2**64 - 1), size=st.integers(10, 40))
def test_start_and_target_are_in_opposite_corners(seed, size):
    world = layout(seed, size=size)
    middle = size * world.cell_size / 2
    assert (world.start.x < middle) != (world.target.x < middle)
    assert (world.start.y < middle) != (world.target.y < middle)


@given(seed=st.integers(0, 2**64 - 1))
def test_the_robot_faces_an_open_side(seed):
    world = layout(seed)
    ahead = (
        world.start.x + 0.2 * np.cos(world.start.heading),
        world.start.y + 0.2 * np.sin(world.start.heading),
    )
    assert not world.walls[int(ahead[1] / 0.1), int(ahead[0] / 0.1)]


@given(seed=st.integers(0, 2**64 - 1), size=st.integers(10, 40), braid=st.floats(0.0, 1.0))
@settings(max_examples=25)
def test_no_maze_needs_a_second_attempt(seed, size, braid):
    first = layout(seed, size=size, braid=braid)
    assert np.array_equal(generate("maze", seed, size=size, braid=braid).walls, first.walls)


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        (
            {"passage": 1},
            {"code": "narrower-than-robot", "name": "passage", "width": 1, "robot_width": 1.4},
        ),
        ({"passage": 0}, {"code": "below-minimum", "name": "passage", "chosen": -1, "low": 1}),
        ({"passage": -2}, {"code": "below-minimum", "name": "passage", "chosen": -1, "value": -2}),
        ({"wall": 0}, {"code": "below-minimum", "name": "wall", "low": 1}),
        ({"braid": -0.1}, {"code": "out-of-range", "name": "braid", "value": -0.1}),
        ({"braid": 1.1}, {"code": "out-of-range", "name": "braid", "value": 1.1}),
        ({"algorithm": "prism"}, {"code": "unknown-name", "name": "algorithm", "value": "prism"}),
        ({"size": 10, "wall": 5}, {"code": "no-room", "passage": 2, "size": 10, "least": 11}),
        ({"size": 30, "robot_radius": 0.7}, {"code": "no-room", "passage": 14, "wall": 1}),
        ({"rooms": -1}, {"code": "below-minimum", "name": "rooms", "value": -1}),
        (
            {"newest": 0.5},
            {"code": "no-effect", "name": "newest", "share": 0.5, "algorithm": "wilson"},
        ),
        (
            {"oldest": 0.0, "algorithm": "prim"},
            {"code": "no-effect", "name": "oldest", "algorithm": "prim"},
        ),
        (
            {"algorithm": "growing-tree", "newest": 1.5},
            {"code": "out-of-range", "name": "newest", "value": 1.5},
        ),
        (
            {"algorithm": "growing-tree", "newest": 0.7, "oldest": 0.4},
            {"code": "above-maximum", "newest": 0.7, "oldest": 0.4},
        ),
        (
            {"algorithm": "eller", "mask": "disc"},
            {"code": "conflict", "shape": "disc", "algorithm": "eller"},
        ),
        ({"size": 10, "mask": "ring"}, {"code": "no-room", "shape": "ring", "least": 6, "side": 3}),
        ({"size": 10, "rooms": 2}, {"code": "no-room", "rooms": 2, "most": 1}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)


def test_the_least_size_that_the_message_names_works():
    assert layout(size=11, wall=5).width == 11
