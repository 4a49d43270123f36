"""What compiled code proves is what plain Python proves, to the bit; parts of it against fractions and brute force."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from tests.helpers.drawn_worlds import RADII, still_worlds, tight_worlds
from worldgen.lattice import UNIT
from worldgen.reach import check_certificate, lattice_graph, prove
from worldgen.reach.bucket_search import bucket_search, room_for_search
from worldgen.reach.coarse import walk_squares
from worldgen.reach.cut import find_chain, linked_offsets, rim_cells
from worldgen.reach.disc import parts
from worldgen.reach.effort import PATIENCE, Effort, effort
from worldgen.reach.flood import flood, flood_compiled
from worldgen.reach.lattice_graph import Graph, build_graph, find_path, neighbour_shifts
from worldgen.reach.path import clearance_sq, shorten
from worldgen.reach.prove import decide, decide_many
from worldgen.reach.segments import scan_piece
from worldgen.reach.walls import Walls, segment_box_sq

maps = hnp.arrays(np.bool_, st.tuples(st.integers(3, 9), st.integers(3, 9)), fill=st.just(False))
radii = st.sampled_from(RADII).map(lambda radius: Fraction(str(radius)))


@pytest.fixture(autouse=True)
def _no_effort_spent(monkeypatch):
    monkeypatch.setattr(effort, "spent", 0)


def both_ways(world, monkeypatch):
    """The decisions of plain and of compiled code."""
    monkeypatch.setattr(effort, "spent", 0)
    plain = decide(world)
    monkeypatch.setattr(effort, "spent", PATIENCE + 1)
    return plain, decide(world)


@pytest.mark.gate
@given(world=still_worlds())
def test_a_compiled_decision_is_the_same_to_the_bit(world, monkeypatch):
    plain, compiled = both_ways(world, monkeypatch)
    assert plain == compiled


@given(world=tight_worlds())
def test_a_compiled_decision_about_a_tight_world_is_the_same_to_the_bit(world, monkeypatch):
    plain, compiled = both_ways(world, monkeypatch)
    assert plain == compiled


@pytest.mark.gate
@given(maps, radii, st.sampled_from([2, 4]))
def test_compiled_rasters_are_the_same(walls, radius, k):
    plain, compiled = build_graph(walls, radius, k), build_graph(walls, radius, k, compiled=True)
    assert np.array_equal(plain.clear, compiled.clear)
    assert np.array_equal(plain.middle, compiled.middle)


def test_compiled_rasters_of_a_disc_wider_than_a_byte_counts_are_the_same():
    walls = np.zeros((280, 280), bool)
    walls[0, 0] = walls[279, 100] = True
    plain, compiled = build_graph(walls, Fraction(260, 2), 2), build_graph(walls, Fraction(260, 2), 2, compiled=True)
    assert plain.clear.any()
    assert np.array_equal(plain.clear, compiled.clear)
    assert np.array_equal(plain.middle, compiled.middle)


@st.composite
def graphs(draw, side=24):
    """Graphs of random clear nodes and middles, with a source, ends, spare ends and where to lean to."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    clear, middle = rng.random((side, side)) < draw(st.sampled_from([0.6, 0.8, 1.0])), rng.random((side, side)) < 0.8
    clear[[0, -1]] = clear[:, [0, -1]] = False
    nodes = st.integers(side + 1, side * side - side - 2)
    source, toward = draw(nodes), draw(nodes)
    clear.ravel()[source] = True
    near = [source, *(node for node in (source + 1, source + side) if clear.ravel()[node])]
    free = np.flatnonzero(clear)
    ends = [toward] if draw(st.booleans()) and clear.ravel()[toward] else []
    spare = rng.choice(free, 3) if draw(st.booleans()) or not ends else np.zeros(0, np.int64)
    return Graph(2, clear, middle), near, ends, spare, (toward % side, toward // side)


@given(graphs())
def test_a_search_with_buckets_finds_the_path_of_the_search_with_a_heap(asked):
    assert find_path(*asked, compiled=True) == find_path(*asked)


@pytest.mark.gate
@given(graphs())
def test_a_search_that_is_stopped_looks_first_whether_there_is_a_way(asked):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lattice_graph, "_HASTY", 3)
        assert find_path(*asked, compiled=True) == find_path(*asked)


