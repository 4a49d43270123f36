"""Office plans: every room has a door, sizes are as requested, shut doors leave one path."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.rooms import rooms
from worldgen.families.parts.open_ground import in_sight
from worldgen.family import stream_for
from worldgen.generation import generate

SEEDS = st.integers(0, 2**64 - 1)
PLANS = st.sampled_from(["wings", "spine", "suite"])


def layout(seed=0, **params):
    return rooms.build(stream_for(seed, "rooms", 0), **rooms.complete(params))


def run_lengths(cells):
    """Lengths of the runs of true cells along the rows."""
    edges = np.diff(np.pad(cells, ((0, 0), (1, 1))).astype(int), axis=1)
    return np.argwhere(edges == -1)[:, 1] - np.argwhere(edges == 1)[:, 1]


def window_components(world, side):
    """Return the components of the places at which a square of this many cells is free."""
    return ndimage.label(ndimage.binary_erosion(~world.walls, np.ones((side, side))))[1]


def halves(world):
    return [(round(20 * point.x), round(20 * point.y)) for point in (world.start, world.target)]


@given(SEEDS, PLANS, st.integers(14, 70), st.integers(1, 3), st.floats(0.0, 1.0))
def test_every_room_can_be_reached_by_the_robots_square(seed, plan, size, wall, shared):
    world = layout(seed, plan=plan, size=size, wall=wall, shared=shared)
    assert window_components(world, 2) == 1


@given(SEEDS, PLANS, st.integers(2, 6), st.integers(0, 4), st.integers(1, 3))
def test_no_passage_is_narrower_than_a_door_and_no_wall_thinner_than_asked(
    seed, plan, door, more, wall
):
    world = layout(seed, plan=plan, size=60, door=door, room=door + more, wall=wall)
    assert min(run_lengths(~world.walls).min(), run_lengths(~world.walls.T).min()) >= min(
        door, wall
    )
    inside = np.pad(world.walls[1:-1, 1:-1], wall, constant_values=True)
    assert (
        ndimage.binary_opening(inside, np.ones((wall, wall)))[wall:-wall, wall:-wall]
        == world.walls[1:-1, 1:-1]
    ).all()


@given(SEEDS, PLANS)
def test_with_all_doors_shut_that_may_be_one_way_is_left(seed, plan):
    world = generate("rooms", seed, plan=plan, size=50, closed=1.0)
    assert world.walls.sum() > layout(seed, plan=plan, size=50).walls.sum()
    assert (world.start, world.target) == tuple(
        getattr(layout(seed, plan=plan, size=50), k) for k in ("start", "target")
    )


@pytest.mark.parametrize("plan", ["wings", "spine", "suite"])
def test_shared_doors_close_loops(plan):
    def openings(shared):
        return sum(
            (~layout(seed, plan=plan, size=60, shared=shared).walls).sum() for seed in range(5)
        )

    assert openings(0.0) < openings(0.3) < openings(1.0)


@pytest.mark.parametrize("plan", ["wings", "spine"])
def test_a_corridor_is_as_wide_as_asked(plan):
    for seed in range(10):
        plain = layout(seed, plan=plan, size=60, corridor=5, room=4, shared=0.0)
        assert (
            ndimage.binary_erosion(~plain.walls, np.ones((5, 30))).any()
            or ndimage.binary_erosion(~plain.walls, np.ones((30, 5))).any()
        )


@given(SEEDS, PLANS, st.integers(10, 50))
@settings(max_examples=40)
def test_start_and_target_are_apart_and_out_of_sight(seed, plan, size):
    world = layout(seed, plan=plan, size=size)
    assert not in_sight(world.walls, *halves(world))


@given(
    SEEDS,
    PLANS,
    st.integers(10, 50),
    st.sampled_from([0.02, 0.05, 0.07, 0.1, 0.13]),
    st.floats(0.0, 1.0),
)
@settings(max_examples=40)
def test_no_office_needs_a_second_attempt(seed, plan, size, robot_radius, closed):
    params = {"plan": plan, "size": size, "robot_radius": robot_radius, "closed": closed}
    try:
        first = layout(seed, **params)
    except InvalidParameter as refusal:
        assert size < 12 and robot_radius > 0.1, refusal
        return
    assert np.array_equal(generate("rooms", seed, **params).walls, first.walls)


def test_a_small_office_loads_nothing_heavy():
    code = (
        "import sys; from worldgen.generation import generate; generate('rooms', 1, size=60); "
        "print([name for name in ('numba', 'scipy', 'shapely') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"plan": "loft"}, {"code": "unknown-name", "name": "plan", "value": "loft"}),
        ({"wall": 0}, {"code": "below-minimum", "name": "wall", "low": 1}),
        (
            {"door": 1},
            {"code": "narrower-than-robot", "name": "door", "width": 1, "robot_width": 1.4},
        ),
        ({"door": 4, "corridor": 3}, {"code": "below-minimum", "corridor": 3, "door": 4}),
        ({"door": 4, "room": 3}, {"code": "below-minimum", "name": "door", "room": 3, "least": 4}),
        ({"room": 1}, {"code": "below-minimum", "name": "robot", "room": 1, "least": 2}),
        (
            {"corridor": 4, "plan": "suite"},
            {"code": "no-effect", "name": "corridor", "value": 4, "setting": "plan=suite"},
        ),
        ({"room": 13}, {"code": "no-room", "room": 13, "between": 4, "inside": 28}),
        ({"size": 20, "robot_radius": 0.4}, {"code": "no-room", "least": 28}),
        ({"shared": 1.5}, {"code": "out-of-range", "name": "shared", "value": 1.5}),
        ({"closed": -0.5}, {"code": "out-of-range", "name": "closed", "value": -0.5}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)


def test_the_least_size_that_the_message_names_works():
    assert layout(size=32, room=13).width == 32
