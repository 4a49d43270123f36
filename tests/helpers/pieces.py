"""Hypothesis strategies for small pieces, with every kind of cell, events, start and target."""

import numpy as np
from hypothesis import strategies as st

from worldgen.compose import Piece
from worldgen.timeline import CellState, Timeline


@st.composite
def pieces(draw, least=1, most=7):
    """Pieces of up to ``most`` cells a side."""
    width, height = draw(st.integers(least, most)), draw(st.integers(least, most))
    cells = st.lists(st.booleans(), min_size=width * height, max_size=width * height)
    event = st.tuples(
        st.sampled_from([0.0, 0.5, 1.0, 2.5]),
        st.integers(0, width - 1),
        st.integers(0, height - 1),
        st.sampled_from(list(CellState)),
    )
    events = draw(st.lists(event, max_size=8, unique_by=lambda one: one[:3]))
    solid = np.array(draw(cells)).reshape(height, width)
    piece = Piece(
        solid, timeline=Timeline.of(sorted(events, key=lambda one: (one[0], one[2], one[1])))
    )
    x, y = (st.integers(0, 2 * side).map(lambda half: half / 2) for side in (width, height))
    if draw(st.booleans()):
        degrees = draw(st.none() | st.integers(0, 719).map(lambda half: half * 0.5))
        piece = piece.with_start(draw(x), draw(y), degrees=degrees)
    return piece.with_target(draw(x), draw(y)) if draw(st.booleans()) else piece


def states_at(piece, time):
    """Return the state of each cell at a time: (height, width) of 0 free, 1 solid, 2 burning."""
    states = piece.solid.astype(int)
    for event in piece.timeline:
        if event.time <= time:
            states[event.iy, event.ix] = int(event.state)
    return states
