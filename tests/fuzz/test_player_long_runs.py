"""A controller's memory takes little room, however large it is and however long it drives."""

import tracemalloc

import numpy as np
import pytest

from fuzz.player import drawn_run
from fuzz.player.memory import BLOCKED
from sim import simulate
from sim.controllers import CONTROLLERS
from sim.runners.long_runs import MOST_HELD
from tests.fuzz.test_player_memory import room, shapes
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter

LITTLE = 1 << 21


@pytest.fixture
def little(monkeypatch):
    monkeypatch.setattr("sim.runners.lattice.MOST_HELD", LITTLE)
    monkeypatch.setattr("sim.runners.long_runs.MOST_HELD", LITTLE)


def driven(*, lean, steps=2000):
    """Run the mapper for this many steps, in a room where it reaches its target late."""
    world = room(speed=0.1)
    episode = simulate(world, "mapper", record=True, lean=lean, steps=steps, time_step=0.004)
    return episode, drawn_run(episode, world.cell_size, controller=CONTROLLERS.get("mapper"))


@pytest.mark.gate
def test_a_lean_recording_is_the_whole_one_without_its_memory(little):
    (whole, _), (lean, _) = driven(lean=False), driven(lean=True)
    assert whole.trace.states.shape[1] > 1000 and lean.trace.states.shape[1] == 5
    for name in ("x", "y", "heading", "bump", "path_x", "path_y", "path_step", "path_share"):
        assert np.array_equal(getattr(whole.trace, name), getattr(lean.trace, name))
    assert lean.trace_digest == whole.trace.digest()


@pytest.mark.gate
def test_a_lean_recording_recalls_the_memory_of_any_step(little):
    (whole, _), (lean, _) = driven(lean=False), driven(lean=True)
    for step in (0, 1, 777, lean.steps):
        assert np.array_equal(whole.trace.memory(step), lean.trace.memory(step))


def test_the_page_gets_the_same_memory_of_a_lean_recording(little):
    (_, whole), (_, lean) = driven(lean=False), driven(lean=True)
    assert lean["memory"]["map"] and lean == whole


def test_what_a_long_run_and_its_page_hold_does_not_grow_with_the_memory(little):
    driven(lean=True)  # anything that is made once
    tracemalloc.start()
    episode, _ = driven(lean=True, steps=4000)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    every_word = 8 * episode.steps * episode.trace.memory_size
    assert episode.steps == 4000 and peak < every_word / 2


def test_a_short_run_is_recorded_whole_even_so():
    episode, _ = driven(lean=True)
    assert (
        8 * episode.trace.states.size < MOST_HELD and episode.trace.digest() == episode.trace_digest
    )


def test_a_lean_recording_has_no_words_for_a_digest(little):
    episode, _ = driven(lean=True)
    with raises(InvalidParameter, "recording-is-lean"):
        episode.trace.digest()


def test_of_many_changes_the_last_map_is_always_held(monkeypatch):
    monkeypatch.setattr("fuzz.player.memory._MOST_MAPS", 4)
    episode, few = driven(lean=False)
    monkeypatch.undo()
    _, many = driven(lean=False)
    places = [
        {(row["kind"], row["x0"], row["y0"]) for row in shapes(run, BLOCKED, episode.steps)}
        for run in (few, many)
    ]
    assert places[0] == places[1] != set()
