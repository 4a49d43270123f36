"""Places, steps, digging and sight agree with the reference and with plain definitions."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from tests.reference.worldgen import ground as ground_reference
from worldgen.families.parts.open_ground import covered, dig_from, far_poses, in_sight
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import components, free_windows, shortest_path, steps_from


def ground(seed, side=40, rock=0.35):
    walls = np.ones((side, side), bool)
    walls[1:-1, 1:-1] = (RandomStream(seed).floats((side - 2) ** 2) < rock).reshape(
        side - 2, side - 2
    )
    return walls


def hardness(seed, side=40):
    hard = np.zeros((side, side), np.uint8)
    hard[1:-1, 1:-1] = (RandomStream(seed).bits((side - 2) ** 2) % 3 + 1).reshape(
        side - 2, side - 2
    )
    return hard


@given(st.integers(0, 2**32))
@settings(max_examples=20)
def test_steps_are_those_of_the_reference_in_its_order(seed):
    windows = ~ground(seed, 20)
    start = int(np.flatnonzero(windows)[0])
    steps = [-1] * windows.size
    queue = [0] * windows.size
    count = ground_reference.flood(windows.tobytes(), steps, queue, start, windows.shape[1])
    found, order = steps_from(windows, start)
    assert found.tolist() == steps
    assert order.tolist() == queue[:count]


@given(st.integers(0, 2**32))
@settings(max_examples=20)
def test_a_shortest_path_is_that_of_the_reference(seed):
    windows = ~ground(seed, 20)
    places = np.flatnonzero(windows).tolist()
    start = places[seed % len(places)]
    goal = places[-1]
    came = [-1] * windows.size
    queue = [0] * windows.size
    ground_reference.breadth_first(windows.tobytes(), came, queue, start, goal, windows.shape[1])
    path = shortest_path(windows, start, goal)
    if came[goal] < 0:
        assert path == []
    else:
        assert path[0] == start
        assert path[-1] == goal
        assert [came[place] for place in path[1:]] == path[:-1]


@given(st.integers(0, 2**32))
@settings(max_examples=20)
def test_digging_is_that_of_the_reference(seed):
    windows = ~ground(seed, 20)
    hard = hardness(seed, 20)
    owner, _ = components(windows)
    begins = np.flatnonzero(owner >= 0)
    waits = hard.copy()
    waits.reshape(-1)[begins] = 1
    expected = [owner.tolist(), [-1] * owner.size, [0] * owner.size]
    for begin in begins.tolist():
        expected[1][begin] = begin
    queue = begins.tolist() + [0] * (owner.size - len(begins))
    ground_reference.spread(waits.ravel().tolist(), *expected, queue, len(begins), windows.shape[1])
    dug = dig_from(owner, hard)
    assert [dug.owner.tolist(), dug.came.tolist(), dug.depth.tolist()] == expected


def test_a_search_that_could_leave_the_grid_is_refused():
    windows = np.ones((5, 5), bool)
    with pytest.raises(ValueError, match="too small"):
        steps_from(windows, 12)


@given(st.integers(0, 2**32))
def test_components_are_those_of_scipy(seed):
    windows = ~ground(seed)
    owner, count = components(windows)
    labels, expected = ndimage.label(windows)
    assert count == expected and np.array_equal(owner.reshape(windows.shape) + 1, labels)


@given(st.integers(0, 2**32))
def test_digging_takes_the_easiest_way(seed):
    hard = hardness(seed, 14)
    places = np.arange(hard.size).reshape(hard.shape)
    steps = [
        (a.ravel(), b.ravel())
        for a, b in ((places[:, :-1], places[:, 1:]), (places[:-1], places[1:]))
    ]
    edges = np.concatenate(
        [np.stack([a, b]) for u, v in steps for a, b in ((u, v), (v, u))], axis=1
    )
    edges = edges[:, (hard.ravel()[edges] > 0).all(axis=0)]
    graph = coo_matrix((hard.ravel()[edges[1]], edges), shape=(hard.size, hard.size)).tocsr()
    owner = np.full(hard.size, -1, np.int32)
    owner[14 * 3 + 5] = 0
    inside = hard.ravel() > 0
    assert np.array_equal(
        dig_from(owner, hard).depth[inside], dijkstra(graph, indices=14 * 3 + 5)[inside]
    )


@given(st.integers(0, 2**32), st.integers(1, 5))
def test_covered_cells_are_those_of_the_windows(seed, side):
    windows = free_windows(ground(seed, rock=0.1), side, side)
    expected = np.zeros_like(windows)
    for row, column in np.argwhere(windows):
        expected[row : row + side, column : column + side] = True
    assert np.array_equal(covered(windows, side), expected)


@given(st.integers(0, 2**32), *[st.integers(3, 77)] * 4)
def test_in_sight_agrees_with_shapely(seed, ax, ay, bx, by):
    walls = ground(seed, rock=0.03)
    rows, columns = np.nonzero(walls)
    cells = shapely.box(2 * columns, 2 * rows, 2 * columns + 2, 2 * rows + 2)
    line = (
        shapely.LineString([(ax, ay), (bx, by)]) if (ax, ay) != (bx, by) else shapely.Point(ax, ay)
    )
    barred = shapely.relate_pattern(shapely.union_all(cells), line, "T********")
    assert in_sight(walls, (ax, ay), (bx, by)) == (not barred or (ax, ay) == (bx, by))


@given(st.integers(0, 2**32))
def test_far_poses_are_far_by_the_way_between_them(seed):
    walls = ground(seed, rock=0.2)
    begin = int(np.flatnonzero(~walls)[0])
    poses = far_poses(RandomStream(seed), walls, 1, begin)
    start, target = ((y // 2) * 40 + x // 2 for x, y in (poses.start, poses.target))
    steps, order = steps_from(~walls, start)
    assert steps[target] >= steps[order[-1]] * 4 // 5
