"""Hypothesis strategies for worlds with every optional part, and for damaged ``.grid`` text.

The worlds are valid but not sensible: a start may be in a wall, and a witness may prove nothing.
Use them for properties that must hold for every world.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from worldgen.domain import CELL_SIZES, LATEST, RADII, SPEEDS
from worldgen.errors import InvalidWorld
from worldgen.files.grid import dumps
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import (
    Cut,
    FailureRecord,
    JointWitness,
    Pose,
    Provenance,
    Robot,
    Target,
    Witness,
    World,
)

_finite = st.floats(allow_nan=False, allow_infinity=False)
_sides = st.sampled_from([0.1, 0.05, 1.0, 0.3]) | st.floats(*CELL_SIZES)
_integers = st.integers(-(2**200), 2**200) | st.integers(0, 2**64 - 1)
_indices = st.integers(-(2**63), 2**63 - 1) | st.integers(-1, 12)


def values():
    """Any value that a header's tables can hold."""
    leaves = st.booleans() | _integers | _finite | st.text(max_size=8)
    return st.recursive(
        leaves,
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
        ),
        max_leaves=8,
    )


def _within(limits, size):
    """Numbers in m, within limits in cells; often typical of robots."""
    low, high = (limit * size for limit in limits)
    return st.sampled_from([share * size for share in (0.5, 1.0, 3.0)]) | st.floats(low, high)


def _tables():
    return st.dictionaries(st.text(max_size=5), values(), max_size=3)


@st.composite
def _timelines(draw, width, height):
    events = st.builds(
        Event,
        st.floats(0.0, LATEST),
        st.integers(0, width - 1),
        st.integers(0, height - 1),
        st.sampled_from(CellState),
    )
    return Timeline.of(draw(st.lists(events, max_size=4)))


@st.composite
def _witnesses(draw, fewest=0):
    points = draw(st.lists(st.tuples(_finite, _finite, _finite), min_size=fewest, max_size=4))
    times, x, y = np.array(points, float).reshape(-1, 3).T
    return Witness(times, x, y, draw(_finite))


@st.composite
def _cuts(draw):
    cells = draw(st.lists(st.tuples(_indices, _indices), max_size=4))
    return Cut(np.array(cells, np.int64).reshape(-1, 2), draw(_finite))


@st.composite
def worlds_with_everything(draw):
    """Worlds of up to 8 x 8 cells, with or without each optional part."""
    width, height = draw(st.integers(1, 8)), draw(st.integers(1, 8))
    cells = draw(st.lists(st.booleans(), min_size=width * height, max_size=width * height))
    size = draw(_sides)
    radii = _within(RADII, size)
    across, up = st.floats(0.0, width * size), st.floats(0.0, height * size)
    names = st.text(max_size=6)
    metrics = st.dictionaries(st.text(max_size=5), _finite | _integers, max_size=3)
    provenances = st.builds(Provenance, names, _integers, _integers, _tables(), metrics)
    words = st.from_regex("[a-z][a-z0-9-]{0,8}", fullmatch=True)
    failures = st.builds(
        FailureRecord, names, words, _integers, words, names, _tables(), _tables(), _tables()
    )
    return World(
        np.array(cells).reshape(height, width),
        draw(st.builds(Pose, across, up, _finite)),
        draw(st.builds(Target, across, up, radii)),
        cell_size=size,
        robot_radius=draw(radii),
        robot_speed=draw(_within(SPEEDS, size) | st.just(2.0)),
        timeline=draw(_timelines(width, height)),
        certificate=draw(st.none() | _witnesses() | _cuts()),
        provenance=draw(st.none() | provenances),
        failure=draw(st.none() | failures),
    )


@st.composite
def fleets_with_everything(draw):
    """The same with two to four robots, which do not overlap at the start."""
    world = draw(worlds_with_everything())
    size = world.cell_size
    across = st.floats(0.0, world.width * size)
    up = st.floats(0.0, world.height * size)
    radii = st.sampled_from([0.01 * size, 0.05 * size, 1e-6 * size])
    robots = st.builds(
        Robot,
        st.builds(Pose, across, up, _finite),
        st.builds(Target, across, up, _within(RADII, size)),
        radii,
        _within(SPEEDS, size) | st.just(2.0),
    )
    others = draw(st.lists(robots, min_size=1, max_size=3))
    count = len(others) + 1
    joint = st.lists(_witnesses(1), min_size=count, max_size=count).map(tuple)
    cuts = st.builds(replace, _cuts(), robot=st.integers(1, count))
    certificate = draw(st.none() | st.builds(JointWitness, joint) | cuts)
    try:
        return replace(
            world,
            robot_radius=draw(radii),
            robots=(*world.robots, *others),
            certificate=certificate,
        )
    except InvalidWorld:  # two of them overlap, or their targets exclude each other
        assume(False)


@st.composite
def damaged_files(draw):
    """The bytes of a valid file after up to three cuts, swaps, duplications or insertions."""
    data = dumps(draw(worlds_with_everything() | fleets_with_everything()))
    for _ in range(draw(st.integers(1, 3))):
        separator = draw(st.sampled_from([b"\n", b" ", b""]))
        parts = data.split(separator) if separator else [data[k : k + 1] for k in range(len(data))]
        at = draw(st.integers(0, max(0, len(parts) - 1)))
        other = parts[draw(st.integers(0, max(0, len(parts) - 1)))] if parts else b""
        new = draw(st.sampled_from([[], [other], [other, other], [b"%"], [b"\n"], [b"S"], [b"="]]))
        new = new if draw(st.booleans()) else [draw(st.binary(max_size=3) | st.just(b"[[{"))]
        parts[at : at + draw(st.integers(0, 2))] = new
        data = separator.join(parts)
    return data
