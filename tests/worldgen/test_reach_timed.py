"""Worlds that change: the earliest arrival, clear of every change."""

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given

from tests.helpers.drawn_worlds import changing_worlds, drawn
from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, check_certificate, decide
from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Target

FREE, SOLID, BURNING = CellState
GATE = """
###########
S....#....G
###########
"""
OPEN = GATE.replace("#....G", ".....G")


def changing(text, *events, radius=0.05, speed=0.5):
    return drawn(text, radius=radius, robot_speed=speed, timeline=Timeline.of(events))


def decided(world):
    """Return the decision, after the checker has confirmed its certificate."""
    decision = decide(world)
    report = check_certificate(world, decision.certificate)
    assert report.valid, (decision.reason, report.reason)
    return decision


def test_the_robot_waits_until_a_wall_has_burnt_through():
    world = changing(GATE, (1.0, 5, 1, BURNING), (7.0, 5, 1, FREE))
    witness = decided(world).certificate
    assert 7.0 + 0.5 / 0.5 <= witness.duration <= 7.0 + 0.7 / 0.5
    assert (np.hypot(np.diff(witness.x), np.diff(witness.y)) == 0.0).any()


def test_the_robot_passes_before_the_fire_when_it_is_fast_enough():
    world = changing(OPEN, (2.0, 5, 1, BURNING), speed=0.5)
    assert decided(world).certificate.duration == pytest.approx(1.0 / 0.5, abs=0.11)


def test_the_robot_is_not_promised_to_outrun_a_fire_that_is_faster():
    assert decide(changing(OPEN, (0.5, 5, 1, BURNING), speed=0.5)).result == UNDECIDED


def test_the_robot_goes_round_a_fire_that_outlasts_the_way_round():
    rooms = "S....G\n......\n......"
    through = changing(rooms, (0.0, 2, 2, BURNING), (0.25, 2, 2, FREE))
    past = changing(rooms, (0.0, 2, 2, BURNING), (90.0, 2, 2, FREE))
    assert decided(through).certificate.y.min() == 0.25
    assert decided(past).certificate.y.min() < 0.2


def test_a_robot_that_waits_in_a_niche_lets_the_fire_pass():
    niche = "##.####\nS.....G\n#######"
    front = [(0.3 + 0.1 * (6 - ix), ix, 1, BURNING) for ix in range(7)]
    ashes = [(3.0, ix, 1, FREE) for ix in range(7)]
    witness = decided(changing(niche, *front, *ashes, speed=1.0)).certificate
    assert witness.y.max() == pytest.approx(0.25)
    assert witness.duration > 3.0


def test_a_start_that_burns_at_once_is_blocked_by_that_cell():
    decision = decided(changing(OPEN, (0.0, 0, 1, BURNING), (1.0, 0, 1, FREE)))
    assert decision.result == BLOCKED
    assert decision.certificate.cells.tolist() == [[0, 1]]


@pytest.mark.gate
def test_walls_that_never_open_are_a_cut_whatever_burns_elsewhere():
    decision = decided(changing(GATE, (1.0, 2, 1, BURNING), (2.0, 2, 1, FREE)))
    assert decision.result == BLOCKED


def test_a_wall_that_burns_for_ever_is_as_good_as_solid():
    assert decided(changing(GATE, (3.0, 5, 1, BURNING))).result == BLOCKED
    assert decided(changing(GATE, (3.0, 5, 1, BURNING), (4.0, 5, 1, FREE))).result == REACHABLE


def test_of_two_changes_at_one_time_the_later_line_counts():
    shut, opened = (1.0, 5, 1, SOLID), (1.0, 5, 1, FREE)
    assert decided(changing(GATE, shut, opened)).result == REACHABLE
    assert decided(changing(GATE, opened, shut)).result == BLOCKED


def test_a_start_off_the_lattice_is_kept():
    world = dataclasses.replace(
        changing(OPEN, (9.0, 5, 1, BURNING), radius=0.03), start=Pose(0.0512345, 0.15)
    )
    assert decided(world).certificate.x[0] == 0.0512345


def test_times_are_whole_microseconds():
    times = decided(
        changing(GATE, (1.0, 5, 1, BURNING), (7.0, 5, 1, FREE), speed=0.7)
    ).certificate.times
    assert (times == np.round(times, 6)).all()


@given(changing_worlds())
def test_every_timed_certificate_is_accepted_by_the_checker(world):
    decision = decide(world)
    assert decision.certificate is None or check_certificate(world, decision.certificate).valid


@pytest.mark.gate
@given(changing_worlds())
def test_changes_after_the_arrival_change_nothing(world):
    decision = decide(world)
    assume(world.is_dynamic and decision.result == REACHABLE)
    late = decision.certificate.duration + 0.001
    before = [event for event in world.timeline if event.time <= late]
    everywhere = [(late, ix, iy, BURNING) for iy, ix in np.ndindex(world.walls.shape)]
    again = decide(dataclasses.replace(world, timeline=Timeline.of(before + everywhere)))
    assert again.certificate.duration == decision.certificate.duration


def test_a_way_between_nodes_that_no_change_touches_is_found():
    world = changing("######\n#S...#\n#...G#\n######", (1.0, 4, 2, SOLID))
    at = Pose(0.153, 0.161)  # the target is so small that no node of any graph is in it
    assert (
        decided(dataclasses.replace(world, start=at, target=Target(at.x, at.y, 0.001))).result
        == REACHABLE
    )
