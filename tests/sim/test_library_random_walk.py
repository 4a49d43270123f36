"""The random walk."""

import numpy as np
import pytest

from sim import simulate
from sim.controllers.library.random_walk import random_walk
from tests.helpers.drawn_worlds import drawn
from tests.helpers.interpreted import Interpreted
from worldgen import generate

LEG = 0.5  # m
ROOM = drawn(".......\n.....G.\n" + ".......\n" * 3 + ".S.....\n.......")
HALL = drawn(
    "\n".join(["." * 41] * 20 + ["." * 20 + "S" + "." * 20] + ["." * 41] * 19 + ["G" + "." * 40])
)


@pytest.mark.parametrize("seed", range(10))
def test_it_arrives_in_a_small_room_in_the_end(seed):
    assert simulate(ROOM, random_walk, seed=seed, steps=100_000).verdict == "reached"


def test_other_seeds_walk_other_ways():
    assert (
        len({simulate(ROOM, random_walk, seed=seed, steps=100).trace_digest for seed in range(10)})
        == 10
    )


def test_its_legs_are_equally_long_where_no_wall_ends_them():
    trace = simulate(HALL, random_walk, seed=4, steps=50, record=True).trace
    turns = np.flatnonzero(np.diff(trace.heading)) + 1
    corners = np.stack([trace.x[turns], trace.y[turns]], axis=1)
    assert not trace.bump.any() and len(turns) >= 3
    assert np.linalg.norm(np.diff(corners, axis=0), axis=1) == pytest.approx(LEG, abs=0.005)


def test_a_run_is_the_same_compiled_and_interpreted():
    runs = [
        simulate(generate("maze", 3, size=20), one, seed=7, steps=500)
        for one in (random_walk, Interpreted(random_walk))
    ]
    assert runs[0].trace_digest == runs[1].trace_digest
