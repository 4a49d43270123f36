"""The prover's C gives the same results as the reference, bit for bit.

Parts of both are compared with brute force.
"""

import itertools
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from tests.helpers.drawn_worlds import RADII, still_worlds, tight_worlds
from tests.reference.worldgen import chains, coarse, graph_search, paths
from tests.reference.worldgen import rasters as reference_rasters
from tests.reference.worldgen.chains import linked_offsets
from tests.reference.worldgen.target_poses import plain_poses
from worldgen._core import ffi, lib
from worldgen.generation import generate
from worldgen.lattice import UNIT, radius_in_cells
from worldgen.reach import check_certificate
from worldgen.reach.single import prove
from worldgen.reach.single.prove import decide
from worldgen.reach.still import lattice_graph, path
from worldgen.reach.still.coarse import walk_squares
from worldgen.reach.still.cut import find_chain, rim_cells
from worldgen.reach.still.disc import Disc, beyond, is_away, target_disc, winds_around
from worldgen.reach.still.disc import _chain_lines as chain_lines
from worldgen.reach.still.disc import _inside as is_inside
from worldgen.reach.still.lattice_graph import (
    Graph,
    build_graph,
    find_path,
    flood,
    neighbour_shifts,
)
from worldgen.reach.still.path import clearance_sq, shorten
from worldgen.reach.still.target_poses import deciding_poses
from worldgen.reach.still.walls import Walls, segment_box_sq
from worldgen.support.ccall import check, pointer
from worldgen.world import Pose, Target, World

maps = hnp.arrays(np.bool_, st.tuples(st.integers(3, 9), st.integers(3, 9)), fill=st.just(False))
radii = st.sampled_from(RADII).map(lambda radius: Fraction(str(radius)))


