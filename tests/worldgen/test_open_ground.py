"""Places, steps, digging and sight: compiled as plain, and as plain definitions say."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from worldgen.families import _open_ground
from worldgen.families._open_ground import components, covered, dig_from, far_poses, in_sight, steps_from
from worldgen.families._routes import free_windows
from worldgen.random_streams import RandomStream


def ground(seed, side=40, rock=0.35):
    walls = np.ones((side, side), bool)
    walls[1:-1, 1:-1] = (RandomStream(seed).floats((side - 2) ** 2) < rock).reshape(side - 2, side - 2)
    return walls


def hardness(seed, side=40):
    hard = np.zeros((side, side), np.uint8)
    hard[1:-1, 1:-1] = (RandomStream(seed).bits((side - 2) ** 2) % 3 + 1).reshape(side - 2, side - 2)
    return hard


@pytest.mark.gate
@pytest.mark.parametrize("seed", range(4))
def test_compiled_searches_are_the_same_to_the_bit(monkeypatch, seed):
    windows, results = ~ground(seed), []
    for limit in (10**9, 0):
        monkeypatch.setattr(_open_ground, "COMPILE_FROM", limit)
        owner, count = components(windows)
        dug = dig_from(owner, hardness(seed))
        start = int(np.flatnonzero(windows)[0])
        results.append([*steps_from(windows, start), owner, np.array([count]), dug.owner, dug.came, dug.depth])
    assert all(np.array_equal(plain, compiled) for plain, compiled in zip(*results, strict=True))


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
    steps = [(a.ravel(), b.ravel()) for a, b in ((places[:, :-1], places[:, 1:]), (places[:-1], places[1:]))]
    edges = np.concatenate([np.stack([a, b]) for u, v in steps for a, b in ((u, v), (v, u))], axis=1)
    edges = edges[:, (hard.ravel()[edges] > 0).all(axis=0)]
    graph = coo_matrix((hard.ravel()[edges[1]], edges), shape=(hard.size, hard.size)).tocsr()
    owner = np.full(hard.size, -1, np.int32)
    owner[14 * 3 + 5] = 0
    inside = hard.ravel() > 0
    assert np.array_equal(dig_from(owner, hard).depth[inside], dijkstra(graph, indices=14 * 3 + 5)[inside])


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
    line = shapely.LineString([(ax, ay), (bx, by)]) if (ax, ay) != (bx, by) else shapely.Point(ax, ay)
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
