"""The thesis's simulator has the same bits compiled and interpreted, and whole or in two halves."""

import numpy as np
import pytest

from sim.kernels import stepped_motion, thesis_signal
from sim.kernels import thesis_layout as at
from sim.kernels.thesis_episode import thesis_episode
from tests.replay_vectors import read_vectors, signal_cells, simulate
from tests.sim.test_thesis_vectors import DATA

VECTORS = {vector["id"]: vector for _, vector in read_vectors(DATA / "vectors.jsonl.gz")}


def plain(kernel):
    return getattr(kernel, "py_func", kernel)


@pytest.mark.parametrize("name", ["pub-021", "pub-060"])
def test_one_pixel_stepping_equals_its_python_twin(name):
    vector = VECTORS[name]
    cells, light = signal_cells(vector)
    rows = simulate(vector, cells, light, np.array(vector["draws"]), 200)[1]
    for row in rows[::7]:
        goal = (row[at.X] + 2.1, row[at.Y] - 1.7)
        one = stepped_motion.advance(cells, row[at.X], row[at.Y], *goal, 7.0)
        assert one == plain(stepped_motion.advance)(cells, row[at.X], row[at.Y], *goal, 7.0)


@pytest.mark.parametrize("name", ["pub-012", "pub-013"])
def test_the_signal_direction_equals_its_python_twin(name):
    vector = VECTORS[name]
    cells, light = signal_cells(vector)
    rows = simulate(vector, cells, light, np.array(vector.get("draws", [])), 300)[1]
    for row in rows[::11]:
        one = thesis_signal.signal_direction(cells, row[at.X], row[at.Y], 2)
        assert one == plain(thesis_signal.signal_direction)(cells, row[at.X], row[at.Y], 2)


def test_a_run_in_two_halves_is_the_whole_run():
    vector = VECTORS["pub-044"]
    cells, light = signal_cells(vector)
    whole = simulate(vector, cells, light, np.zeros(0), 1000)[0]
    setup = at.Setup(rule=vector["rule"], time_step=float(vector["timeSize"]), steps=400)
    progress, arena = at.new_progress(*map(float, vector["start"])), at.new_arena(cells, light)
    for steps in (400, 1000):
        thesis_episode(arena, setup._replace(steps=steps), progress, np.zeros(0), np.zeros((0, at.ROW_SIZE)))
    assert progress.counts[at.OUT_DIGEST] == whole.counts[at.OUT_DIGEST]
