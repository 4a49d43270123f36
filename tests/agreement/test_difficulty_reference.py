"""The C core finds the same pockets as plain Python."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.reference.worldgen import pockets
from worldgen import generate
from worldgen.difficulty import pockets as pockets_module
from worldgen.difficulty.nodes import nodes_of

SEEDS = st.integers(0, 2**32)
NAMES = st.sampled_from(["maze", "forest", "cave", "rubble"])


def neighbours(stride):
    """Return the eight steps and their midpoints."""
    steps = [1, -1, stride, -stride, stride + 1, -stride - 1, stride - 1, 1 - stride]
    return steps, [0, 0, 0, 0, 0, -stride - 1, -1, -stride]


def nodes_drawn(name, seed):
    world = generate(name, seed, size=14)
    return nodes_of(world, world.walls)


@pytest.mark.gate
@given(NAMES, SEEDS)
@settings(max_examples=20, deadline=None)
def test_pockets_are_those_of_the_reference(name, seed):
    nodes = nodes_drawn(name, seed)
    graph = nodes.graph
    places = np.flatnonzero(graph.clear)
    goal, start = (int(places[seed % (k + 1) * len(places) // (k + 1)]) for k in (1, 2))
    x = goal % graph.stride
    y = goal // graph.stride
    squared = (places % graph.stride - x) ** 2 + (places // graph.stride - y) ** 2
    order = np.argsort(squared, kind="stable")
    places = places[order]
    squared = squared[order]
    at_start = int(squared[places == start][0])

    rank = np.full(graph.clear.size, -1)
    rank[places] = np.arange(len(places))
    role = np.zeros(graph.clear.size, int)
    role[start] = 2
    role[goal] |= 1
    joined = [0] * (2 * len(places))
    top, count = pockets.flood(
        places.tolist(), squared.tolist(), graph.middle.ravel().tolist(), rank.tolist(), *neighbours(graph.stride),
        at_start, [-1] * len(places), list(range(len(places))), role[places].tolist(), joined,
    )  # fmt: skip
    expected = list(zip(joined[: 2 * count : 2], joined[1 : 2 * count : 2], strict=True))
    assert pockets_module._flooded(nodes, places, squared, [goal], [start], at_start) == (
        top,
        expected,
    )
