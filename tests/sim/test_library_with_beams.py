"""The controllers that see by range beams.

Where each succeeds and fails, and that its bits are the same as in Python.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import _core, simulate
from sim.controllers.library import three_layer as layers
from sim.controllers.library.dynamic_window import dynamic_window
from sim.controllers.library.potential_field import (
    PotentialField,
    potential_field,
    potential_field_robot,
)
from sim.controllers.library.three_layer import three_layer
from sim.controllers.library.vfh import VfhPlus, vfh, vfh_robot
from tests.helpers.halls import cup, hall
from tests.helpers.interpreted import Interpreted
from tests.reference.sim.controllers._directions import angle_of, wrap
from worldgen.generation import generate

ALL = [potential_field, vfh, dynamic_window, three_layer]
POST = (14, 16, 2, 3)  # a post off the straight line


@pytest.mark.gate
@pytest.mark.parametrize("controller", ALL, ids=lambda controller: controller.name)
def test_an_empty_hall_is_crossed_without_a_bump(controller):
    episode = simulate(hall(), controller)
    assert (episode.verdict, episode.collisions) == ("reached", 0)


@pytest.mark.gate
@pytest.mark.parametrize("controller", ALL, ids=lambda controller: controller.name)
def test_a_post_beside_the_way_is_passed(controller):
    assert simulate(hall(POST), controller).verdict == "reached"


@pytest.mark.parametrize(
    "controller", [potential_field, vfh], ids=lambda controller: controller.name
)
def test_a_cup_holds_who_has_no_map_for_ever(controller):
    assert simulate(cup(), controller, steps=60_000).verdict == "loop"


@pytest.mark.gate
def test_a_cup_does_not_hold_the_dynamic_window_still_but_it_never_arrives():
    assert simulate(cup(14), dynamic_window, steps=20_000).verdict in ("loop", "stalled", "timeout")


@pytest.mark.parametrize("family", ["trap", "corridor", "maze"])
def test_three_layers_arrive_in_generated_worlds(family):
    verdicts = [simulate(generate(family, seed=seed), three_layer).verdict for seed in range(5)]
    assert verdicts.count("reached") >= 4


def test_vfh_drives_through_generated_corridors():
    verdicts = [simulate(generate("corridor", seed=seed), vfh).verdict for seed in range(6)]
    assert verdicts.count("reached") >= 4


@pytest.mark.gate
@pytest.mark.parametrize("controller", ALL, ids=lambda controller: controller.name)
@pytest.mark.parametrize("motion", ["swept", "endpoint"])
def test_compiled_and_interpreted_drive_bit_for_bit_alike(controller, motion):
    world = cup()
    compiled = simulate(world, controller, motion=motion, steps=150)
    assert (
        simulate(world, Interpreted(controller), motion=motion, steps=150).trace_digest
        == compiled.trace_digest
    )


def test_a_mirrored_world_gives_a_mirrored_potential_field():
    start, target = (0.5, 1.55, 0.0), (2.5, 1.55)
    above = simulate(
        hall((14, 16, 2, 4), start=start, target=target), potential_field, record=True
    ).trace
    below = simulate(
        hall((14, 11, 2, 4), start=start, target=target), potential_field, record=True
    ).trace
    assert np.abs(above.y[:40] + below.y[:40] - 3.1).max() < 0.01


@pytest.mark.gate
def test_a_stronger_push_keeps_further_away():
    def nearest(push):
        trace = simulate(
            hall(POST), potential_field_robot(PotentialField(push=push)), record=True
        ).trace
        return np.hypot(trace.x - 1.5, trace.y - 1.75).min()

    assert nearest(1e-3) > nearest(1e-5)


@pytest.mark.gate
def test_a_robot_that_cannot_turn_on_the_spot_takes_wider_turns():
    world = hall((9, 1, 1, 8), start=(0.5, 0.5, math.pi), target=(2.5, 0.5))
    agile, stiff = (
        simulate(world, vfh_robot(VfhPlus(turning_radius=r)), steps=4000) for r in (0.0, 0.2)
    )
    assert agile.trace_digest != stiff.trace_digest


def test_the_dynamic_window_never_outruns_its_brakes():
    world = hall(start=(0.5, 1.5, 0.0), target=(2.8, 1.5))
    trace = simulate(world, dynamic_window, record=True).trace
    way = np.hypot(np.diff(trace.x), np.diff(trace.y)) / trace.time_step
    assert np.abs(np.diff(way)).max() <= 20.0 * trace.time_step + 0.02


angles = st.floats(-20, 20, allow_nan=False)
places = st.floats(-3, 3, allow_nan=False)


@given(places, places)
def test_directions_are_those_of_atan2(x, y):
    assert abs(wrap(angle_of(x, y) - math.atan2(y, x))) < 1e-12 or (x, y) == (0.0, 0.0)


@pytest.mark.gate
@given(places, places, st.floats(0.1, 2), st.floats(-8, 8), st.floats(0.05, 0.3))
@settings(max_examples=200)
def test_an_arc_meets_a_point_where_small_steps_meet_it(x, y, speed, turn_rate, radius):
    if math.hypot(x, y) < radius + 0.01:
        return
    s = np.linspace(0, min(2 * math.pi * speed / max(abs(turn_rate), 1e-3), 6.0), 20_001)
    k = turn_rate / speed
    px, py = (s, 0 * s) if abs(turn_rate) < 1e-6 else (np.sin(k * s) / k, (1 - np.cos(k * s)) / k)
    away = np.hypot(px - x, py - y)
    way = _core.lib.wg_arc_to_contact(x, y, speed, turn_rate, radius)
    if away.min() > radius + 1e-3:
        assert way >= s[-1]
    elif away.min() < radius - 1e-3:
        assert abs(way - s[np.argmax(away <= radius)]) < 0.02


def _plan(memory, here, target):
    own = _core.ffi.cast("WgThreeLayerMemory *", _core.ffi.from_buffer(memory))
    cell = _core.lib.wg_next_cell(own, here, target)
    return cell.column, cell.row


def test_the_plan_goes_round_what_is_closed():
    memory = np.zeros(layers.MEMORY)
    assert _plan(memory, (4, 4), (6, 4)) == (5, 4)
    memory[layers.RIGHT + 4] = float(1 << 4)  # the passage from column 4 to 5 in row 4
    assert _plan(memory, (4, 4), (6, 4)) in [(4, 5), (4, 3)]


def test_the_plan_says_when_there_is_no_way():
    memory = np.zeros(layers.MEMORY)
    memory[layers.RIGHT : layers.RIGHT + layers.SIDE] = float(1 << 10)  # a wall from bottom to top
    assert _plan(memory, (4, 4), (20, 4)) == (-1, -1)
