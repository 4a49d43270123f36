"""Reachable by a deadline, blocked for it, or undecided.

And how long the robot may wait before it sets out.
"""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.helpers.drawn_worlds import changing_worlds, drawn
from tests.helpers.grid_strategies import worlds_with_everything
from tests.helpers.raising import raises
from worldgen.domain import LATEST
from worldgen.errors import InvalidParameter
from worldgen.generation import generate
from worldgen.lattice import UNIT, in_cells
from worldgen.reach import (
    BLOCKED,
    REACHABLE,
    UNDECIDED,
    check_certificate,
    check_confinement,
    decide,
    decide_in_time,
    latest_start,
    until,
    witness_margin,
)
from worldgen.reach.deadline import retime
from worldgen.reach.still.disc import target_disc
from worldgen.reach.timed import confine
from worldgen.reach.timed.earliest import find_timed_path
from worldgen.reach.timed.latest import find_latest_start
from worldgen.reach.timed.spans import ChangingWalls, Spans
from worldgen.timeline import CellState, Timeline
from worldgen.world import Witness

FREE, SOLID, BURNING = CellState
OPEN = "###########\nS.........G\n###########"
GATE = OPEN.replace(".........", "....#....")
DEADLINES = st.integers(1, 80).map(lambda n: n / 20)


def changing(text, *events, radius=0.05, speed=0.5):
    return drawn(text, radius=radius, robot_speed=speed, timeline=Timeline.of(events))


def answer(world, deadline=None):
    """Return the timed decision, after a checker has confirmed its proof."""
    decision = decide_in_time(world, deadline)
    ahead = world if deadline is None else until(world, deadline)
    if decision.confinement is not None:
        report = check_confinement(ahead, decision.confinement)
    elif decision.certificate is not None:
        report = check_certificate(
            world if decision.result == REACHABLE else ahead, decision.certificate
        )
    else:
        assert decision.result == UNDECIDED
        return decision
    assert report.valid, (decision.reason, report.reason)
    return decision


def test_a_way_is_reachable_once_there_is_time_for_it():
    world = changing(OPEN, (9.0, 5, 1, BURNING))  # 1 m minus the target's radius, at 0.5 m/s
    assert [answer(world, deadline).result for deadline in (1.5, 1.9, 2.0)] == [
        BLOCKED,
        BLOCKED,
        REACHABLE,
    ]


def test_a_gate_that_opens_after_the_deadline_is_a_cut():
    world = changing(GATE, (3.0, 5, 1, FREE))
    early = answer(world, 2.9)
    assert early.result == BLOCKED and early.certificate is not None
    assert answer(world, 4.0).confinement is not None and answer(world, 4.5).result == REACHABLE


def test_what_comes_after_the_deadline_is_left_out():
    world = changing(GATE, (1.0, 5, 1, FREE), (7.0, 2, 1, SOLID))
    assert list(until(world, 2.0).timeline.times) == [1.0] and until(world, 7.0) is world


def test_a_robot_that_a_fire_overtakes_is_blocked():
    decision = answer(changing(OPEN, (0.5, 5, 1, BURNING)))
    assert decision.result == BLOCKED and decision.certificate is None


def test_a_start_that_burns_before_it_can_be_left_is_blocked():
    cells = [(0.05, ix, 1, BURNING) for ix in range(4)] + [(1.0, ix, 1, FREE) for ix in range(4)]
    assert answer(changing(OPEN, *cells)).confinement is not None


def test_regions_that_close_one_after_another_are_blocked():
    rooms = "S..#..#..G\n...#..#..."
    steps = [(1.0, 3, 1, FREE), (1.0, 3, 0, FREE), (3.0, 3, 1, SOLID), (3.0, 3, 0, SOLID)]
    steps += [(4.0, ix, iy, SOLID) for ix in (4, 5) for iy in (0, 1)] + [
        (5.0, 6, iy, FREE) for iy in (0, 1)
    ]
    assert decide(changing(rooms, *steps)).result == UNDECIDED
    assert answer(changing(rooms, *steps)).confinement is not None
    assert (
        answer(changing(rooms, *[event for event in steps if event[0] != 4.0])).result == REACHABLE
    )


