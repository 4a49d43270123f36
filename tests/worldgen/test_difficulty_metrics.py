"""Each metric, compared with a second computation and with known worlds, and under rotation,
mirroring and scaling.
"""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import worldgen.families.builtin.maze
import worldgen.families.parts.mazes
from benchmarks.along_the_path import around, samples_of
from tests.helpers.turned_worlds import mirrored, scaled, turned
from tests.worldgen.test_difficulty import drawn
from worldgen.difficulty import METRICS, measure
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.difficulty.nodes import nodes_of
from worldgen.difficulty.path import witness_path_of
from worldgen.difficulty.pockets import pockets
from worldgen.families.parts.mazes.board import ways_out
from worldgen.family import FAMILIES
from worldgen.generation import generate
from worldgen.reach import decide
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.grid_search import by_distance, squared_distances
from worldgen.world import Pose, Target, Witness, World

every_family = pytest.mark.parametrize("name", FAMILIES.names())


@every_family
def test_a_mirrored_world_has_the_same_metrics(name):
    world = generate(name, 5)
    assert measure(mirrored(world)) == measure(world)


@every_family
def test_a_world_turned_by_a_quarter_has_the_same_metrics(name):
    world = generate(name, 6)
    assert measure(turned(world)) == measure(world)


@every_family
def test_lengths_grow_with_the_world_and_all_else_stays(name):
    world = generate(name, 7)
    if world.is_dynamic:
        world = replace(world, timeline=type(world.timeline)(), certificate=None)
        world = replace(world, certificate=decide(world).certificate)
    small, large = measure(world).as_dict(), measure(scaled(world, 4.0)).as_dict()
    growth = {"m": 4.0, "s": 4.0, "rad/m": 0.25}
    assert large == pytest.approx(
        {name: v * growth.get(METRICS[name].unit, 1.0) for name, v in small.items()}, rel=1e-5
    )


def test_in_a_straight_corridor_the_robot_sees_its_walls():
    found = around(drawn("#######", "#S...G#", "#######"))
    assert (found["wall_distance"], found["characteristic_dimension"]) == (0.5, 1.0)
    along, across, slanted = 5.0, 1.0, 4 * math.sqrt(0.5)  # m: of two, two and four rays
    assert found["visibility"] == pytest.approx((along + across + slanted) / 8, rel=1e-5)


def test_dispersion_counts_changes_between_wall_and_free_within_three_cells():
    ground = np.zeros((9, 9), np.bool_)
    still = Witness(np.zeros(1), np.array([4.5]), np.array([4.5]), 0.5)
    world = World(ground, Pose(4.5, 4.5), Target(4.5, 4.5, 0.5), 1.0, 0.4, certificate=still)
    assert around(world)["dispersion"] == 0.0
    for cells, changes in (([(4, 6)], 2), ([(4, 6), (6, 4)], 4), ([(4, 7)], 2), ([(4, 8)], 0)):
        walls = ground.copy()
        walls[tuple(np.transpose(cells))] = True
        assert around(replace(world, walls=walls))["dispersion"] == changes


def test_a_u_before_the_robot_is_a_pocket_as_deep_as_its_arms():
    rows = [
        "###########",
        "#.........#",
        "#....G....#",
        "#.........#",
        "#.#######.#",
        "#.#.....#.#",
        "#.#.....#.#",
    ]
    world = drawn(*rows, "#.........#", "#....S....#", "###########", radius=0.3)
    found = measure(replace(world, certificate=None))
    # Under the crossbar the robot is 3 from the target; it passes an arm's foot at 3.5 to the side
    # and 5 below.
    assert found.concavity == pytest.approx(math.hypot(3.5, 5.0) - 3.0, rel=1e-5)
    assert found.retreat == pytest.approx(math.hypot(3.5, 5.0) - 6.0, rel=1e-5)


def test_where_every_way_leads_back_it_is_said_how_far():
    world = drawn("#########", "#G......#", "#######.#", "#...S...#", "#########")
    found = measure(replace(world, certificate=None))
    farthest = math.hypot(6, 2)  # the lower right corner
    assert found.retreat == pytest.approx(farthest - math.hypot(3, 2), rel=1e-5)
    assert found.concavity == pytest.approx(
        farthest - 2.0, rel=1e-5
    )  # the dead end is right below the target


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["maze", "cave", "forest", "trap"])
def test_pockets_are_those_of_a_search_over_levels(name, seed):
    world = generate(name, seed, size=16)
    nodes, way = nodes_of(world, world.walls), witness_path_of(world, world.certificate)
    deepest, retreat = pockets(nodes, way, target_disc(world))
    assert (deepest, retreat) == pytest.approx(_by_levels(world, nodes), abs=1e-6)


def _by_levels(world, nodes):
    """Compute concavity and retreat by finding, for every level, which nodes are connected below
    it.
    """
    clear, middle = nodes.graph.clear, nodes.graph.middle
    tx, ty = (float(value) / 512 for value in target_disc(world)[:2])
    reach = float(target_disc(world).radius) / 512
    away = {(int(x), int(y)): math.hypot(x - tx, y - ty) for y, x in np.argwhere(clear)}
    start = (round(world.start.x / world.cell_size * 2), round(world.start.y / world.cell_size * 2))

    def connected(level):
        group = [place for place, far in away.items() if far <= min(level, reach)]
        seen = set(group)
        while group:
            x, y = group.pop()
            for dx, dy in itertools.product((-1, 0, 1), repeat=2):
                other = (x + dx, y + dy)
                slanted = dx and dy and not middle[y + min(dy, 0), x + min(dx, 0)]
                if other not in seen and not slanted and away.get(other, math.inf) <= level:
                    seen.add(other)
                    group.append(other)
        return seen

    levels = sorted(set(away.values()))
    passes = {}
    for level in levels:
        for place in connected(level):
            passes.setdefault(place, level)
        if start in passes:
            break
    top = passes[start]
    depth = max(level - away[place] for place, level in passes.items())
    return 512 * depth, 512 * (top - away[start])


