"""Options of fire: where it breaks out, how it spreads, what it leaves, and how late the robot may
be.
"""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.raising import raises
from tests.worldgen.test_families_fire import beside, burning, in_the_end, layout
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.generation import generate
from worldgen.reach import REACHABLE, check_certificate, decide, witness_margin
from worldgen.timeline import CellState
from worldgen.world import Witness

SEEDS = st.integers(0, 2**64 - 1)
STILL = [name for name in FAMILIES if not FAMILIES.get(name).changes]
GROUNDS = st.sampled_from(STILL)


def delayed(world, witness, delay):
    """Return the witness of a robot that waits at the start, and does everything ``delay`` s later."""
    times = np.concatenate([[0.0], witness.times + delay])
    x, y = (np.concatenate([values[:1], values]) for values in (witness.x, witness.y))
    return Witness(times, x, y, min(witness.clearance, world.robot_radius))


def outbreaks(world):
    """Return the cells that do not catch fire from another cell, by time."""
    caught, _ = burning(world)
    alone = [
        place
        for place in caught
        if not any(caught.get(other, math.inf) < caught[place] for other in beside(place))
    ]
    return sorted((caught[place], place) for place in alone if not world.walls[place])


def test_fire_breaks_out_in_the_cells_that_are_given():
    world = layout(3, over="trap+shape=U", ignite_cells="4:5, 25:20", apart=2.0, spread=5.0)
    (first, one), (second, other) = outbreaks(world)
    assert (first, one, other) == (0.0, (5, 4), (20, 25)) and 1.0 <= second <= 3.0


@given(SEEDS, st.integers(2, 5))
@settings(max_examples=20)
def test_fires_apart_break_out_one_after_another(seed, ignitions):
    times = [
        time
        for time, _ in outbreaks(
            layout(seed, over="rooms", ignitions=ignitions, apart=3.0, spread=5.0)
        )
    ]
    assert times[0] == 0.0 and all(later - time >= 1.5 for time, later in itertools.pairwise(times))


@given(SEEDS, GROUNDS)
@settings(max_examples=20)
def test_fire_at_the_rim_breaks_out_no_deeper_than_floor_near_the_border(seed, over):
    world = layout(seed, over=over, ignite_at="rim", ignitions=3)
    depth = [
        min(iy, ix, world.height - 1 - iy, world.width - 1 - ix) for _, (iy, ix) in outbreaks(world)
    ]
    floor = np.argwhere(~world.walls)
    shallow = np.minimum(floor, world.height - 1 - floor).min()
    assert all(
        there <= shallow + 4 for there in depth
    )  # the robot may stand in a corner, and nothing burns around it


def test_wind_carries_fire_to_where_it_blows():
    ratios = []
    for seed in range(10):
        world = layout(
            seed,
            over="forest+density=0.2",
            size=60,
            wind=0.8,
            wind_to=0,
            ignitions=1,
            spread_cells=400,
        )
        (_, (_, ix)), *_ = outbreaks(world)
        columns = [place[1] - ix for place in burning(world)[0] if not world.walls[place]]
        ratios.append((max(columns), -min(columns)))
    assert sum(ahead > 2 * behind for ahead, behind in ratios) >= 5


@given(SEEDS, st.sampled_from([0.0, 0.3, 0.7]), st.integers(1, 8))
@settings(max_examples=20)
def test_no_more_of_the_floor_burns_than_has_fuel(seed, fuel, grain):
    world = layout(seed, over="cave", fuel=fuel, grain=grain, spread_cells=10_000, ignitions=100)
    floor = [place for place in burning(world)[0] if not world.walls[place]]
    assert len(floor) <= fuel * np.count_nonzero(~world.walls) + 1


def test_uneven_fuel_makes_some_places_burn_much_longer():
    def spread_of(**params):
        caught, out = burning(layout(5, over="rooms", scatter=0.0, **params))
        lasts = [out[place][0] - time for place, time in caught.items()]
        return max(lasts) / min(lasts)

    assert spread_of() == pytest.approx(1.0) and spread_of(uneven=0.9) > 3.0


