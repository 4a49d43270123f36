"""The thesis's signal is implemented twice, for files and for runs, with the same numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.thesis.core_calls import WALL, add_noise, signal_map
from worldgen.interop.formats.thesis import WALL as FILE_WALL
from worldgen.interop.formats.thesis import filtered, signal

SIDES = st.integers(3, 24)


@st.composite
def maps(draw):
    """Walls, (n, n) bool, top row first, with a closed border, and the target's column and row."""
    size = draw(SIDES)
    inner = st.integers(1, size - 2)
    target = draw(inner), draw(inner)
    walls = np.ones((size, size), bool)
    walls[1:-1, 1:-1] = False
    for x, y in draw(st.lists(st.tuples(inner, inner), max_size=60)):
        walls[y, x] = (x, y) != target
    return walls, target


@pytest.mark.gate
@given(maps())
def test_signal_and_noise_of_files_are_those_of_runs(drawn):
    walls, target = drawn
    light = signal_map(len(walls), len(walls), *target)
    cells = light.copy()
    cells[walls.T] = WALL
    plain = signal(walls, target)
    assert FILE_WALL == WALL and np.array_equal(plain, cells.T)
    add_noise(cells, light)
    assert np.array_equal(filtered(plain, target), cells.T)
