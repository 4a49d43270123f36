"""The signal's sensor, which takes short cuts where it can, follows the thesis's rule."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.core_parts import heading_of, signal_heading
from tests.reference.sim.layout import FREE, UNIT

SIDE = 6
PLACE = st.integers(0, SIDE * UNIT - 1)
CELLS = st.lists(st.integers(0, 2), min_size=SIDE * SIDE, max_size=SIDE * SIDE)
CENTRED = st.integers(0, SIDE - 1).map(lambda index: index * UNIT + UNIT // 2)


def by_the_rule(cells, x, y, target_x, target_y, heading):
    """All nine cells, the robot's own first, then rows from the top.

    A later one wins if it is free and stronger.
    """
    ix, iy, own_target = x // UNIT, y // UNIT, (target_x // UNIT, target_y // UNIT)

    def weakness(cell):
        centre = [UNIT * index + UNIT // 2 for index in cell]
        return (
            0 if cell == own_target else (centre[0] - target_x) ** 2 + (centre[1] - target_y) ** 2
        )

    best = (ix, iy)
    for cell in [(ix + i, iy + j) for j in (1, 0, -1) for i in (-1, 0, 1)]:
        inside = 0 <= cell[0] < SIDE and 0 <= cell[1] < SIDE
        if inside and cells[cell[1], cell[0]] == FREE and weakness(cell) < weakness(best):
            best = cell
    aim = (
        (target_x, target_y) if best == own_target else [UNIT * index + UNIT // 2 for index in best]
    )
    return heading_of(aim[0] - x, aim[1] - y, heading)


@given(CELLS, PLACE, PLACE, PLACE | CENTRED, PLACE | CENTRED)
def test_the_signal_leads_to_the_strongest_free_cell(drawn, x, y, target_x, target_y):
    cells = np.array(drawn, np.uint8).reshape(SIDE, SIDE)
    expected = by_the_rule(cells, x, y, target_x, target_y, 77)
    assert signal_heading(cells, x, y, target_x, target_y, 77) == expected