def test_cleared_debris_opens_every_cell_again():
    world = layout(2, debris=0.8, clear=1.0)
    line = world.timeline
    assert (line.states == CellState.SOLID).any() and not (
        in_the_end(world).walls & ~world.walls
    ).any()


@given(SEEDS, GROUNDS)
@settings(max_examples=20)
def test_what_is_monotone_never_opens(seed, over):
    world = layout(seed, over=over, monotone=True)
    assert not (world.timeline.states == CellState.FREE).any()
    assert not world.walls[world.timeline.iy, world.timeline.ix].any()


@pytest.mark.gate
@given(
    SEEDS,
    GROUNDS,
    st.booleans(),
    st.sampled_from([0.0, 0.5, 3.0]),
    st.sampled_from(["mixed", "way", "rim"]),
)
@settings(max_examples=40)
def test_the_witness_may_begin_as_late_as_was_asked_for(seed, over, monotone, margin, place):
    world = generate(
        "fire", seed % 1000, over=over, monotone=monotone, margin=margin, ignite_at=place
    )
    assert witness_margin(world, world.certificate) >= margin
    for delay in (margin / 3, margin):
        report = check_certificate(world, delayed(world, world.certificate, delay))
        assert report.valid, report.reason


@pytest.mark.gate
@given(SEEDS, GROUNDS, st.sampled_from([0.0, 2.0]))
@settings(max_examples=30)
def test_a_fire_race_can_be_won_by_construction(seed, over, margin):
    world = layout(seed, over=over, monotone=True, margin=margin, ignite_at="way", spread=0.05)
    assert decide(world, margin=margin).result == REACHABLE


@pytest.mark.gate
def test_a_witness_does_not_hold_longer_than_its_margin():
    tight = 0
    for seed in range(12):
        world = generate("fire", seed, over="rooms", monotone=seed % 2 == 0)
        margin = witness_margin(world, world.certificate)
        if margin < math.inf:
            tight += 1
            assert check_certificate(world, delayed(world, world.certificate, margin)).valid
            assert not check_certificate(
                world, delayed(world, world.certificate, margin + 1e-4)
            ).valid
    assert tight >= 6


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"ignite_cells": "3;4"}, {"code": "wrong-form", "text": "3;4", "part": "3;4"}),
        ({"ignite_cells": "0:0"}, {"code": "cannot-burn", "cell": "0:0", "what": "a wall"}),
        (
            {"ignite_cells": "30:3"},
            {"code": "outside-grid", "cell": "30:3", "width": 30, "height": 30},
        ),
        ({"apart": -1.0}, {"code": "out-of-range", "name": "apart"}),
        (
            {"scatter": 0.95},
            {"code": "out-of-range", "name": "scatter", "value": 0.95, "high": 0.9},
        ),
        ({"wind": 1.0}, {"code": "out-of-range", "name": "wind", "high": 0.9}),
        (
            {"wind": 0.5, "wind_to": 4},
            {"code": "out-of-range", "name": "wind_to", "value": 4, "high": 3},
        ),
        ({"wind_to": 2}, {"code": "no-effect", "name": "wind_to", "value": 2, "setting": "wind=0"}),
        ({"fuel": 1.1}, {"code": "out-of-range", "name": "fuel", "value": 1.1}),
        ({"grain": 0}, {"code": "out-of-range", "name": "grain", "low": 1, "high": 1000}),
        ({"uneven": 1.0}, {"code": "out-of-range", "name": "uneven", "high": 0.9}),
        ({"clear": 601.0}, {"code": "out-of-range", "name": "clear"}),
        ({"clear": 1.0, "monotone": True}, {"code": "conflict"}),
        ({"margin": -1.0}, {"code": "out-of-range", "name": "margin"}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_options_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)