@given(graphs(side=8))
def test_the_search_with_buckets_is_the_same_interpreted(asked):
    graph, sources, ends, spare, toward = asked
    goal, size = np.zeros(graph.clear.size, np.uint8), graph.clear.size
    goal[spare], goal[ends] = 2 if ends else 1, 1
    across, up = [1, -1, 0, 0, 1, -1, -1, 1], [0, 0, 1, -1, 1, -1, 1, -1]
    steps = np.array([*neighbour_shifts(graph.stride), across, up]).T
    path = bucket_search(
        graph.clear.ravel(), graph.middle.ravel(), goal, graph.stride, steps, np.unique(sources), np.array([0, size]),
        toward, np.zeros(size, np.int64), 2**31 - 1, np.zeros(size, np.uint8), np.array([size]),
        *room_for_search(size),
    )  # fmt: skip
    assert path.tolist() == find_path(*asked)  # both without the nodes in the middle of a line


@given(graphs(side=12))
def test_a_flood_reaches_what_is_connected(asked):
    graph, sources, *_ = asked
    clear, middle = graph.clear.ravel().view(np.uint8), graph.middle.ravel().view(np.uint8)
    shifts, corners = neighbour_shifts(graph.stride)
    pairs = [
        (node, node + shift)
        for node in np.flatnonzero(clear).tolist()
        for way, (shift, corner) in enumerate(zip(shifts, corners, strict=True))
        if clear[node + shift] and (way < 4 or middle[node + corner])
    ]
    joined = sparse.coo_matrix((np.ones(len(pairs)), np.array(pairs).reshape(-1, 2).T), shape=(clear.size,) * 2)
    part = csgraph.connected_components(joined, directed=False)[1]
    for run in (flood, flood_compiled):
        seen = np.zeros(clear.size, np.uint8)
        run(clear, middle, graph.stride, np.array(sources[:1]), seen)
        assert np.array_equal(seen > 0, part == part[sources[0]])


points = st.tuples(st.integers(0, 9 * UNIT), st.integers(0, 9 * UNIT))


@given(maps, radii, points, points)
def test_a_scan_of_a_piece_has_the_least_distance_to_any_cell(walls, radius, p, q):
    of, reach = Walls(walls, radius), 20 * UNIT
    least, side, length_sq, _ = scan_piece(*p, *q, of.cells, reach, float(reach) ** 2, reach**2, False)
    exact = min(Fraction(*segment_box_sq(p, q, cell)) for cell in of.near(p, q, reach))
    assert exact == (min(Fraction(least), Fraction(int(side) ** 2, int(length_sq))) if length_sq else least)