def test_a_deadline_holds_in_a_world_that_stands_still():
    world = generate("maze", 3)
    arrival = world.certificate.duration
    assert (
        answer(world, arrival).result == REACHABLE
        and answer(world, 0.8 * arrival).confinement is not None
    )


@pytest.mark.gate
@given(changing_worlds(), DEADLINES)
def test_no_world_is_both_reached_in_time_and_blocked(world, deadline):
    decision = answer(world, deadline)
    earliest = decide(world)
    if decision.result == REACHABLE:
        assert decision.certificate.duration <= deadline
    if earliest.result == REACHABLE and earliest.certificate.duration <= deadline:
        assert decision.result == REACHABLE


@pytest.mark.gate
@given(changing_worlds())
def test_a_witness_in_haste_arrives_no_later_and_holds(world):
    decision = decide(world)
    assume(world.is_dynamic and decision.result == REACHABLE)
    walls = ChangingWalls(world, Spans(world), in_cells(world.robot_radius, world.cell_size))
    hasty = retime(world, walls, decision.certificate)
    report = check_certificate(world, hasty)
    assert report.valid and hasty.duration <= decision.certificate.duration, report.reason


@pytest.mark.gate
@pytest.mark.parametrize("seed", [0, 2, 5])
def test_a_witness_that_arrives_in_time_is_found_whatever_is_left_out_after_the_deadline(seed):
    for over in ("rooms", "cave", "maze", "forest"):
        world = generate("fire", seed, size=16, over=over, monotone=True, margin=1.0)
        assert answer(world, decide(world).certificate.duration).result == REACHABLE


def test_a_straight_way_in_haste_is_faster_than_the_steps_it_replaced():
    world = changing("......\n......\n.....G\nS.....", (9.0, 0, 3, SOLID))
    early = decide(world).certificate.duration - 0.02
    assert answer(world, early).certificate.duration <= early


@pytest.mark.gate
@given(changing_worlds(), st.sampled_from([1, 2, 3, 4, 8]))
@settings(max_examples=40)
def test_nothing_confines_a_robot_that_has_arrived(world, k):
    decision = decide(world)
    assume(decision.result == REACHABLE and decision.certificate.duration > 0)
    for deadline in (decision.certificate.duration, None):
        found = confine.confine(world, in_cells(world.robot_radius, 0.1), k, deadline)
        assert found.proof is None and found.earliest <= decision.certificate.duration


@given(changing_worlds(), DEADLINES)
def test_what_is_blocked_for_a_deadline_is_for_an_earlier_one(world, deadline):
    if answer(world, deadline).result == BLOCKED:
        assert answer(world, deadline / 2).result == BLOCKED


@pytest.mark.gate
@pytest.mark.parametrize("over", ["maze", "rooms", "cave", "forest"])
def test_fire_is_proved_to_leave_too_little_time(over):
    for seed in range(2):
        world = generate("fire", seed, size=20, over=over, monotone=seed % 2 == 0)
        assert answer(world, 0.7 * world.certificate.duration).result == BLOCKED


@pytest.fixture(scope="module")
def confined():
    world = generate("fire", 1, size=16, over="rooms", monotone=True)
    proof = decide_in_time(world, 0.8 * world.certificate.duration).confinement
    return until(world, proof.deadline), proof


def refusal(world, proof, **changes):
    report = check_confinement(world, dataclasses.replace(proof, **changes))
    assert not report.valid
    return report.reason