@pytest.mark.parametrize("passage", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("algorithm", ["wilson", "backtracker", "binary-tree"])
def test_decisions_in_a_perfect_maze_are_the_junctions_on_its_way(monkeypatch, passage, algorithm):
    made = {}
    real = worldgen.families.builtin.maze.grow

    def spied(*args, **settings):
        made["links"] = real(*args, **settings)
        return made["links"]

    monkeypatch.setattr(worldgen.families.builtin.maze, "grow", spied)
    size, radius = 2 + 8 * (passage + 1) - 1, 0.04 if passage == 1 else 0.07
    world = generate(
        "maze", 3, algorithm=algorithm, passage=passage, size=size, robot_radius=radius
    )
    assert around(world)["decisions"] == _junctions(world, made["links"], passage + 1)


def _junctions(world, links, pitch):
    """Chambers with three or more openings on the path along the tree from start to target."""
    start, target = (
        (int((end.x / world.cell_size - 1) // pitch), int((end.y / world.cell_size - 1) // pitch))
        for end in (world.start, world.target)
    )
    before, group = {start: None}, [start]
    while group:
        column, row = group.pop()
        for way in ways_out(links, column, row):
            other = (column + (1, 0, -1, 0)[way], row + (0, 1, 0, -1)[way])
            if other not in before:
                before[other] = (column, row)
                group.append(other)
    count = 0
    while target is not None:
        count += len(ways_out(links, *target)) >= 3
        target = before[target]
    return count


def test_open_ground_has_no_decisions():
    world = World(np.zeros((40, 40), np.bool_), Pose(0.3, 0.3), Target(3.7, 3.7, 0.05))
    assert around(replace(world, certificate=decide(world).certificate))["decisions"] == 0


def test_a_pillar_in_the_way_does_not_make_a_million_decisions():
    walls = np.zeros((40, 40), np.bool_)
    walls[15:25, 15:25] = True
    world = World(walls, Pose(0.3, 0.3), Target(3.7, 3.7, 0.05))
    assert around(replace(world, certificate=decide(world).certificate))["decisions"] <= 2


@st.composite
def _small_worlds(draw):
    height, width = draw(st.integers(3, 8)), draw(st.integers(3, 8))
    walls = np.array(
        draw(
            st.lists(
                st.sampled_from([0, 0, 0, 1]), min_size=height * width, max_size=height * width
            )
        )
    )
    x, y, tx, ty = (
        draw(st.integers(1, 4 * side - 1)) / 4 for side in (width, height, width, height)
    )
    reach = draw(st.sampled_from([0.25, 0.5, 1.5]))
    return World(walls.reshape(height, width) > 0, Pose(x, y), Target(tx, ty, reach), 1.0, 0.1)


@given(_small_worlds())
def test_the_bottleneck_is_the_widest_disc_that_the_prover_lets_through(world):
    radius = bottleneck(world, world.walls)
    assert radius < 0.016 or decide(world, radius=radius * (1 - 1e-6)).result == "reachable"
    assert decide(world, radius=max(radius * (1 + 1e-6), 0.016)).result == "blocked"


@given(st.integers(1, 12), st.integers(1, 12), st.data())
def test_squared_distances_are_those_to_the_nearest_mark(height, width, data):
    marks = np.array(
        data.draw(st.lists(st.booleans(), min_size=height * width, max_size=height * width)), bool
    )
    marks = marks.reshape(height, width)
    marks[0, 0] = True
    y, x = np.indices(marks.shape)
    expected = np.min([(x - mx) ** 2 + (y - my) ** 2 for my, mx in np.argwhere(marks)], axis=0)
    assert np.array_equal(squared_distances(marks), expected)


@given(
    hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))),
    st.integers(-99, 99),
    st.integers(-99, 99),
)
def test_nodes_come_in_the_order_of_their_distance(clear, x, y):
    expected = np.flatnonzero(clear)
    squares = (expected % clear.shape[1] * 7 - x) ** 2 + (expected // clear.shape[1] * 7 - y) ** 2
    order = np.argsort(squares, kind="stable")
    places, squared = by_distance(clear, 7, x, y)
    assert places.tolist() == expected[order].tolist()
    assert squared.tolist() == squares[order].tolist()


def test_samples_lie_in_the_middle_of_equal_parts():
    world = drawn("#######", "#S...G#", "#######")
    samples = samples_of(witness_path_of(world, world.certificate))
    assert samples.x.tolist() == [1.75 + 0.5 * k for k in range(8)]
    assert samples.weight.tolist() == [0.5] * 8


@given(
    hnp.arrays(
        np.bool_, st.tuples(st.integers(1, 90), st.integers(1, 60)), elements=st.just(False)
    ),
    st.data(),
)
def test_distances_above_the_most_that_matters_are_above_it(marks, data):
    marks = marks.copy()
    for _ in range(data.draw(st.integers(1, 30))):
        marks[
            data.draw(st.integers(0, marks.shape[0] - 1)),
            data.draw(st.integers(0, marks.shape[1] - 1)),
        ] = True
    most = data.draw(st.integers(0, 3000))
    y, x = np.indices(marks.shape)
    expected = np.min([(x - mx) ** 2 + (y - my) ** 2 for my, mx in np.argwhere(marks)], axis=0)
    found = squared_distances(marks, most)
    matters = expected <= most
    assert np.array_equal(found[matters], expected[matters])
    assert (found[~matters] > most).all()
    assert np.array_equal(squared_distances(marks), expected)
