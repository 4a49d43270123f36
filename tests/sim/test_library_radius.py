"""Robots of other sizes: a controller gets its radius, and library controllers adapt to it."""

from dataclasses import replace

import numpy as np
import pytest

from sim import CompiledController, simulate
from tests.helpers.drawn_worlds import drawn
from tests.reference.sim import layout
from worldgen import generate

NOTCH = """
...............
...............
...............
...............
...#########...
...........#...
...........#.G.
.S.........#...
...........#...
...........#...
...........#...
...........#...
...########....
...#...........
"""  # below its lower arm, a robot larger than a cell touches the arm and the border together
POST = "\n".join(
    ["." * 25] * 12 + ["." * 11 + "##" + "." * 12] * 2 + [".S" + "." * 21 + "G."] + ["." * 25] * 12
)
TWO_BLOCKS = """
.........................
.........................
......................G..
.........................
.........................
.........................
.........................
.........................
..............###........
..............###........
.........................
...........##............
...........##............
.........................
.........................
......#..................
......#..................
......###................
......###................
......###................
.........................
.........................
.........................
.S.......................
.........................
"""  # the gap between the two upper blocks is 0.0014 m wider than the robot


def radius_seen(world, **options):
    def act(observation, memory, command):
        memory[0] = observation[layout.OBS_RADIUS]

    eyes = CompiledController("eyes", act, (0.0,))
    return (
        simulate(world, eyes, steps=1, record=True, **options)
        .trace.states[1, layout.STATE_MEMORY :]
        .view(float)[0]
    )


@pytest.mark.nightly
@pytest.mark.parametrize("radius", [0.02, 0.07, 0.14])
@pytest.mark.parametrize("motion", ["swept", "endpoint"])
def test_a_controller_is_told_the_robot_s_radius(radius, motion):
    assert radius_seen(drawn("....\n.S..\n....\n...G", radius=radius), motion=motion) == radius


@pytest.mark.gate
@pytest.mark.parametrize("name", ["bug1", "bug2", "tangent-bug", "mapper", "three-layer"])
@pytest.mark.parametrize("radius", [0.035, 0.14])
@pytest.mark.parametrize("family", ["trap", "corridor"])
def test_a_robot_of_another_size_arrives(name, radius, family):
    worlds = [generate(family, seed, size=20, robot_radius=radius) for seed in range(3)]
    assert [simulate(world, name, steps=10_000).verdict for world in worlds] == ["reached"] * 3


@pytest.mark.parametrize("name", ["wall-left", "wall-right", "bug1", "bug2"])
def test_by_touch_all_is_alike_where_all_lengths_are_twice_as_large(name):
    worlds = [
        generate(
            "maze",
            3,
            size=20,
            cell_size=0.1 * scale,
            robot_radius=0.07 * scale,
            robot_speed=2.0 * scale,
        )
        for scale in (1, 2)
    ]
    worlds = [
        replace(world, target=replace(world.target, radius=0.5 * world.cell_size))
        for world in worlds
    ]
    once, twice = (simulate(world, name) for world in worlds)
    assert (twice.verdict, twice.steps) == (once.verdict, once.steps)
    assert twice.path_length == pytest.approx(2 * once.path_length)


def test_vfh_keeps_twice_as_far_from_a_wall_if_it_is_twice_as_large():
    def least_gap(radius):
        trace = simulate(drawn(POST, radius=radius, target_radius=0.05), "vfh", record=True).trace
        dx, dy = (
            np.maximum(abs(place - middle) - 0.1, 0.0)
            for place, middle in ((trace.x, 1.2), (trace.y, 1.4))
        )
        return np.hypot(dx, dy).min() - radius

    assert 1.5 * least_gap(0.05) < least_gap(0.1)


@pytest.mark.parametrize("name", ["bug1", "bug2", "tangent-bug"])
def test_a_robot_larger_than_a_cell_does_not_tremble_between_two_walls(name):
    assert simulate(drawn(NOTCH, radius=0.14, target_radius=0.05), name).verdict == "reached"


@pytest.mark.parametrize("time_step", [0.004, 0.0075, 0.015])
def test_bug1_tells_a_wall_just_across_a_gap_from_the_one_it_left(time_step):
    assert (
        simulate(drawn(TWO_BLOCKS), "bug1", time_step=time_step, steps=20_000).verdict == "reached"
    )


@pytest.mark.parametrize("name", ["bug2", "wall-left"])
def test_a_robot_of_a_millimetre_does_not_take_for_ever(name):
    assert (
        simulate(generate("corridor", 3, robot_radius=0.001), name, steps=10_000).verdict
        == "reached"
    )
