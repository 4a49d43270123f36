"""The library's Q-learning robot: that its table is what training gives, and what it has learnt."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.thesis_faults import draw_worlds
from benchmarks.train_q_learning import as_module, train
from sim import simulate
from sim.controllers.library import _q_table
from sim.controllers.library.q_learning import SITUATIONS, TURNS, best_turns, q_learning, q_learning_robot, table_of
from tests.helpers.halls import cup, hall
from tests.helpers.interpreted import Interpreted


@pytest.mark.gate
def test_training_gives_the_same_table_twice_and_another_for_another_seed():
    tables = [train(episodes=12, seed=seed).tolist() for seed in (1, 1, 2)]
    assert tables[0] == tables[1] != tables[2]


@pytest.mark.nightly
def test_the_shipped_table_is_what_training_gives():
    assert as_module(train()) == Path(_q_table.__file__).read_text(encoding="utf-8")


def test_a_table_read_back_from_its_module_is_the_same():
    table = np.arange(SITUATIONS * len(TURNS)).reshape(SITUATIONS, len(TURNS))
    names = {}
    exec(as_module(table), names)
    assert (table_of(names["TABLE"]) == table).all()


@pytest.mark.parametrize(("kind", "least"), [("scattered", 14), ("one U", 14)])
def test_it_arrives_in_most_worlds_that_it_was_not_trained_in(kind, least):
    verdicts = [simulate(world, q_learning).verdict for world in draw_worlds(kind, 20, seed=77)]
    assert verdicts.count("reached") >= least


def test_an_empty_table_arrives_nowhere_that_it_does_not_face():
    blank = q_learning_robot(np.zeros((SITUATIONS, len(TURNS)), np.int64))
    assert simulate(hall(), blank).verdict == "loop"


def test_of_equal_turns_the_first_is_taken():
    table = np.zeros((SITUATIONS, len(TURNS)), np.int64)
    table[5, 3] = 1
    assert best_turns(table)[[4, 5]].tolist() == [0, 3]


def test_compiled_and_interpreted_drive_bit_for_bit_alike():
    compiled = simulate(cup(), q_learning, steps=300)
    assert simulate(cup(), Interpreted(q_learning), steps=300).trace_digest == compiled.trace_digest
