"""Many runs in a batch equal the single runs, bit for bit, in any order and with any number of
threads.
"""

import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import CompiledController, RobotOptions, RunOptions, simulate, simulate_many
from sim.controllers import CONTROLLERS
from sim.episode.batch import VERDICTS
from sim.runners.lattice import LatticeRun
from sim.runners.many import run_many
from tests.helpers.raising import raises
from tests.sim.test_episode import GoToTarget, arena, cup
from worldgen import CellState, Event, InvalidParameter, InvalidWorld, Pose, Timeline, generate

FIELDS = ("verdict", "steps", "time", "path_length", "collisions", "digest")


def burning():
    return replace(
        cup(),
        timeline=Timeline.of(
            [Event(0.5, 7, 7, CellState.BURNING), Event(0.9, 7, 7, CellState.FREE)]
        ),
    )


def single(world, controller, seed, **options):
    episode = simulate(world, controller, seed=seed, **options)
    digest = int(episode.trace_digest, 16)
    return (
        VERDICTS.index(episode.verdict), episode.steps, episode.time, episode.path_length, episode.collisions, digest,
    )  # fmt: skip


@settings(max_examples=15)
@given(st.integers(1, 4), st.permutations(range(6)), st.booleans())
def test_neither_threads_nor_order_change_a_run(workers, order, digest):
    worlds = [generate("maze", seed=seed, size=14) for seed in range(2)]
    names, seeds = ("turn-random", "turn-left"), [7, 8, 9, 10, 11, 12]
    plain = simulate_many(worlds, names, seeds=seeds, steps=400, digest=True, workers=1)
    mixed = simulate_many(
        worlds, names, seeds=[seeds[k] for k in order], steps=400, digest=digest, workers=workers
    )
    back = np.argsort(np.lexsort((mixed.seed, mixed.controller, mixed.world)))
    for field in FIELDS[: 6 if digest else 5]:
        assert (getattr(plain, field)[back] == getattr(mixed, field)).all()


def test_starts_are_run_in_every_world():
    starts = [Pose(0.35, 0.35, 0.0), Pose(0.75, 0.35, 1.0)]
    runs = simulate_many([arena(16), cup()], "turn-left", starts=starts, steps=500, digest=True)
    assert runs.start.tolist() == [0, 1, 0, 1]
    for row, world in enumerate([arena(16), arena(16), cup(), cup()]):
        moved = replace(world, start=starts[row % 2])
        assert int(runs.digest[row]) == int(
            simulate(moved, "turn-left", steps=500).trace_digest, 16
        )


def test_python_controllers_run_too_and_keep_their_names():
    runs = simulate_many(arena(), [GoToTarget(), "turn-left"], seeds=2, steps=2000)
    assert runs.names == ("GoToTarget", "turn-left") and runs.verdicts[:2].tolist() == [
        "reached",
        "reached",
    ]


def test_a_controller_that_raises_in_some_runs_crashes_in_those_alone():
    def act(observation, memory, command):
        memory[int(observation[9] * 1.5)] = 1.0  # beyond its memory for draws above 2/3
        command[2] = 1.0

    runs = simulate_many(
        arena(), CompiledController("odd", act, (0.0,), randomised=True), seeds=40, steps=1
    )
    assert 5 <= (runs.verdicts == "crash").sum() <= 25 and set(runs.verdicts) == {
        "crash",
        "stalled",
    }


def test_results_print_themselves_and_convert():
    runs = simulate_many([arena(), cup()], ["turn-left", "turn-random"], seeds=5, steps=3000)
    text = repr(runs)
    assert text.startswith("20 runs, ") and "turn-random: " in text
    table = runs.to_numpy()
    assert (
        table.dtype.names[:4] == ("world", "controller", "start", "seed")
        and len(table) == len(runs) == 20
    )


@pytest.mark.parametrize(
    ("arguments", "error", "expected"),
    [
        ({"worlds": []}, InvalidParameter, {"code": "nothing-given"}),
        ({"seeds": 0}, InvalidParameter, {"code": "nothing-given"}),
        ({"starts": []}, InvalidParameter, {"code": "nothing-given"}),
        (
            {"controllers": "turn-lft"},
            InvalidParameter,
            {"code": "unknown-name", "name": "turn-lft"},
        ),
        ({"seed": 3}, InvalidParameter, {"code": "seed-for-many-runs"}),
        ({"slipp": 3}, InvalidParameter, {"code": "unknown-name", "name": "slipp"}),
        ({"starts": [Pose(0.0, 0.0, 0.0)]}, InvalidWorld, {"code": "start-in-wall"}),
    ],
)
def test_bad_input_gets_a_sentence(arguments, error, expected):
    with raises(error, **expected):
        simulate_many(**{"worlds": arena(), "controllers": "turn-left", **arguments})


def test_a_batch_that_another_thread_stops_runs_no_further():
    options = RunOptions(steps=50_000_000, robot=RobotOptions(slip=0.1))
    controller = CONTROLLERS.get("random-walk")
    run = LatticeRun(cup(), controller, options)
    starts = np.array([run.start_of(run.world.start)] * 3, np.int64)
    stop = threading.Event()
    stop.set()
    seeds = np.arange(3, dtype=np.uint64)
    assert len(run_many(run, starts, seeds, digest=False, stop=stop)) == 0


def test_options_given_at_once_are_those_given_one_by_one():
    world = generate("maze", 3, size=12)
    at_once = simulate_many(
        world, "wall-left", RunOptions(motion="endpoint", steps=50), seeds=2, digest=True
    )
    assert np.array_equal(
        at_once.digest,
        simulate_many(world, "wall-left", motion="endpoint", steps=50, seeds=2, digest=True).digest,
    )


def test_options_at_once_and_one_by_one_are_refused_together():
    with raises(InvalidParameter, "options-given-twice", settings=["steps"]):
        simulate_many(generate("maze", 3, size=12), "wall-left", RunOptions(), steps=50)


def test_the_seed_of_options_is_refused_for_many_runs():
    with raises(InvalidParameter, "seed-for-many-runs"):
        simulate_many(generate("maze", 3, size=12), "wall-left", RunOptions(seed=3), seeds=2)