def by_reference(world):
    """The reference's decision."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prove, "ask_still", lambda *_, **__: None)
        patch.setattr(prove, "find_chain", chain_of_reference)
        patch.setattr(prove, "deciding_poses", plain_poses)
        patch.setattr(prove, "build_graph", reference_rasters.build_graph)
        patch.setattr(prove, "find_path", graph_search.find_path)
        patch.setattr(prove, "shorten", paths.shorten)
        patch.setattr(path, "clearance_sq", paths.clearance_sq)
        return decide(world)


@pytest.mark.gate
@given(world=still_worlds())
def test_a_decision_is_that_of_the_reference_to_the_bit(world):
    assert decide(world) == by_reference(world)


@given(world=tight_worlds())
def test_a_decision_about_a_tight_world_is_that_of_the_reference_to_the_bit(world):
    assert decide(world) == by_reference(world)


@pytest.mark.parametrize("density", [0.05, 0.3])
def test_a_decision_about_scattered_cells_is_that_of_the_reference(density):
    walls = np.random.default_rng(1).random((40, 40)) < density
    walls[:3, :3] = walls[-3:, -3:] = False
    world = World(walls, Pose(0.15, 0.15), Target(3.85, 3.85, 0.05))
    assert decide(world) == by_reference(world)


def same_rasters(walls, radius, k):
    ours = build_graph(walls, radius, k)
    reference = reference_rasters.build_graph(walls, radius, k)
    return np.array_equal(ours.clear, reference.clear) and np.array_equal(
        ours.middle, reference.middle
    )


@pytest.mark.gate
@given(maps, radii, st.sampled_from([2, 3, 4]))
def test_rasters_are_those_of_the_reference(walls, radius, k):
    assert same_rasters(walls, radius, k)


def test_rasters_of_a_disc_wider_than_a_byte_counts_are_those_of_the_reference():
    walls = np.zeros((280, 280), bool)
    walls[0, 0] = walls[279, 100] = True
    assert build_graph(walls, Fraction(260, 2), 2).clear.any()
    assert same_rasters(walls, Fraction(260, 2), 2)


@st.composite
def graphs(draw, side=24):
    """Graphs of random clear nodes and midpoints, with a source, ends, spare ends and a preferred
    direction.
    """
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    clear, middle = (
        rng.random((side, side)) < draw(st.sampled_from([0.6, 0.8, 1.0])),
        rng.random((side, side)) < 0.8,
    )
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
    assert find_path(*asked) == graph_search.find_path(*asked)


@pytest.mark.gate
@given(graphs())
def test_a_search_that_is_stopped_looks_first_whether_there_is_a_way(asked):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lattice_graph, "_LOOK", 200)
        patch.setattr(lattice_graph, "_PORTION", 5)
        assert find_path(*asked) == graph_search.find_path(*asked)


@given(graphs(), st.data())
def test_a_search_over_bridges_finds_the_path_of_the_reference(asked, data):
    graph, sources, ends, spare, toward = asked
    free = st.sampled_from(np.flatnonzero(graph.clear).tolist())
    bridges = data.draw(st.lists(st.tuples(free, free), max_size=12))
    apart = [*sources, data.draw(free)]
    asked = (graph, apart, ends, spare, toward, bridges)
    assert find_path(*asked) == graph_search.find_path(*asked)


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
    joined = sparse.coo_matrix(
        (np.ones(len(pairs)), np.array(pairs).reshape(-1, 2).T), shape=(clear.size,) * 2
    )
    part = csgraph.connected_components(joined, directed=False)[1]
    seen = np.zeros(clear.size, np.uint8)
    graph_search.flood(clear, middle, graph.stride, sources[:1], seen)
    assert np.array_equal(seen > 0, part == part[sources[0]])
    assert np.array_equal(flood(graph, np.array(sources[:1])), seen > 0)


points = st.tuples(st.integers(0, 9 * UNIT), st.integers(0, 9 * UNIT))


@given(maps, radii, points, points)
def test_the_clearance_of_a_piece_is_the_least_distance_to_any_cell(walls, radius, p, q):
    of = Walls(walls, radius)
    assert clearance_sq(of, [p, q]) == min(
        Fraction(*segment_box_sq(p, q, cell)) for cell in of.near(p, q, 20 * UNIT)
    )


@st.composite
def drawn_paths(draw):
    """A map and a path through it, mostly of half cells."""
    walls, radius = draw(maps), draw(radii)
    half = st.integers(0, 16).map(lambda value: value * UNIT // 2)
    corners = draw(st.lists(st.tuples(half, half), min_size=1, max_size=8))
    for i in draw(st.sets(st.integers(0, len(corners) - 1), max_size=3)):
        corners[i] = (corners[i][0] + Fraction(1, 3), corners[i][1])
    return Walls(walls, radius), corners


@given(drawn_paths())
def test_shortening_goes_by_the_corners_of_the_reference(drawn):
    assert shorten(*drawn) == paths.shorten(*drawn)


@given(drawn_paths())
def test_the_clearance_of_a_path_is_the_fraction_of_the_reference(drawn):
    assert clearance_sq(*drawn) == paths.clearance_sq(*drawn)


def test_a_slanting_distance_that_equals_the_radius_is_clear_but_only_fractions_say_so():
    walls = np.zeros((15, 15), bool)
    # (7, 6.75) is 1.25 from its corner (6, 6), and so is the line at right angles through it.
    walls[5, 5] = True
    p, q = (11 * UNIT // 2, 35 * UNIT // 4), (17 * UNIT // 2, 19 * UNIT // 4)
    of = Walls(walls, Fraction(5, 4))
    state = np.array([0, 1, 1, 1, 2])
    kept = np.zeros(2, np.int64)
    x = np.array([p[0], q[0]])
    y = np.array([p[1], q[1]])
    arrays = [pointer(ffi, array, np.int64) for array in (x, y, state, kept)]
    done = ffi.new("int64_t *")
    whole = ffi.new("uint8_t[]", [1, 1])
    check(lib.wg_shorten(of.described, of.disc, *arrays[:2], whole, 2, 6, *arrays[2:], done))
    assert not done[0]
    assert shorten(of, [p, (q[0], p[1]), q]) == [p, q]


@pytest.mark.parametrize(
    "state",
    [
        (0, 1, 2, 2),
        (1, 1, 2, 1),
        (0, 0, 2, 1),
        (0, 3, 4, 1),
        (0, 1, 0, 1),
        (3, 4, 5, 1),
        (-1, 1, 2, 1),
    ],
)
def test_a_state_in_which_corners_would_be_kept_beyond_their_room_is_refused(state):
    of = Walls(np.zeros((5, 5), bool), Fraction(1))
    points = np.array([UNIT, 2 * UNIT, 3 * UNIT])
    kept = np.zeros(3, np.int64)
    arrays = [
        pointer(ffi, array, np.int64)
        for array in (points, points, np.array([*state, lib.WG_UNSURE]), kept)
    ]
    status = lib.wg_shorten(
        of.described, of.disc, *arrays[:2], b"\1\1\1", 3, 6, *arrays[2:], ffi.new("int64_t *")
    )
    assert status == lib.WG_BAD_VALUE


def chain_exists(world, radius, points):
    """Return whether a cycle of links winds around one of two poses.

    Examine every link, over (cell, bit).
    """
    rows, columns = np.nonzero(rim_cells(world.walls))
    cells = list(zip((columns - 1).tolist(), (rows - 1).tolist(), strict=True))
    number = {cell: index for index, cell in enumerate(cells)}
    half = linked_offsets(radius)[: len(linked_offsets(radius)) // 2]
    links = []
    for (x, y), (dx, dy) in itertools.product(cells, half):
        if (x + dx, y + dy) in number:
            a, b = number[x, y], number[x + dx, y + dy]
            ring = np.array([(x, y), (x + dx, y + dy), (x + dx, -2), (x, -2)])
            bit = winds_around(ring, points[0]) != winds_around(ring, points[1])
            links += [(2 * a, 2 * b + bit), (2 * a + 1, 2 * b + 1 - bit)]
    joined = sparse.coo_matrix(
        (np.ones(len(links)), np.array(links).reshape(-1, 2).T), shape=(2 * len(cells),) * 2
    )
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
        assert (find_chain(world.walls, radius, points[0], points[1:]) is not None) == expected


def chain_of_reference(solid, radius, start, targets):
    found = chains.find_chain(solid, radius, start, targets)
    return None if found is None else np.array(found, np.int64)


def clear_lattice_poses(world):
    walls = Walls(world.walls, Fraction(str(world.robot_radius)))
    poses = itertools.product(
        *(range(UNIT // 2, UNIT * side, UNIT) for side in (world.width, world.height))
    )
    return walls, [pose for pose in poses if walls.is_clear(pose, pose)]


@given(still_worlds(), st.integers(0, 99), st.integers(0, 99))
def test_a_chain_is_that_of_the_reference_cell_by_cell(world, first, last):
    walls, poses = clear_lattice_poses(world)
    assume(poses)
    ends = poses[first % len(poses)], [poses[last % len(poses)]]
    found = find_chain(walls.solid, walls.radius, *ends)
    expected = chain_of_reference(walls.solid, walls.radius, *ends)
    assert np.array_equal(found, expected) if found is not None else expected is None


@given(still_worlds(), st.integers(0, 99))
def test_a_chain_around_several_poses_is_that_of_the_reference(world, first):
    walls, poses = clear_lattice_poses(world)
    assume(poses)
    start = poses[first % len(poses)]
    apart = [
        pose for pose in poses if find_chain(walls.solid, walls.radius, start, [pose]) is not None
    ]
    assume(len(apart) > 1)
    ends = start, [apart[0], apart[-1]]
    found = find_chain(walls.solid, walls.radius, *ends)
    expected = chain_of_reference(walls.solid, walls.radius, *ends)
    assert np.array_equal(found, expected) if found is not None else expected is None


def test_a_chain_past_a_pose_that_is_no_lattice_point_is_that_of_the_reference():
    walls = np.zeros((7, 9), bool)
    walls[:, 4] = True
    for radius in (Fraction(7072, 10**4), Fraction(1, 10**30)):
        ends = (Fraction(5120, 3), 3600), [(Fraction(20480, 3), Fraction(11111, 3))]
        expected = chain_of_reference(walls, radius, *ends)
        assert find_chain(walls, radius, *ends).tolist() == expected.tolist()


def test_a_search_for_a_chain_in_small_portions_finds_the_same_one(monkeypatch):
    walls = np.random.default_rng(3).random((30, 30)) < 0.4
    walls[:3, :3] = walls[-3:, -3:] = False
    ends = (1536, 1536), [(29184, 29184)]
    whole = find_chain(walls, Fraction(7, 10), *ends)
    monkeypatch.setattr("worldgen.reach.still.cut._PORTION", 7)
    assert find_chain(walls, Fraction(7, 10), *ends).tolist() == whole.tolist()


@given(tight_worlds())
def test_the_poses_that_decide_are_those_that_fractions_find(world):
    walls, disc = Walls(world.walls, radius_in_cells(world)), target_disc(world)
    poses = deciding_poses(walls, disc)
    expected = list(dict.fromkeys(plain_poses(walls, disc)))
    assert list(dict.fromkeys(poses)) == expected


@given(st.sampled_from(["cave", "maze", "trap"]), st.integers(0, 99), st.floats(0.9, 1.5))
def test_lengths_of_many_digits_are_rounded_and_the_answer_is_that_of_fractions(name, seed, share):
    made = generate(name, seed, size=16)
    x, y = made.target.x + 0.012345678901234567, made.target.y - 0.0098765432109876543
    world = replace(made, target=Target(x, y, 0.03123456789012345), certificate=None)
    radius = made.certificate.clearance * share * 0.98765432109876543
    found = decide(world, radius=radius)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prove, "deciding_poses", plain_poses)
        assert decide(world, radius=radius).result == found.result
    proved = replace(world, robot_radius=radius, certificate=found.certificate)
    assert found.certificate is not None and check_certificate(proved).valid


@given(still_worlds())
def test_a_chain_parts_the_same_poses_in_c_and_in_fractions(world):
    walls, disc = Walls(world.walls, radius_in_cells(world)), target_disc(world)
    chain = np.array([(-1, -1), (-1, 2), (2, 3), (3, -1)], np.int64)
    poses = deciding_poses(walls, disc)
    lines = chain_lines(chain)
    start = (Fraction(UNIT, 3), UNIT)
    expected = [
        i for i, pose in enumerate(poses) if is_inside(lines, start) == is_inside(lines, pose)
    ]
    assert poses.first_unparted(chain, start) == (expected or [len(poses)])[0]


@given(tight_worlds())
def test_without_certificates_the_answer_is_the_same_and_no_cut_is_made(world):
    bare = decide(world, certificate=False)
    assert bare.result == decide(world).result
    assert bare.certificate is None


def test_an_answer_without_its_cut_still_has_its_witness():
    open_world = World(np.zeros((5, 5), bool), Pose(0.15, 0.15), Target(0.35, 0.35, 0.05))
    assert decide(open_world, cut=False) == decide(open_world)


places = st.integers(0, 6000).map(lambda n: Fraction(n * UNIT, 1000)) | st.integers(0, 12).map(
    lambda n: n * UNIT // 2
)
widths = st.sampled_from(
    [Fraction(0), Fraction(UNIT), Fraction(UNIT * 2, 3), Fraction(10**30 * UNIT + 1, 10**30)]
)


@given(st.tuples(places, places), places, places, widths | places)
def test_a_disc_is_beyond_a_ring_in_c_where_fractions_say_so(start, x, y, radius):
    ring = np.array([(1, 1), (1, 4), (3, 5), (5, 4), (4, 0)])
    lines = chain_lines(ring)
    parted = is_inside(lines, start) != is_inside(lines, (x, y))
    expected = parted and all(is_away(line, (x, y), radius) for line in lines)
    assert beyond(ring, start, Disc(x, y, radius)) == expected


@pytest.mark.gate
@given(world=still_worlds())
def test_a_way_over_whole_cells_is_a_proof_and_what_it_does_not_find_is_found_among_half_cells(
    world, monkeypatch
):
    usual = decide(world)
    monkeypatch.setattr(prove, "FROM_CELLS", 0)
    by_squares = decide(world)
    monkeypatch.undo()
    assert by_squares.result == usual.result
    assert by_squares.certificate is None or check_certificate(world, by_squares.certificate).valid


@given(hnp.arrays(np.bool_, (6, 7)), st.integers(1, 3), st.data())
def test_squares_get_wherever_they_are_joined_side_to_side(walls, side, data):
    free = np.zeros((8, 9), bool)
    for iy, ix in np.ndindex(7 - side, 8 - side):
        free[iy + 1, ix + 1] = not walls[iy : iy + side, ix : ix + side].any()
    assume(free.any())
    places = st.sampled_from(np.flatnonzero(free).tolist())
    source, goal = data.draw(places), data.draw(places)
    way = walk_squares(Walls(walls, Fraction(1)), side, source, goal)
    cells = walls.view(np.uint8)
    reference = coarse.walk_squares(
        cells, side, source, goal, np.zeros(72, np.uint8), np.zeros(7, np.int32)
    )
    assert way == reference.tolist()
    parts, _ = ndimage.label(free)
    joined = parts.ravel()[source] == parts.ravel()[goal]
    assert (len(way) > 0) == joined
    assert not joined or (way[0], way[-1]) == (source, goal)
