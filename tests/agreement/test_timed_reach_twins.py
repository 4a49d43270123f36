"""In worlds that change, the prover's C gives the same results as the reference, bit for bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.drawn_worlds import changing_worlds, drawn
from tests.reference.worldgen import timed as reference
from worldgen import generate
from worldgen.reach import REACHABLE, decide, decide_in_time, latest_start
from worldgen.reach.timed import confine, earliest, latest
from worldgen.timeline import CellState, Timeline

BURNING = CellState.BURNING


def spread_out(states, shape, goal, sources):
    came = [-1] * len(states.tile)
    lists = [getattr(states, name).tolist() for name in ("first", "tile", "low", "high")]
    reached = reference.spread_out(*lists, goal.tolist(), shape[1], shape[0], sources, came)
    return np.array(came, np.int64), reached


def by_reference(ask, *args):
    """The reference's answer."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (confine, earliest, latest):
            patch.setattr(module, "safe_intervals", reference.safe_intervals)
        patch.setattr(earliest, "_search", reference.search)
        patch.setattr(confine, "_spread_out", spread_out)
        return ask(*args)


def same_confinement(one, other):
    if one is None or other is None:
        return one is other
    return np.array_equal(one.stays, other.stays)


@given(changing_worlds())
def test_a_decision_about_a_changing_world_is_that_of_the_reference(world):
    assert decide(world) == by_reference(decide, world)


@given(changing_worlds(), st.sampled_from([None, 1.0, 4.0]))
def test_the_latest_start_is_that_of_the_reference(world, deadline):
    assert latest_start(world, deadline) == by_reference(latest_start, world, deadline)


@pytest.mark.gate
@given(changing_worlds(), st.sampled_from([None, 0.5, 2.0]))
def test_a_confinement_is_that_of_the_reference(world, deadline):
    ours = decide_in_time(world, deadline)
    theirs = by_reference(decide_in_time, world, deadline)
    assert ours.result == theirs.result
    assert same_confinement(ours.confinement, theirs.confinement)


def test_a_timed_path_past_many_fires_is_that_of_the_reference(monkeypatch):
    monkeypatch.setattr(earliest, "_PORTION", 50)
    rng = np.random.default_rng(3)
    events = [
        (round(rng.uniform(0, 3), 3), *rng.integers(3, 17, 2).tolist(), BURNING) for _ in range(150)
    ]
    picture = "\n".join(["." * 19 + "G"] + ["." * 20] * 18 + ["S" + "." * 19])
    world = drawn(picture, radius=0.05, robot_speed=0.5, timeline=Timeline.of(events))
    assert decide(world).result == REACHABLE
    assert decide(world) == by_reference(decide, world)


def test_a_burning_house_confines_the_robot_as_in_the_reference(monkeypatch):
    monkeypatch.setattr(confine, "_PORTION", 50)
    world = generate("fire", 2, size=16, over="rooms")
    deadline = 0.8 * world.certificate.duration
    ours = decide_in_time(world, deadline).confinement
    assert len(ours.stays)
    assert same_confinement(ours, by_reference(decide_in_time, world, deadline).confinement)
