"""Edits run in compiled code give the same results as edits made in NumPy and run one by one."""

from dataclasses import replace

import numpy as np
import pytest

from fuzz.shrink.edits import edited
from sim.controllers import CONTROLLERS
from sim.episode import prepare
from sim.options.run import RunOptions
from sim.runners import edited as edited_runs
from sim.runners.edited import CellEdit, EditedRuns, EditKind, Wanted, has_sure_path
from tests.reference.sim import layout
from worldgen import CellState, Event, InvalidWorld, Pose, Target, Timeline, World, decide

STEPS = 3_000


def room(dynamic=False, **parts):
    walls = np.zeros((9, 11), bool)
    walls[[0, -1], :] = walls[:, [0, -1]] = True
    walls[6, 3:8] = walls[4:6, 3] = walls[4:6, 7] = True
    fire = [
        Event(0.3, 2, 2, CellState.BURNING),
        Event(0.9, 8, 7, CellState.SOLID),
        Event(1.2, 4, 6, CellState.FREE),
    ]
    world = World(
        walls,
        Pose(0.56, 0.25, 1.5),
        Target(0.55, 0.75, 0.05),
        timeline=Timeline.of(fire if dynamic else []),
    )
    return replace(world, **parts)


def edits_of(world):
    yield from (CellEdit(EditKind.FREE_RUN, first, 1) for first in range(world.solid_cells))
    yield from (
        CellEdit(EditKind.FREE_BOX, ix, iy, 3, 2) for iy in range(0, 9, 2) for ix in range(0, 11, 3)
    )
    yield CellEdit(EditKind.FREE_RIM)
    yield from (
        CellEdit(EditKind.DROP_ROWS, first, count)
        for count in (1, 3)
        for first in range(world.height - count + 1)
    )
    yield from (
        CellEdit(EditKind.DROP_COLUMNS, first, count)
        for count in (1, 4)
        for first in range(world.width - count + 1)
    )


def plain(world, edit, controller, motion, step):
    """Return how a run of the edited world ends, and whether it overlaps a wall.

    Return nothing if there is no such world.
    """
    simpler = edited(world, edit)
    if simpler is None:
        return None
    try:
        run = prepare(simpler, controller, RunOptions(motion, STEPS, step))
    except InvalidWorld:
        return None
    outcome = run.run(STEPS, find_loop=True, record=False)
    return outcome.ending, outcome.overlap_step >= 0


ENDINGS = {
    "loop": layout.LOOP,
    "tunnel": layout.TUNNEL,
    "burned": layout.BURNED,
    "limit": layout.LIMIT,
}


@pytest.mark.gate
@pytest.mark.parametrize("dynamic", [False, True], ids=["still", "changing"])
@pytest.mark.parametrize(("motion", "step"), [("swept", 0.015), ("endpoint", 0.08)])
@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("overlap", [True, False])
def test_each_edit_ends_as_when_it_is_run_alone(motion, step, ending, overlap, dynamic):
    world, controller = room(dynamic), CONTROLLERS.get("turn-right")
    runs = EditedRuns(world, controller, RunOptions(motion, STEPS, step))
    for edit in edits_of(world):
        found, _ = runs.first([edit], Wanted(ENDINGS[ending], overlap=overlap), way=False)
        assert (found is not None) == (
            plain(world, edit, controller, motion, step) == (ending, overlap)
        ), edit


@pytest.mark.parametrize("steps_at_once", [7, 1_000_000])
def test_the_first_of_many_edits_is_found_and_the_rest_goes_on_from_there(
    steps_at_once, monkeypatch
):
    monkeypatch.setattr(edited_runs, "_STEPS_AT_ONCE", steps_at_once)
    world, controller = room(), CONTROLLERS.get("turn-right")
    edits = list(edits_of(world))
    runs, hits, begin = EditedRuns(world, controller, RunOptions("swept", STEPS)), [], 0
    while begin < len(edits):
        found, done = runs.first(edits[begin:], Wanted(layout.LOOP, overlap=False), way=False)
        hits += [] if found is None else [begin + found]
        begin += done
    alone = [
        k
        for k, edit in enumerate(edits)
        if plain(world, edit, controller, "swept", 0.015) == ("loop", False)
    ]
    assert hits == alone and 0 < len(alone) < len(edits)


@pytest.mark.gate
@pytest.mark.parametrize("radius", [0.03, 0.05, 0.07, 0.11])
def test_a_way_that_the_flood_sees_is_one(radius):
    seen = 0
    for seed in range(60):
        walls = np.random.default_rng(seed).random((7, 7)) < 0.35
        walls[:3, :3] = walls[4:, 4:] = False
        world = World(walls, Pose(0.151, 0.149, 0.0), Target(0.55, 0.55, 0.03), robot_radius=radius)
        if has_sure_path(world):
            seen += 1
            assert decide(world).result == "reachable"
    assert seen


@pytest.mark.parametrize(
    ("free", "radius", "start"),
    [(1, 0.04, 1636), (2, 0.05, 1536)],
    ids=["at the start, beside a node", "at a node"],
)
def test_a_centre_on_the_circle_around_the_target_has_arrived(free, radius, start):
    # The target is in a wall, at 1024 lattice units from the farthest place that the disc reaches.
    def metres(units):
        return round(0.1 * units / 1024, 12)

    walls = np.ones((3, 6), bool)
    walls[1, 1 : 1 + free] = False
    end = start + 1024 * free
    answers = []
    for length in (1024, 1023):
        target = Target(metres(end), 0.15, metres(length))
        world = World(walls, Pose(metres(start), 0.15), target, robot_radius=radius)
        answers.append((has_sure_path(world), decide(world).result == "reachable"))
    assert answers[0] == (True, True)
    assert not answers[1][0]
