"""Hypothesis strategies for small pieces, with every kind of cell, events and marks."""

from fractions import Fraction

import numpy as np
from hypothesis import strategies as st

from worldgen.compose import Piece
from worldgen.compose.marks import Mark
from worldgen.lattice import TURN
from worldgen.timeline import CellState, Timeline


@st.composite
def pieces(draw, most=7):
    """Pieces of up to ``most`` cells a side."""
    width, height = draw(st.integers(1, most)), draw(st.integers(1, most))
    cells = st.lists(st.sampled_from("#._"), min_size=width * height, max_size=width * height)
    text = np.array(draw(cells)).reshape(height, width)
    event = st.tuples(
        st.sampled_from([0.0, 0.5, 1.0, 2.5]),
        st.integers(0, width - 1),
        st.integers(0, height - 1),
        st.sampled_from(list(CellState)),
    )
    mark = st.builds(
        Mark,
        st.integers(0, 2 * width).map(lambda half: Fraction(half, 2)),
        st.integers(0, 2 * height).map(lambda half: Fraction(half, 2)),
        st.none() | st.integers(0, TURN - 1),
    )
    marks = draw(st.dictionaries(st.sampled_from(["start", "target", "a"]), mark))
    return Piece(text == "#", text != "_", marks, Timeline.of(draw(st.lists(event, max_size=8))))


def states_at(piece, time):
    """Return the state of each cell at a time.

    (height, width) of 0 free, 1 solid, 2 burning, 3 unspecified.
    """
    states = np.where(piece.mask, piece.solid.astype(int), 3)
    for event in piece.timeline:
        if event.time <= time:
            states[event.iy, event.ix] = int(event.state)
    return states
