"""The thesis's world shifter: mirrored cells swap at times, but never the target's."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.shift import _Pace, shift
from worldgen.family import stream_for
from worldgen.generation import generate
from worldgen.reach import REACHABLE, check_certificate, decide
from worldgen.support.rows import flip_rows
from worldgen.timeline import CellState, Timeline

SEEDS = st.integers(0, 2**64 - 1)
OVER = st.sampled_from(["trap", "corridor", "maze"])


def layout(seed=0, **params):
    return shift.build(stream_for(seed, "shift", 0), **shift.complete(params))


def swaps(world):
    """Pairs of events."""
    events = list(world.timeline)
    return list(zip(events[::2], events[1::2], strict=True))


def as_in_the_thesis(world):
    """cells[x][y] with y down, solid or not."""
    return flip_rows(world.walls).T.copy()


@given(SEEDS, OVER)
def test_every_change_is_a_swap_across_the_diagonal_from_the_upper_left(seed, over):
    world = layout(seed, over=over, chance=0.5)
    cells, last = as_in_the_thesis(world), world.height - 1
    for one, other in swaps(world):
        (x, y), (mirrored_x, mirrored_y) = ((event.ix, last - event.iy) for event in (one, other))
        assert one.time == other.time and (mirrored_x, mirrored_y) == (y, x)
        cells[x, y], cells[y, x] = cells[y, x], cells[x, y]
        assert [one.state, other.state] == [int(cells[x, y]), int(cells[y, x])]


@given(SEEDS, OVER)
def test_the_number_of_walls_never_changes(seed, over):
    world = layout(seed, over=over, chance=0.5)
    assert all(
        {one.state, other.state} == {CellState.FREE, CellState.SOLID} for one, other in swaps(world)
    )


@given(SEEDS, st.sampled_from([0.01, 0.1, 0.3, 0.5, 7.0]), st.floats(0.0, 100.0))
def test_swaps_fall_on_whole_intervals_within_the_duration(seed, interval, duration):
    times = layout(seed, interval=interval, duration=duration, chance=0.5).timeline.times
    whole = np.round(times / interval)
    assert (
        np.allclose(times, whole * interval, atol=1e-9)
        and (whole >= 1).all()
        and (times <= duration + 1e-9).all()
    )


def test_times_are_the_decimals_that_they_mean():
    times = layout(1, over="maze", interval=0.1, chance=1.0, duration=30.0).timeline.times
    assert len(times) > 50 and all(len(repr(time)) <= 4 for time in times.tolist())


@given(SEEDS, OVER)
def test_the_targets_cells_stay_as_they_are(seed, over):
    world = layout(seed, over=over, size=12, chance=1.0, duration=300.0)
    goal = world.target
    x, y, radius = (value / world.cell_size for value in (goal.x, goal.y, goal.radius))
    for event in world.timeline:
        dx = max(event.ix - x, x - event.ix - 1, 0.0)
        dy = max(event.iy - y, y - event.iy - 1, 0.0)
        assert np.hypot(dx, dy) >= radius - 1e-9


def test_about_one_draw_in_ten_swaps():
    """Share of the draws that would swap a wall and a free cell.

    The more cells are swapped, the fewer differ.
    """
    params = {"over": "corridor", "size": 20, "duration": 600.0}
    tenth, every = (
        sum(len(layout(seed, chance=chance, **params).timeline) for seed in range(20))
        for chance in (0.1, 1.0)
    )
    assert 0.08 < tenth / every < 0.16


@pytest.mark.parametrize("params", [{"chance": 0.0}, {"duration": 0.0}, {"duration": 0.4}])
def test_without_chance_or_time_nothing_changes(params):
    assert not any(layout(seed, **params).is_dynamic for seed in range(10))


@pytest.mark.gate
@pytest.mark.parametrize(("over", "interval"), [("trap", 0.02), ("corridor", 0.2), ("maze", 0.1)])
def test_often_enough_swaps_are_in_the_way_of_a_robot_that_knows_nothing_of_them(over, interval):
    """The witness of the initial world does not hold, but the given one does."""
    struck = 0
    for seed in range(8):
        world = generate("shift", seed, over=over, interval=interval, chance=1.0, duration=6.0)
        at_first = decide(dataclasses.replace(world, timeline=Timeline())).certificate
        assert check_certificate(world).valid
        struck += not check_certificate(world, at_first).valid
    assert struck >= 1


@pytest.mark.gate
def test_a_layout_that_swaps_shut_the_way_is_left_out():
    params = {"over": "corridor", "size": 20, "interval": 0.2, "chance": 1.0, "duration": 20.0}
    left_out = [seed for seed in range(12) if decide(layout(seed, **params)).result != REACHABLE]
    assert left_out
    for seed in left_out[:3]:
        world = generate("shift", seed, **params)
        assert check_certificate(world).valid and not np.array_equal(
            world.walls, layout(seed, **params).walls
        )


@given(SEEDS)
def test_the_ground_is_what_it_is_without_swaps(seed):
    assert np.array_equal(layout(seed, chance=1.0).walls, layout(seed, chance=0.0).walls)


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"over": "fire"}, {"code": "world-changes", "over": "fire", "family": "fire"}),
        ({"interval": 0.0}, {"code": "out-of-range", "name": "interval", "low": 0.01}),
        ({"chance": 1.5}, {"code": "out-of-range", "name": "chance", "value": 1.5}),
        ({"chance": -0.1}, {"code": "out-of-range", "name": "chance", "value": -0.1}),
        ({"duration": -1.0}, {"code": "out-of-range", "name": "duration"}),
        ({"duration": 601.0}, {"code": "out-of-range", "name": "duration"}),
        ({"size": 10, "robot_radius": 0.3}, {"code": "no-room", "over": "trap"}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)


@given(SEEDS, st.floats(1.5, 50.0))
def test_a_world_that_speeds_up_changes_more_and_more(seed, speedup):
    times = layout(seed, over="maze", speedup=speedup, duration=200.0).timeline.times
    early, late = (times <= 100.0).sum(), (times > 100.0).sum()
    assert late > early and times.max() <= 200.0 and (np.diff(times) >= 0).all()


def test_the_rate_and_the_chance_of_a_swap_grow_evenly_with_time():
    pace = _Pace(interval=0.5, chance=0.1, duration=60.0, speedup=4.0)
    times = np.array([pace.time(draw) for draw in range(1, pace.draws + 1)])
    assert len(times) == 300 and times[-1] == pytest.approx(60.0)
    gaps = np.diff(times)
    assert gaps[0] == pytest.approx(0.5, rel=0.05) and gaps[-1] == pytest.approx(0.125, rel=0.02)
    assert [round(pace.share(time), 3) for time in (0.0, 30.0, 60.0)] == [0.1, 0.25, 0.4]


def test_a_world_that_speeds_up_is_proved_too():
    world = generate("shift", 5, speedup=10.0)
    assert check_certificate(world).valid and world.provenance.params["speedup"] == 10.0
