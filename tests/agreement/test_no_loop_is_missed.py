"""A plain dictionary of all states finds every repetition.

The simulator must find the same ones.
"""

import functools

import numpy as np
import pytest

from sim import Command, CompiledController, RunOptions, simulate, simulate_many
from sim.controllers import CONTROLLERS, Commands
from sim.episode import prepare
from sim.runners.edited import ANY_ENDING, CellEdit, EditedRuns, EditKind, Wanted
from tests.reference.sim.layout import CMD_SPEED, LOOP
from worldgen import generate
from worldgen.family import FAMILIES
from worldgen.world import Pose, Target, World

MOTIONS = ("swept", "endpoint", "stepped")
THESIS = ("turn-left", "turn-right", "turn-random")
FEW_FAMILIES = ("trap", "fire", "forest", "shift", "corridor")
ALIASES = ("thesis-1", "thesis-2", "thesis-3")


def first_repetition(world, controller, options):
    """Find the entry and period of the first state that recurs after the last event, by dictionary.

    None if no state does.
    """
    run = prepare(world, controller, options)
    whole = run.run(options.steps, find_loop=False, record=True)
    seen = {}
    for step in range(run.last_event_step, whole.trace.steps + 1):
        entry = seen.setdefault(whole.trace.states[step].tobytes(), step)
        if entry != step:
            return entry, step - entry
    return None


def found_in(episode):
    """Return the same according to the verdict."""
    if episode.verdict != "loop":
        return None
    return episode.evidence.entry, episode.evidence.period


def scenarios(families, seeds, names):
    """Worlds with each controller under every motion model that it runs under."""
    for family in families:
        for seed in seeds:
            world = generate(family, seed=seed)
            for motion in MOTIONS:
                for name in sorted({*THESIS} & {*names}) if motion == "stepped" else names:
                    yield world, name, motion


def compare(families, seeds, names, steps):
    """How many runs repeat a state within their budget; all of them must be found."""
    repeated = 0
    for world, name, motion in scenarios(families, seeds, names):
        options = RunOptions(motion, steps)
        wanted = first_repetition(world, name, options)
        episode = simulate(world, name, options)
        if episode.verdict != "overlap":  # which is more specific than a loop
            assert found_in(episode) == wanted, (world.provenance, name, motion)
        repeated += wanted is not None
    return repeated


@pytest.mark.gate
def test_every_repetition_in_a_dictionary_of_states_is_found():
    assert compare(FEW_FAMILIES, range(1, 6), ["turn-left", "turn-random", "q-learning"], 500) > 20


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(2, 8))
def test_every_repetition_of_thousands_of_longer_runs_is_found(seed):
    assert (
        compare(
            [name for name in FAMILIES.names() if not FAMILIES.get(name).places_robots],
            [seed],
            [name for name in CONTROLLERS.names() if name not in ALIASES],
            4_000,
        )
        > 50
    )


def room():
    """A room in which a robot can stand anywhere."""
    cells = np.ones((7, 7), bool)
    cells[1:-1, 1:-1] = False
    cells[3, 3] = True
    return World(cells, Pose(0.2, 0.2, 0.0), Target(0.5, 0.5, 0.01))


def _count(observation, memory, command):
    memory[0] += 1.0
    if memory[0] == memory[1]:
        memory[0] = memory[2]
    command[CMD_SPEED] = 0.0


class Counts:
    """Counts to ``end``, then goes back to ``entry``.

    State ``entry`` recurs at step ``end`` for the first time.
    """

    def __init__(self, entry, end):
        self.entry = float(entry)
        self.end = float(end)

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        now = memory[0] + 1.0
        return Command(0.0, 0.0), (self.entry if now == self.end else now,)


class ManyCount:
    """The same for many robots."""

    def __init__(self, entry, end):
        self.entry = float(entry)
        self.end = float(end)

    def reset(self):
        return (0.0,)

    def act_many(self, observation, memory):
        return Commands(), np.where(memory + 1.0 == self.end, self.entry, memory + 1.0)


@functools.cache
def counter(entry, end):
    return CompiledController("count", _count, (0.0, float(end), float(entry)), senses=("bump",))


CASES = [
    (0, 1),
    (0, 40),
    (1, 41),
    (17, 300),
    (255, 256),
    (256, 512),
    (299, 300),
    (100, 311),
    (300, 311),
]


@pytest.mark.gate
@pytest.mark.parametrize("make", [counter, Counts, ManyCount], ids=["compiled", "class", "vector"])
@pytest.mark.parametrize(("entry", "end"), CASES)
def test_a_state_that_comes_back_in_the_last_step_of_the_budget_is_found_and_one_later_is_not(
    make, entry, end
):
    assert found_in(simulate(room(), make(entry, end), steps=end)) == (entry, end - entry)
    if end > 1:
        assert found_in(simulate(room(), make(entry, end), steps=end - 1)) is None


@pytest.mark.gate
@pytest.mark.parametrize("make", [counter, ManyCount], ids=["compiled", "vector"])
def test_many_runs_at_once_find_the_same_loops(make):
    for entry, end in CASES:
        for steps in (end, end + 1):
            alone = simulate(room(), make(entry, end), steps=steps)
            runs = simulate_many(room(), make(entry, end), steps=steps, digest=True, seeds=2)
            assert runs.verdicts.tolist() == ["loop"] * 2
            assert (runs.steps == alone.steps).all() and alone.steps == end
            assert f"{int(runs.digest[0]):016x}" == alone.trace_digest


def test_edited_worlds_find_the_same_loops():
    edits = [CellEdit(EditKind.FREE_RUN, 0, 1)]
    for entry, end in CASES:
        for steps, ending in ((end, LOOP), (end - 1, 0)):
            if steps:
                runs = EditedRuns(room(), counter(entry, end), RunOptions(steps=steps))
                assert runs.first(edits, Wanted(ending), way=False) == (0, 1)
                assert EditedRuns(room(), counter(entry, end), RunOptions(steps=steps)).first(
                    edits, Wanted(ANY_ENDING), way=False
                ) == (0, 1)