@st.composite
def paths(draw):
    """A map and a path through it, mostly of half cells."""
    walls, radius = draw(maps), draw(radii)
    half = st.integers(0, 16).map(lambda value: value * UNIT // 2)
    corners = draw(st.lists(st.tuples(half, half), min_size=1, max_size=8))
    for i in draw(st.sets(st.integers(0, len(corners) - 1), max_size=3)):
        corners[i] = (corners[i][0] + Fraction(1, 3), corners[i][1])
    return Walls(walls, radius), corners


@given(paths())
def test_compiled_shortening_goes_by_the_same_corners(drawn):
    assert shorten(*drawn, compiled=True) == shorten(*drawn)


@given(paths())
def test_compiled_clearance_is_the_same_fraction(drawn):
    assert clearance_sq(*drawn, compiled=True) == clearance_sq(*drawn)


def test_a_slanting_distance_that_equals_the_radius_is_clear_but_only_fractions_say_so():
    walls = np.zeros((15, 15), bool)
    walls[5, 5] = True  # (7, 6.75) is 1.25 from its corner (6, 6), and so is the line at right angles through it
    p, q = (11 * UNIT // 2, 35 * UNIT // 4), (17 * UNIT // 2, 19 * UNIT // 4)
    of, square = Walls(walls, Fraction(5, 4)), (5 * UNIT // 4) ** 2
    _, side, _, nearer = scan_piece(*p, *q, of.cells, 3 * UNIT, float(square), square, False)
    assert side > 0
    assert not nearer
    assert shorten(of, [p, (q[0], p[1]), q], compiled=True) == [p, q]


def chain_exists(world, radius, points):
    """Whether a cycle of links winds round one of two poses: every link looked at, over (cell, bit)."""
    rows, columns = np.nonzero(rim_cells(world.walls))
    cells = list(zip((columns - 1).tolist(), (rows - 1).tolist(), strict=True))
    number = {cell: index for index, cell in enumerate(cells)}
    half = linked_offsets(radius)[: len(linked_offsets(radius)) // 2]
    links = []
    for (x, y), (dx, dy) in itertools.product(cells, half):
        if (x + dx, y + dy) in number:
            a, b = number[x, y], number[x + dx, y + dy]
            bit = parts([(x, y), (x + dx, y + dy), (x + dx, -99), (x, -99)], *points)
            links += [(2 * a, 2 * b + bit), (2 * a + 1, 2 * b + 1 - bit)]
    joined = sparse.coo_matrix((np.ones(len(links)), np.array(links).reshape(-1, 2).T), shape=(2 * len(cells),) * 2)
    part = csgraph.connected_components(joined, directed=False)[1].reshape(-1, 2)
    return bool((part[:, 0] == part[:, 1]).any())


@pytest.mark.gate
@given(still_worlds())
def test_a_chain_is_found_exactly_where_a_look_at_every_link_finds_one(world):
    radius = Fraction(str(world.robot_radius))
    ends = (world.start, world.target)
    points = [(round(UNIT * end.x), round(UNIT * end.y)) for end in ends]
    walls = Walls(world.walls, radius)
    if all(walls.is_clear(point, point) for point in points):
        expected = chain_exists(world, radius, points)
        for compiled in (False, True):
            found = find_chain(world.walls, radius, points[0], points[1:], compiled=compiled)
            assert (found is not None) == expected


def test_small_worlds_are_left_to_plain_python_until_that_has_cost_as_much_as_loading():
    spent = Effort()
    done = [spent.pays_to_compile(3600) for _ in range(1 + PATIENCE // 3600)]
    assert not any(done[:-1])
    assert done[-1]
    assert Effort().pays_to_compile(10**6)


@given(worlds=st.lists(still_worlds(), min_size=1, max_size=4))
def test_many_worlds_are_decided_as_one_by_one(worlds):
    assert decide_many(worlds) == [decide(world) for world in worlds]
    bare = decide_many(worlds, certificate=False)
    assert [decision.result for decision in bare] == [decide(world).result for world in worlds]


def test_thousands_of_worlds_are_decided_by_compiled_code_from_the_first_on():
    expecting = Effort()
    expecting.expect(PATIENCE // 2)
    assert not expecting.pays_to_compile(3600)
    expecting.expect(PATIENCE)
    assert expecting.pays_to_compile(3600)


@pytest.mark.gate
@given(world=still_worlds())
def test_a_way_over_whole_cells_is_a_proof_and_what_it_does_not_find_is_found_among_half_cells(world, monkeypatch):
    usual = decide(world)
    monkeypatch.setattr(prove, "FROM_CELLS", 0)
    coarse = decide(world)
    monkeypatch.undo()
    assert coarse.result == usual.result
    assert coarse.certificate is None or check_certificate(world, coarse.certificate).valid


@given(hnp.arrays(np.bool_, (6, 7)), st.integers(1, 3), st.data())
def test_squares_get_wherever_they_are_joined_side_to_side(walls, side, data):
    free = np.zeros((8, 9), bool)
    for iy, ix in np.ndindex(7 - side, 8 - side):
        free[iy + 1, ix + 1] = not walls[iy : iy + side, ix : ix + side].any()
    assume(free.any())
    places = st.sampled_from(np.flatnonzero(free).tolist())
    source, goal = data.draw(places), data.draw(places)
    way = walk_squares(walls.view(np.uint8), side, source, goal, np.zeros(72, np.uint8), np.zeros(7, np.int32))
    parts, _ = ndimage.label(free)
    joined = parts.ravel()[source] == parts.ravel()[goal]
    assert (len(way) > 0) == joined
    assert not joined or (way[0], way[-1]) == (source, goal)
