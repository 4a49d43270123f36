"""Worlds drawn as text, and small random ones, for tests of reachability."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Pose, Target, World

# In cells: just below, at and just above half of the gaps 1, sqrt(2), 2, sqrt(5), sqrt(8), 3,
# sqrt(10) and 5.
RADII = (0.3, 0.5, 0.51, 0.7, 0.707, 0.71, 1.0, 1.01, 1.1, 1.118, 1.119, 1.41, 1.42, 1.5, 1.58, 2.5)


def drawn(text, *, radius=0.07, cell_size=0.1, target_radius=None, **others):
    """Return a world from rows of ``#``, ``.``, ``S`` (start) and ``G`` (target), the top row
    first.
    """
    rows = text.split()[::-1]
    walls = np.array([[letter == "#" for letter in row] for row in rows])
    places = {letter: (ix, iy) for iy, row in enumerate(rows) for ix, letter in enumerate(row)}

    def centre(letter):
        return [round((index + 0.5) * cell_size, 9) for index in places[letter]]

    reach = cell_size / 20 if target_radius is None else target_radius
    return World(
        walls,
        Pose(*centre("S")),
        Target(*centre("G"), reach),
        cell_size=cell_size,
        robot_radius=radius,
        **others,
    )


@st.composite
def still_worlds(draw):
    """Worlds of up to 9 x 9 cells that do not change, with start and target at multiples of half a
    cell.
    """
    width, height = draw(st.integers(2, 9)), draw(st.integers(2, 9))
    solid = draw(st.sets(st.integers(0, width * height - 1), max_size=width * height // 2))
    walls = np.isin(np.arange(width * height), list(solid)).reshape(height, width)
    x, y = st.integers(1, 2 * width - 1), st.integers(1, 2 * height - 1)
    start, target = (draw(st.tuples(x, y)) for _ in range(2))
    return World(
        walls,
        Pose(start[0] / 2, start[1] / 2),
        Target(target[0] / 2, target[1] / 2, draw(st.sampled_from([0.001, 0.5, 1.0]))),
        cell_size=1.0,
        robot_radius=draw(st.sampled_from(RADII) | st.integers(20, 200).map(lambda n: n / 100)),
    )


@st.composite
def tight_worlds(draw):
    """Worlds whose disc is a hair wider or narrower than a gap.

    Start and target anywhere, targets of any size.
    """
    width, height = draw(st.integers(3, 9)), draw(st.integers(3, 9))
    solid = draw(st.sets(st.integers(0, width * height - 1), max_size=width * height // 3))
    walls = np.isin(np.arange(width * height), list(solid)).reshape(height, width)
    gap, digits = (
        draw(st.sampled_from((1, 2, 4, 5, 8, 9, 10, 13, 16, 17, 18, 20, 25))),
        draw(st.sampled_from((1, 2, 6, 15))),
    )
    radius = (math.isqrt(gap * 100**digits // 4) + draw(st.integers(0, 1))) / 10**digits

    def place(side):
        halves, thousandths = (
            st.integers(0, n * side).map(lambda value, n=n: value / n) for n in (2, 1000)
        )
        return draw(halves | thousandths | st.just(min(radius, side)))

    reach = draw(st.sampled_from([0.01, 0.5, 1.0, 2.5, radius, round(2 * radius, 15)]))
    return World(
        walls,
        Pose(place(width), place(height)),
        Target(place(width), place(height), reach),
        cell_size=1.0,
        robot_radius=radius,
    )


@st.composite
def changing_worlds(draw):
    """Worlds of up to 6 x 6 cells of 0.1 m, some of which burn, close or open within 2 s."""
    width, height = draw(st.integers(3, 6)), draw(st.integers(3, 6))
    cells = st.tuples(st.integers(0, width - 1), st.integers(0, height - 1))
    walls = np.zeros((height, width), bool)
    for ix, iy in draw(st.sets(cells, max_size=5)):
        walls[iy, ix] = True
    ends = st.tuples(st.integers(0, width - 1), st.integers(0, height - 1))
    start, target = draw(ends), draw(ends)
    walls[start[1], start[0]] = False
    times = st.integers(0, 2000).map(lambda n: n / 1000)
    events = st.builds(
        lambda t, c, s: Event(t, c[0], c[1], s), times, cells, st.sampled_from(CellState)
    )
    return World(
        walls,
        Pose(*[round(0.1 * c + 0.05, 3) for c in start]),
        Target(*[round(0.1 * c + 0.05, 3) for c in target], 0.03),
        robot_radius=draw(st.sampled_from([0.03, 0.05, 0.06])),
        robot_speed=0.5,
        timeline=Timeline.of(draw(st.lists(events, max_size=12))),
    )