@pytest.mark.gate
def test_a_confinement_without_one_of_its_stays_is_refused(confined):
    world, proof = confined
    for index in range(0, len(proof.stays), max(1, len(proof.stays) // 6)):
        assert "leaves its stay into tile" in refusal(
            world, proof, stays=np.delete(proof.stays, index, axis=0)
        )


def test_a_confinement_whose_stay_begins_late_or_ends_early_is_refused(confined):
    world, proof = confined
    longest = int(np.argmax(proof.stays[:, 3] - proof.stays[:, 2]))
    for column, less in ((2, 1), (3, -1)):
        stays = proof.stays.copy()
        stays[longest, column] += less
        assert "leaves its stay" in refusal(world, proof, stays=stays)


def test_a_confinement_that_claims_too_much_is_refused(confined):
    world, proof = confined
    assert "leaves its stay" in refusal(world, proof, deadline=proof.deadline * 1.2)
    assert "farther than one tile's side" in refusal(world, proof, slab=proof.slab * 2)
    assert "is not a valid stay" in refusal(world, proof, stays=np.array([[-1, 0, 0, 0]]))
    assert not check_confinement(world, proof, radius=world.robot_radius / 3).valid
    faster = dataclasses.replace(world, robot_speed=world.robot_speed * 1.5)
    assert not check_confinement(faster, proof).valid
    there = dataclasses.replace(
        world, target=dataclasses.replace(world.target, x=world.start.x, y=world.start.y)
    )
    assert not check_confinement(there, proof).valid


def test_a_robot_may_wait_until_the_gate_shuts_less_its_way():
    world = changing(
        OPEN, (7.0, 5, 1, SOLID)
    )  # through the gate, out of its way after 0.6 m, at 0.5 m/s
    assert latest_start(world) == pytest.approx(7.0 - 0.6 / 0.5, abs=1e-5)
    assert latest_start(world, 5.0) == pytest.approx(5.0 - 2.0, abs=0.02)
    assert latest_start(changing(OPEN, (7.0, 5, 1, SOLID), (9.0, 5, 1, FREE))) == math.inf
    assert latest_start(changing(GATE, (7.0, 2, 1, SOLID))) is None


@pytest.mark.gate
@given(changing_worlds(), st.integers(1, 60).map(lambda n: n / 20))
@settings(max_examples=60)
def test_the_latest_start_is_what_trying_every_start_finds(world, start):
    """Search forward in time from every start, on the same graph.

    It succeeds up to the latest start, and not after it.
    """
    radius = in_cells(world.robot_radius, world.cell_size)
    place = in_cells(world.start.x, 0.1) * UNIT, in_cells(world.start.y, 0.1) * UNIT
    walls = ChangingWalls(world, Spans(world), radius)
    latest = find_latest_start(world, walls, 2, place, target_disc(world), None)
    assume(latest is None or abs(latest - start) > 1e-4)
    waits = walls.is_clear(place, place, 0, round(start * walls.spans.ticks))
    later = begun_at(world, start)
    walls = ChangingWalls(later, Spans(later), radius)
    found = waits and find_timed_path(later, walls, 2, place, target_disc(later)) is not None
    assert found == (latest is not None and start < latest)


def begun_at(world, start):
    """Return the world as it is from a given time."""
    walls = world.walls.astype(np.uint8)
    later = []
    for event in world.timeline:
        if event.time <= start:
            walls[event.iy, event.ix] = event.state
        else:
            later.append(event._replace(time=event.time - start))
    burning = [(0.0, int(ix), int(iy), BURNING) for iy, ix in np.argwhere(walls == BURNING)]
    return dataclasses.replace(world, walls=walls == SOLID, timeline=Timeline.of(burning + later))


@pytest.mark.gate
@given(st.integers(0, 10**6), st.sampled_from(["maze", "rooms", "forest", "trap"]), st.booleans())
@settings(max_examples=15)
def test_no_witness_may_begin_much_later_than_the_robot(seed, over, monotone):
    """A witness is straighter than the graph's paths, so it may exceed this a little."""
    world = generate("fire", seed, size=20, over=over, monotone=monotone)
    assert witness_margin(world, world.certificate) <= (latest_start(world) or 0.0) + 0.1


@pytest.mark.parametrize("deadline", [0.0, -1.0, math.nan, math.inf])
def test_a_deadline_that_is_none_is_refused(deadline):
    with raises(InvalidParameter, "not-positive"):
        decide_in_time(drawn(OPEN), deadline)


@pytest.mark.gate
@given(worlds_with_everything(), st.floats(1e-300, LATEST) | st.floats(0.01, 5.0))
@settings(max_examples=15)
def test_any_legal_world_gets_an_answer_in_time_and_any_proof_a_report(world, deadline):
    for asked in (None, deadline):
        answer(world, asked)
        assert latest_start(world, asked) is None or latest_start(world, asked) >= 0.0
    if (
        world.is_dynamic
        and isinstance(world.certificate, Witness)
        and check_certificate(world).valid
    ):
        assert witness_margin(world, world.certificate) >= 0.0
