"""Classes of failures: their names do not depend on mirroring, rotating or shifting the world."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.facts.contacts import contacts, enclosure, part_of, winding_number
from fuzz.facts.proofs import certified
from fuzz.facts.signature import failure_class
from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from fuzz.oracles import worlds as corresponding
from sim.episode import Episode, simulate
from sim.evidence import BudgetEvidence, BurnedEvidence, LoopEvidence, WallEvidence
from sim.trace import Trace
from worldgen import Pose, Target, Timeline, World
from worldgen.timeline import CellState, Event

NOTHING = np.zeros((0, 1), np.uint64)


def world_of(*rows, timeline=None, **changes):
    """A world of cells of 1 m, the top row first.

    Start and target are in the middle of the cells S and G.
    """
    cells = np.array([list(row) for row in rows[::-1]])
    (sy, sx), (gy, gx) = (np.argwhere(cells == mark)[0].tolist() for mark in "SG")
    start, target = Pose(sx + 0.5, sy + 0.5, 0.0), Target(gx + 0.5, gy + 0.5, 0.3)
    line = Timeline.of(timeline or [])
    return World(
        cells == "#", start, target, cell_size=1.0, robot_radius=0.4, timeline=line, **changes
    )


def trace_of(places, bumps=(), headings=None):
    """Return a trace through places, m."""
    x, y = np.array(places, np.float64).T.copy()
    bump = np.isin(np.arange(len(x)), bumps)
    heading = np.zeros(len(x)) if headings is None else np.array(headings, np.float64)
    steps = np.arange(len(x))
    return Trace(1.0, x, y, heading, bump, x, y, steps, np.ones(len(x)), NOTHING, NOTHING, True)


def loop(entry, period):
    return LoopEvidence(entry=entry, period=period, state_digest="0" * 16)


def looping(trace):
    return Episode("loop", trace.steps, 1.0, 1.0, 1, "", loop(0, trace.steps), trace)


def turned_trace(trace, world):
    high = world.height * world.cell_size
    return replace(
        trace, x=high - trace.y, y=trace.x, path_x=high - trace.path_y, path_y=trace.path_x,
        heading=(trace.heading + math.pi / 2 + math.pi) % (2 * math.pi) - math.pi,
    )  # fmt: skip


def mirrored_trace(trace, world):
    wide = world.width * world.cell_size
    heading = (math.pi - trace.heading + math.pi) % (2 * math.pi) - math.pi
    return replace(trace, x=wide - trace.x, path_x=wide - trace.path_x, heading=heading)


def shifted_trace(trace, world):
    right, up = 3 * world.cell_size, 5 * world.cell_size
    return replace(
        trace, x=trace.x + right, y=trace.y + up, path_x=trace.path_x + right, path_y=trace.path_y + up
    )  # fmt: skip


WAYS = {
    "turn": (corresponding.turned, turned_trace),
    "mirror": (corresponding.mirrored, mirrored_trace),
    "shift": (corresponding.shifted, shifted_trace),
}


def corner_of(evidence, way, world):
    """Return the evidence, with its cell moved along with the world."""
    if not isinstance(evidence, (WallEvidence, BurnedEvidence)):
        return evidence
    ix, iy = evidence.cell
    there = {
        "turn": (world.height - 1 - iy, ix),
        "mirror": (world.width - 1 - ix, iy),
        "shift": (ix + 3, iy + 5),
    }
    return replace(evidence, cell=there[way])


def failures(controller, motion):
    """Return failing runs in random layouts."""

    def run(data):
        world = decode_world(data)
        proved = certified(world)
        return (
            None
            if proved is None
            else (proved, simulate(proved, controller, record=True, motion=motion))
        )

    drawn = st.binary(min_size=LAYOUT_BYTES, max_size=LAYOUT_BYTES).map(run)
    return drawn.filter(lambda pair: pair is not None and pair[1].verdict != "reached")


@pytest.mark.gate
@given(st.one_of(failures("turn-right", "swept"), failures("turn-right", "stepped")))
def test_a_run_seen_turned_mirrored_or_shifted_is_of_the_same_class(failure):
    world, episode = failure
    kind = failure_class(world, episode)
    for way, (see_world, see_trace) in WAYS.items():
        evidence = corner_of(episode.evidence, way, world)
        there = replace(episode, trace=see_trace(episode.trace, world), evidence=evidence)
        assert failure_class(see_world(world), there) == kind


@pytest.mark.gate
@given(failures("wall-right", "swept").filter(lambda pair: pair[1].verdict == "loop"))
def test_a_robot_that_cannot_tell_where_it_is_runs_into_the_same_class(failure):
    world, episode = failure
    for way in ("turn", "shift"):
        there = WAYS[way][0](world)
        again = simulate(
            there, "wall-right", record=True, motion="swept", steps=4 * episode.steps + 100
        )
        assert failure_class(there, again) == failure_class(world, episode)


ROOM = world_of("#######", "#.....#", "#.S...#", "#...G.#", "#######")


@pytest.mark.parametrize(
    ("rows", "place", "kind"),
    [
        (("S....", ".....", "..#..", ".....", "....G"), (2.5, 1.6), "post"),
        (("S....", ".....", ".##..", ".....", "....G"), (3.4, 2.5), "end"),
        (("S....", ".....", "###..", "###..", "....G"), (1.5, 3.4), "wall"),
        (("S....", ".....", "###..", "###..", "....G"), (3.28, 3.28), "corner"),
        (("S....", ".....", "###..", "#....", "....G"), (1.4, 1.6), "nook"),
        (
            ("S....", ".....", "###..", "#....", "....G"),
            (1.41, 1.6),
            "nook",
        ),  # robots stop a little short of a wall
        (("S....", ".....", ".....", ".....", "....G"), (0.4, 2.5), "wall"),
        (("S....", ".....", ".....", ".....", "....G"), (0.4, 0.4), "nook"),
    ],
)
def test_a_contact_is_of_the_kind_of_the_wall_there(rows, place, kind):
    found = contacts(world_of(*rows), trace_of([(2.0, 4.5), place], bumps=[1]), 0, 1)
    assert [contact.kind for contact in found] == [kind]


def test_a_touch_that_goes_on_is_one_and_so_is_one_across_the_end_of_a_period():
    trace = trace_of([(1.5, 1.5)] * 8, bumps=[0, 1, 4, 5, 7])
    assert len(contacts(ROOM, trace, 0, 7)) == 2


def test_a_path_round_a_cell_is_told_from_one_beside_it():
    x, y = np.array([0.0, 2.0, 2.0, 0.0, 0.0]), np.array([0.0, 0.0, 2.0, 2.0, 0.0])
    assert winding_number(x, y, {(0, 0)}) == 1 and winding_number(x, y, {(2, 0)}) == 0
    assert winding_number(np.append(x, x[1:]), np.append(y, y[1:]), {(5, 5), (0, 0)}) == 2


@pytest.mark.parametrize(
    ("place", "word"),
    [
        ((7.5, 12.5), "open"),
        ((1.5, 7.5), "side"),
        ((1.5, 1.5), "bend"),
        ((7.5, 2.5), "pocket"),
        ((11.5, 7.5), "passage"),
    ],
)
def test_a_place_is_shut_in_by_the_walls_near_it(place, word):
    walls = np.zeros((19, 19), bool)
    walls[1:3, 6] = walls[1:3, 8] = walls[5:10, 10] = walls[5:10, 12] = True
    world = World(
        walls, Pose(7.5, 7.5, 0.0), Target(3.5, 3.5, 0.3), cell_size=1.0, robot_radius=0.4
    )
    assert enclosure(world, [place]) == word


CIRCLE = [(2.5, 2.5), (4.5, 2.5), (4.5, 4.5), (2.5, 4.5), (2.5, 2.5)]
ISLAND = world_of(
    "S.......", "........", "........", "........", "...#....", "........", "........", ".......G"
)


@pytest.mark.parametrize(
    ("bumps", "headings", "name"),
    [
        ([1], None, "loop-1bump-post-round-near-closer"),
        ([1, 3], None, "loop-2bump-post-round-near-closer"),
        ([], None, "loop-free-bend-swing-near-closer"),
        ([], [0.0, 1.6, 3.1, -1.6, 0.0], "loop-free-bend-turn-near-closer"),
        (
            [],
            [0.0, math.pi, 0.0, math.pi, 0.0],
            "loop-free-bend-swing-near-closer",
        ),  # half a turn is neither left nor right
    ],
)
def test_a_loop_is_called_after_its_touches_and_its_shape(bumps, headings, name):
    assert failure_class(ISLAND, looping(trace_of(CIRCLE, bumps, headings))) == name


def test_what_was_touched_in_the_first_half_of_a_stalled_run_is_not_in_its_class():
    trace = trace_of([*CIRCLE, *[CIRCLE[0]] * 4], bumps=[1])
    assert (
        failure_class(
            ISLAND, Episode("stalled", 8, 8.0, 1.0, 1, "", BudgetEvidence(last_new_cell=0), trace)
        )
        == "stalled-free-bend-spot"
    )


@pytest.mark.parametrize(
    ("state", "kind"), [(CellState.SOLID, "post"), (CellState.BURNING, "wall")]
)
def test_walls_count_as_they_are_when_the_world_has_come_to_rest(state, kind):
    world = world_of(
        "S....", ".....", ".....", ".....", "....G", timeline=[Event(1.0, 2, 2, state)]
    )
    found = contacts(world, trace_of([(2.0, 4.5), (2.5, 1.6)], bumps=[1]), 0, 1)
    assert [contact.kind for contact in found] == [kind]


def test_a_loop_no_nearer_to_the_target_than_the_start_is_away():
    back = replace(ISLAND, start=Pose(7.5, 1.5, 0.0))
    trace = trace_of([(5.5, 1.5), *CIRCLE])
    episode = replace(looping(trace), evidence=loop(1, 4))
    assert failure_class(back, episode).endswith("away")


@pytest.mark.parametrize(
    ("time", "name"), [(0.0, "burned-burning-entered"), (1.5, "burned-burning-caught")]
)
def test_who_drives_into_a_fire_is_told_from_who_is_caught(time, name):
    world = world_of("S..G", "....", timeline=[Event(time, 2, 1, CellState.BURNING)])
    evidence = BurnedEvidence(step=2, cell=(2, 1), state="burning")
    episode = Episode(
        "burned", 2, 2.0, 1.0, 0, "", evidence, trace_of([(0.5, 1.5), (1.0, 1.5), (1.7, 1.5)])
    )
    assert failure_class(world, episode) == name


@pytest.mark.parametrize(
    ("cell", "part"), [((3, 3), "post"), ((-1, 3), "block"), ((3, 8), "block")]
)
def test_what_lies_outside_the_grid_is_part_of_a_block(cell, part):
    assert part_of(ISLAND, *cell) == part
