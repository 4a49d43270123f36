"""Fire spreads from cell to cell, closes and opens paths, and leaves the robot a path."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.fire import FIREBREAK, fire
from worldgen.family import stream_for
from worldgen.generation import generate
from worldgen.reach import REACHABLE, decide
from worldgen.reach.still.grid_search import free_windows, shortest_path
from worldgen.timeline import CellState, Timeline

SEEDS = st.integers(0, 2**64 - 1)
OVER = st.sampled_from(["maze", "corridor", "trap"])
every_ground = pytest.mark.parametrize("over", ["maze", "corridor", "trap"])


def layout(seed=0, **params):
    return fire.build(stream_for(seed, "fire", 0), **fire.complete(params))


def burning(world):
    """Return when each cell catches fire, and when and in which state it stops burning."""
    caught, out = {}, {}
    for event in world.timeline:
        place = event.iy, event.ix
        if event.state == CellState.BURNING:
            caught[place] = event.time
        else:
            out[place] = event.time, event.state
    return caught, out


def beside(place):
    return [
        (place[0] + 1, place[1]),
        (place[0] - 1, place[1]),
        (place[0], place[1] + 1),
        (place[0], place[1] - 1),
    ]


def in_the_end(world):
    walls = world.walls.copy()
    for event in world.timeline:
        walls[event.iy, event.ix] = event.state == CellState.SOLID
    return dataclasses.replace(world, walls=walls, timeline=Timeline())


@given(SEEDS, OVER)
@settings(max_examples=20)
def test_a_way_is_shortest_by_a_foreign_graph_search(seed, over):
    windows = free_windows(layout(seed, over=over).walls, 2, 2)
    cells = np.flatnonzero(windows).tolist()
    links = [
        (a, a + step) for step in (1, windows.shape[1]) for a in cells if windows.flat[a + step]
    ]
    graph = sparse.coo_array(
        (np.ones(len(links)), np.transpose(links)), shape=(windows.size, windows.size)
    )
    steps = csgraph.shortest_path(graph, directed=False, unweighted=True, indices=cells[0])[
        cells[-1]
    ]
    assert len(shortest_path(windows, cells[0], cells[-1])) - 1 == steps


@given(SEEDS, OVER)
def test_every_cell_burns_once_and_comes_out(seed, over):
    world = layout(seed, over=over)
    caught, out = burning(world)
    assert len(world.timeline) == 2 * len(caught) == 2 * len(out)
    assert all(out[place][0] > time for place, time in caught.items())


@given(SEEDS, OVER, st.integers(1, 4))
def test_fire_spreads_from_cell_to_cell(seed, over, ignitions):
    caught, _ = burning(layout(seed, over=over, ignitions=ignitions))
    without_cause = [
        place
        for place, time in caught.items()
        if not any(caught.get(other, time) < time for other in beside(place))
    ]
    assert 1 <= len(without_cause) <= ignitions
    assert all(caught[place] == 0.0 for place in without_cause)


@given(SEEDS, OVER, st.floats(0.05, 2.0))
def test_delays_lie_round_the_mean_given(seed, over, spread):
    world = layout(seed, over=over, spread=spread, burn_through=0)
    caught, _ = burning(world)
    for place, time in caught.items():
        if time > 0:
            delay = time - min(caught.get(other, time) for other in beside(place))
            assert 0.5 * spread - 0.002 <= delay <= 1.5 * spread + 0.002


@given(SEEDS, OVER, st.floats(0.1, 5.0))
def test_burning_takes_about_the_mean_given(seed, over, burn):
    caught, out = burning(layout(seed, over=over, burn=burn))
    lasts = [out[place][0] - time for place, time in caught.items()]
    assert 0.5 * burn - 0.002 <= min(lasts) and max(lasts) <= 1.5 * burn + 0.002


@given(SEEDS, OVER)
def test_times_are_whole_milliseconds(seed, over):
    assert all(round(time, 3) == time for time in layout(seed, over=over).timeline.times.tolist())


@given(SEEDS, OVER, st.integers(1, 200), st.integers(0, 5))
def test_the_number_of_events_is_bounded(seed, over, spread_cells, burn_through):
    world = layout(seed, over=over, size=25, spread_cells=spread_cells, burn_through=burn_through)
    caught, _ = burning(world)
    assert sum(not world.walls[place] for place in caught) <= spread_cells
    assert (
        sum(world.walls[place] for place in caught) <= burn_through * 2 * 6
    )  # two wide, at most six thick


@given(SEEDS, OVER, st.floats(0.0, 1.0))
def test_walls_burn_open_and_never_fall_shut(seed, over, debris):
    world = layout(seed, over=over, debris=debris)
    caught, out = burning(world)
    assert all(out[place][1] == CellState.FREE for place in caught if world.walls[place])


@pytest.mark.gate
@every_ground
def test_ways_close_and_open(over):
    closed = opened = 0
    for seed in range(20):
        before, after = layout(seed, over=over).walls, in_the_end(layout(seed, over=over)).walls
        closed, opened = closed + (after & ~before).any(), opened + (before & ~after).any()
    assert closed >= 15 and opened >= 10


def test_without_debris_nothing_closes():
    assert not any(
        (layout(seed, debris=0.0).timeline.states == CellState.SOLID).any() for seed in range(10)
    )


def test_all_debris_closes_all_but_the_way_that_is_left():
    world = layout(4, debris=1.0, burn_through=0)
    _, out = burning(world)
    shut = sum(state == CellState.SOLID for _, state in out.values())
    assert 0.3 * len(out) < shut < len(out)


def test_without_burn_through_no_wall_changes():
    for seed in range(10):
        world = layout(seed, burn_through=0)
        assert not world.walls[world.timeline.iy, world.timeline.ix].any()


@pytest.mark.gate
@every_ground
def test_burn_through_opens_ways_that_the_disc_fits_through(over):
    """Only holes, without debris: some of them shorten the path from start to target."""
    shorter = 0
    for seed in range(20):
        world = layout(seed, over=over, debris=0.0, burn_through=8, size=40)
        ground = dataclasses.replace(world, timeline=Timeline())
        now, later = (decide(each).certificate.length for each in (ground, in_the_end(world)))
        assert later <= now + 0.1  # the length of a shortened path varies a little
        shorter += later < now - 0.1
    assert shorter >= 3


@given(SEEDS, OVER, st.floats(0.01, 0.149))
def test_floor_round_the_start_never_burns(seed, over, robot_radius):
    world = layout(seed, over=over, robot_radius=robot_radius)
    x, y = world.start.x / world.cell_size, world.start.y / world.cell_size
    for iy, ix in burning(world)[0]:
        dx, dy = max(ix - x, x - ix - 1, 0.0), max(iy - y, y - iy - 1, 0.0)
        if not world.walls[iy, ix]:
            assert np.hypot(dx, dy) >= robot_radius / world.cell_size + FIREBREAK - 1e-9


@given(
    SEEDS, OVER, st.sampled_from([0.05, 0.07, 0.1, 0.14]), st.floats(0.0, 1.0), st.integers(0, 9)
)
@settings(max_examples=30)
def test_what_is_left_in_the_end_lets_the_robot_through(
    seed, over, robot_radius, debris, burn_through
):
    world = layout(
        seed, over=over, robot_radius=robot_radius, debris=debris, burn_through=burn_through
    )
    assert decide(in_the_end(world)).result == REACHABLE


@pytest.mark.gate
@pytest.mark.parametrize("robot_radius", [0.05, 0.15, 0.2])
def test_debris_never_shuts_the_target_in(robot_radius):
    """A robot that is a whole number of cells wide has no room to spare; its target may be between
    two cells.
    """
    for seed in range(40):
        world = layout(
            seed, over="trap", size=25, robot_radius=robot_radius, debris=1.0, spread_cells=1000
        )
        assert decide(in_the_end(world)).result == REACHABLE


@given(SEEDS, OVER)
def test_every_hole_joins_floor_to_floor(seed, over):
    world = layout(seed, over=over, burn_through=6)
    hole = world.walls & ~in_the_end(world).walls
    for rows, columns in ndimage.find_objects(ndimage.label(hole)[0]):
        assert hole[rows, columns].all()
        across = (
            world.walls[rows, [columns.start - 1, columns.stop]],
            world.walls[[rows.start - 1, rows.stop], columns],
        )
        assert not across[0].any() or not across[1].any()


@pytest.mark.gate
@every_ground
def test_fire_is_in_the_way_of_most_robots(over):
    """The witness takes longer than it would without fire: it waits, or makes a detour."""
    late = 0
    for seed in range(20):
        world = generate("fire", seed, over=over)
        late += (
            world.certificate.duration
            > 1.1 * decide(dataclasses.replace(world, timeline=Timeline())).certificate.duration
        )
    assert late >= 12


def test_over_a_trap_every_shape_comes_up():
    solid = {int(layout(seed, over="trap", size=40).walls.sum()) for seed in range(30)}
    assert len(solid) > 15


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"over": "lake"}, {"code": "unknown-name", "name": "lake", "noun": "family"}),
        ({"ignitions": 0}, {"code": "out-of-range", "name": "ignitions", "low": 1, "high": 100}),
        ({"spread": 0.0}, {"code": "out-of-range", "name": "spread", "low": 0.01}),
        ({"burn": -1.0}, {"code": "out-of-range", "name": "burn", "low": 0.01}),
        (
            {"spread_cells": 0},
            {"code": "out-of-range", "name": "spread_cells", "low": 1, "high": 100000},
        ),
        ({"debris": 1.5}, {"code": "out-of-range", "name": "debris", "value": 1.5}),
        (
            {"burn_through": -1},
            {"code": "out-of-range", "name": "burn_through", "value": -1, "high": 1000},
        ),
        (
            {"size": 10, "robot_radius": 0.3},
            {"code": "no-room", "size": 10, "robot_radius": 0.3, "over": "maze"},
        ),
        ({"size": 10, "robot_radius": 0.3, "over": "trap"}, {"code": "no-room", "over": "trap"}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)
