"""The library's Q-learning robot: its table is the result of training, and the robot has learned
something.
"""

import re

import numpy as np
import pytest

from benchmarks.thesis_faults import draw_worlds
from benchmarks.train_q_learning import TABLE, as_c, train
from sim import simulate
from sim.controllers.library.q_learning import (
    SITUATIONS,
    TURNS,
    best_turns,
    q_learning,
    q_learning_robot,
)
from tests.helpers.halls import cup, hall
from tests.helpers.interpreted import Interpreted


@pytest.mark.nightly
def test_training_gives_the_same_table_twice_and_another_for_another_seed():
    tables = [train(episodes=12, seed=seed).tolist() for seed in (1, 1, 2)]
    assert tables[0] == tables[1] != tables[2]


@pytest.mark.nightly
def test_the_shipped_table_is_what_training_gives():
    assert as_c(train()) == TABLE.read_text(encoding="utf-8")


def _table_of(text):
    return np.array(re.findall(r"-?\d+", text[text.index("{") :]), np.int64).reshape(
        SITUATIONS, len(TURNS)
    )


def test_the_shipped_table_is_written_as_it_was_read():
    text = TABLE.read_text(encoding="utf-8")
    assert as_c(_table_of(text)) == text


def test_the_shipped_table_as_one_s_own_drives_bit_for_bit_alike():
    own = q_learning_robot(_table_of(TABLE.read_text(encoding="utf-8")))
    runs = [simulate(cup(), one, steps=300, record=True).trace for one in (q_learning, own)]
    assert np.array_equal(runs[0].x, runs[1].x) and np.array_equal(runs[0].heading, runs[1].heading)


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
