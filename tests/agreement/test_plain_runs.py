"""Plain runs, for which the core has a separate loop, end like the same runs with a digest.

It have not.
"""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import RunOptions
from sim.controllers import CONTROLLERS
from sim.episode import prepare
from worldgen import generate

NAMES = ["turn-right", "turn-random", "random-walk", "bug2", "tangent-bug", "mapper", "q-learning"]
FAMILIES = ["maze", "trap", "rooms", "forest", "corridor"]


def outcomes_of(family, seed, name, motion, steps):
    """Return the outcomes of the plain run and of the one with a digest."""
    controller = CONTROLLERS.get(name)
    run = prepare(
        generate(family, seed, size=24), controller, RunOptions(motion, steps, 0.03, seed)
    )
    ends = [run.run(steps, find_loop=True, record=False, digest=digest) for digest in (False, True)]
    return [replace(end, digest="") for end in ends]


@pytest.mark.gate
@settings(deadline=None, max_examples=300)
@given(
    st.sampled_from(FAMILIES),
    st.integers(0, 2**32),
    st.sampled_from(NAMES),
    st.sampled_from(["swept", "endpoint"]),
    st.integers(1, 20_000),
)
def test_plain_runs_of_any_length_end_as_the_same_with_a_digest(family, seed, name, motion, steps):
    plain, other = outcomes_of(family, seed, name, motion, steps)
    assert plain == other
