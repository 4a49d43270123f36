"""PIBT as a controller: robots that back out, never touch, and provably block each other."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim import Command, simulate
from sim.controllers.library import pibt
from sim.options.robot import RobotOptions
from worldgen.generation import generate
from worldgen.world import Pose, Robot, Target, World


def hall(robots, *, width=12, height=8, walls=()):
    """A hall with a wall around it, and robots given as (start, target), m, with cells of 0.1 m."""
    solid = np.zeros((height, width), np.bool_)
    solid[[0, -1], :] = solid[:, [0, -1]] = True
    for ix, iy in walls:
        solid[iy, ix] = True
    placed = [
        Robot(Pose(*start, 0.0), Target(*target, 0.02), radius=0.04, speed=2.0)
        for start, target in robots
    ]
    return World(walls=solid, robots=placed)


def open_map(width, height, walls=()):
    """A map with this many clear nodes, starting at (1, 1), and a rim that is not clear."""
    columns = width + 2
    clear = [
        0 < x <= width and 0 < y <= height and (x, y) not in walls
        for y in range(height + 2)
        for x in range(columns)
    ]
    words = tuple(
        float(sum(bit << k for k, bit in enumerate(clear[first : first + 52])))
        for first in range(0, len(clear), 52)
    )
    return pibt._Map(words, columns)


def agent(priority, node, target, radius):
    return pibt._Agent(float(priority), node, radius, pibt._Target(*target, 0.1))


def moves_of(grid, agents, others=()):
    ordered = tuple(sorted(agents, reverse=True))
    plan = pibt._plan(grid, ordered, tuple(others))
    return {one: plan[one] for one in ordered}


def nearest(one, move, other, other_move):
    """Return how near two agents come during their moves, from 1,000 points in time."""
    return min(
        math.hypot(
            other.node[0] - one.node[0] + share * (other_move[0] - move[0]),
            other.node[1] - one.node[1] + share * (other_move[1] - move[1]),
        )
        for share in np.linspace(0.0, 1.0, 1_001)
    )


def spread(nodes, radius):
    """Keep the nodes at which discs do not overlap."""
    kept = []
    for node in nodes:
        if all(math.dist(node, other) >= 2 * radius for other in kept):
            kept.append(node)
    return kept


NODES = st.tuples(st.integers(1, 10), st.integers(1, 10))


@given(
    st.integers(3, 10),
    st.integers(3, 10),
    st.lists(NODES, max_size=20),
    st.lists(NODES, min_size=2, max_size=40, unique=True),
    st.lists(NODES, min_size=40, max_size=40),
    st.sampled_from([0.5, 0.6, 0.8, 1.0, 1.4]),
)
def test_no_two_moves_of_a_plan_touch(width, height, walls, nodes, targets, radius):
    grid = open_map(width, height, walls)
    there = [(x, y) for x, y in nodes if x <= width and y <= height and (x, y) not in walls]
    agents = [
        agent(k, node, target, radius)
        for k, (node, target) in enumerate(zip(spread(there, radius), targets, strict=False))
    ]
    moves = moves_of(grid, agents)
    assert moves.keys() == set(agents)
    for (one, move), (other, other_move) in itertools.combinations(moves.items(), 2):
        assert nearest(one, move, other, other_move) >= one.radius + other.radius - 1e-6


def test_an_agent_that_cannot_leave_is_not_forgotten_by_those_who_push_it():
    # The first pushes the second and the third; the second pushes the third, which cannot leave.
    # It then stays in the way of the first, whatever the second does.
    agents = [
        agent(5, (3, 1), (2, 2), 0.6),
        agent(3, (3, 3), (4, 1), 0.6),
        agent(2, (4, 2), (5, 1), 0.6),
        agent(0, (5, 3), (1, 1), 0.6),
    ]
    moves = moves_of(open_map(5, 3), agents)
    for (one, move), (other, other_move) in itertools.combinations(moves.items(), 2):
        assert nearest(one, move, other, other_move) >= 1.2 - 1e-6


@given(st.lists(NODES, min_size=2, max_size=60, unique=True), NODES)
def test_the_highest_priority_always_gets_nearer_among_narrow_robots(nodes, target):
    # Lemma 1 of the paper: on a graph in which each edge is on a cycle. A robot of radius 0.3
    # edges can follow another one around a corner.
    grid = open_map(10, 10)
    agents = [agent(k, node, target, 0.3) for k, node in enumerate(nodes)]
    first = agents[-1]
    move = moves_of(grid, agents)[first]
    distances = pibt._distances(grid, first.target)
    before, after = (pibt._edges_from(node, distances) for node in (first.node, first.after(move)))
    assert after == max(0, before - 1)


def test_robots_that_meet_in_a_passage_both_arrive_because_one_backs_out():
    # A passage of one cell between two rooms.
    walls = [(ix, iy) for ix in range(4, 9) for iy in (1, 2, 3, 5, 6)]
    world = hall(
        [((0.25, 0.45), (1.05, 0.45)), ((1.05, 0.25), (0.15, 0.25))], width=13, walls=walls
    )
    episode = simulate(world, "pibt")
    assert episode.verdict == "reached"
    assert [one.collisions for one in episode.robots] == [0, 0]
    assert simulate(world, "naive").verdict == "starved"


def test_robots_that_must_swap_in_a_dead_end_provably_never_do():
    walls = [(ix, iy) for ix in range(1, 11) for iy in (1, 2, 3, 5, 6)]
    world = hall([((0.25, 0.45), (0.85, 0.45)), ((0.95, 0.45), (0.15, 0.45))], walls=walls)
    episode = simulate(world, "pibt")
    assert episode.verdict == "deadlock" and episode.evidence.waiting == (1, 2)


def test_an_arrived_robot_that_closes_the_way_is_an_obstacle():
    walls = [(ix, iy) for ix in range(1, 11) for iy in (1, 2, 3, 5, 6)]
    world = hall([((0.65, 0.45), (0.75, 0.45)), ((0.25, 0.45), (1.05, 0.45))], walls=walls)
    episode = simulate(world, "pibt")
    assert episode.verdict == "starved" and episode.evidence.waiting == (2,)
    assert sum(one.collisions for one in episode.robots) == 0


def test_the_robots_numbers_have_no_effect():
    world = generate("crossing", 4, robots=5)
    robots = world.robots
    turned = (*robots[2:], *robots[:2])
    other = replace(world, robots=turned, certificate=None, provenance=None)
    one = simulate(world, "pibt")
    two = simulate(other, "pibt")
    assert one.verdict == two.verdict and one.steps == two.steps
    digests = [run.trace_digest for run in one.robots]
    assert [run.trace_digest for run in two.robots] == [*digests[2:], *digests[:2]]


def test_it_takes_a_robot_with_another_controller_for_an_obstacle():
    world = hall([((0.25, 0.25), (0.95, 0.25)), ((0.95, 0.65), (0.25, 0.65))])
    episode = simulate(world, {1: "pibt", 2: "naive"})
    assert episode.verdict == "reached"


@pytest.mark.parametrize("radius", [0.03, 0.07])
def test_alone_it_takes_a_shortest_path_of_the_grid(radius):
    world = replace(generate("rooms", 3), robot_radius=radius, certificate=None, provenance=None)
    episode = simulate(world, "pibt")
    assert episode.verdict == "reached" and episode.collisions == 0
    edge = world.cell_size / 2
    grid = pibt._Map(*pibt_memory_map(world))
    target = pibt._Target(world.target.x / edge, world.target.y / edge, world.target.radius / edge)
    start = (round(world.start.x / edge), round(world.start.y / edge))
    length = pibt._edges_from(start, pibt._distances(grid, target)) * edge
    # It ends as soon as its centre is in the target, whose radius is one edge.
    rounding = 2 * world.cell_size / 1024
    assert episode.path_length == pytest.approx(length - world.target.radius, abs=rounding)


def pibt_memory_map(world):
    memory = pibt.pibt.reset(world)
    return memory[pibt._MAP :], int(memory[pibt._COLUMNS])


def test_a_robot_pushed_off_the_grid_returns_to_it():
    world = generate("rooms", 3)
    pushed = simulate(world, "pibt", pushes=(0.3, 0.013, 0.021, 0.4))
    assert pushed.verdict == "reached"


@pytest.mark.parametrize("numbers", [0, 1, 2, 4, 6, 8])
def test_messages_of_another_length_do_not_crash_it(numbers):
    world = generate("crossing", 4, robots=3)
    assert simulate(world, "pibt", message=numbers).verdict != "crash"


@dataclass(frozen=True)
class Shouting:
    """Stands still, and sends numbers with a different meaning."""

    numbers: tuple[float, ...] = ()
    senses = ("time_step",)
    needs = RobotOptions(neighbour_range=10.0, message=8)

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(message=self.numbers), memory


@pytest.mark.parametrize(
    "numbers", [(1e300, 1e300, 1e300, 5.0, 2.0, 0.0, 0.0, 0.0), (1e308,) * 8, (-1.0,) * 8, ()]
)
def test_what_another_controller_sends_is_not_believed(numbers):
    world = hall([((0.25, 0.25), (0.95, 0.25)), ((0.95, 0.65), (0.25, 0.65))])
    episode = simulate(world, {1: "pibt", 2: Shouting(numbers)}, steps=500)
    assert episode.robots[0].verdict == "reached"


@pytest.mark.nightly
def test_twenty_robots_in_an_alley_never_touch():
    # A plan in which two agents touched made six of them collide.
    episode = simulate(generate("alley", 1, robots=20), "pibt")
    assert sum(one.collisions for one in episode.robots) == 0
