"""Controllers that act for many robots at once.

Their runs in lockstep equal the single runs, bit for bit.
"""

import math
import warnings
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from sim import Command, Commands, Observation, Observations, RobotOptions, simulate, simulate_many
from sim.controllers import CONTROLLERS
from tests.helpers.raising import raises
from tests.reference.sim import layout
from tests.sim.test_batch import FIELDS, single
from tests.sim.test_episode import arena, cup
from worldgen import InvalidParameter, Pose, generate

STEP = 0.015  # s


@dataclass(frozen=True)
class TurnsAway:
    """Drives ahead; after a bump, turns left for a random number of steps."""

    senses = ("bump", "random")
    chance: float = 20.0

    def reset(self):
        return (0.0,)

    def act_many(self, observation, memory):
        rest = np.where(
            observation.bump, 5.0 + np.floor(observation.random * self.chance), memory[:, 0]
        )
        turns = rest > 0.0
        command = Commands(np.where(turns, 0.0, 2.0), np.where(turns, 12.0, 0.0), observation.bump)
        return command, np.where(turns, rest - 1.0, 0.0)[:, np.newaxis]


@dataclass(frozen=True)
class AlwaysTheSame(TurnsAway):
    """Turns left by a right angle after a bump, then pauses; without randomness, so it loops."""

    senses = ("bump",)

    def act_many(self, observation, memory):
        rest = np.where(observation.bump, 7.0, memory[:, 0])
        command = Commands(
            np.where(rest > 0.0, 0.0, 2.0), np.where(observation.bump, math.pi / 2, 0.0) / STEP
        )
        return command, np.maximum(rest - 1.0, 0.0)[:, np.newaxis]


@dataclass(frozen=True)
class OneByOne:
    """The same controller as a Python class for one robot."""

    many: TurnsAway
    senses = ("bump", "random")

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        rest = (
            5.0 + math.floor(observation.random * self.many.chance)
            if observation.bump
            else memory[0]
        )
        if rest > 0.0:
            return Command(0.0, 12.0, observation.bump), (rest - 1.0,)
        return Command(2.0, 0.0, observation.bump), (0.0,)


def assert_all_single(worlds, controller, runs, **options):
    for row in runs.to_numpy():
        found = tuple(row[field].item() for field in FIELDS)
        assert found == single(worlds[row["world"]], controller, int(row["seed"]), **options)


def test_loops_of_many_periods_end_after_their_first_period_each():
    worlds = [generate("maze", seed=seed, size=14) for seed in range(30)]
    runs = simulate_many(worlds, AlwaysTheSame(), digest=True, steps=20_000)
    looped = runs.verdicts == "loop"
    assert looped.sum() >= 10 and len(set(runs.steps[looped].tolist())) >= 8
    assert_all_single(worlds, AlwaysTheSame(), runs, steps=20_000)


def test_it_is_the_controller_for_one_robot_to_the_bit():
    for seed in range(5):
        world = generate("trap", seed=seed)
        many, one = (
            simulate(world, who, seed=seed, steps=3000)
            for who in (TurnsAway(), OneByOne(TurnsAway()))
        )
        assert (many.verdict, many.trace_digest) == (one.verdict, one.trace_digest)


def test_beams_noise_and_starts_are_each_robots_own():
    @dataclass(frozen=True)
    class Looks(TurnsAway):
        senses = ("bump", "random", "beams", "odometry_x")
        needs = RobotOptions(beams=5, beam_noise=0.1, slip=0.2)

        def act_many(self, observation, memory):
            command, after = super().act_many(observation, memory)
            return command._replace(
                speed=np.minimum(command.speed, 3.0 * observation.beams[:, 2])
            ), after

    starts = [Pose(0.35, 0.35, 0.0), Pose(0.75, 0.35, 1.0)]
    runs = simulate_many(arena(16), Looks(), starts=starts, seeds=4, digest=True, steps=300)
    for row in runs.to_numpy():
        world = replace(arena(16), start=starts[row["start"]])
        assert tuple(row[field].item() for field in FIELDS) == single(
            world, Looks(), int(row["seed"]), steps=300
        )


def test_one_that_raises_crashes_where_it_does_alone():
    @dataclass(frozen=True)
    class Raises(TurnsAway):
        def act_many(self, observation, memory):
            if (observation.random > 0.7).any():
                raise ValueError("unlucky")
            return super().act_many(observation, memory)

    with pytest.warns(UserWarning, match="Raises raised an exception for some of its robots"):
        runs = simulate_many(arena(), Raises(), seeds=20, steps=1)
    assert 2 <= (runs.verdicts == "crash").sum() <= 12 and set(runs.verdicts) == {
        "crash",
        "stalled",
    }
    for row in runs.to_numpy():
        assert row["verdict"] == single(arena(), Raises(), int(row["seed"]), steps=1)[0]


def test_one_that_remembers_outside_its_memory_is_not_believed():
    @dataclass(frozen=True)
    class Remembers(AlwaysTheSame):
        seen: list = field(default_factory=list)

        def act_many(self, observation, memory):
            self.seen.append(1)
            return super().act_many(observation, memory)

    world = next(w for w in (generate("maze", seed=s, size=14) for s in range(30)) if loops(w))
    with pytest.warns(UserWarning, match="one robot at a time"):
        assert simulate_many(world, Remembers(), steps=5000).verdicts[0] in ("stalled", "timeout")


CALLS = []


def test_a_variable_of_an_imported_module_is_noticed_too():
    class Counts(AlwaysTheSame):
        def act_many(self, observation, memory):
            CALLS.append(1)
            return super().act_many(observation, memory)

    world = next(w for w in (generate("maze", seed=s, size=14) for s in range(30)) if loops(w))
    assert simulate(world, Counts(), steps=5000).verdict in ("stalled", "timeout")


def test_worlds_in_which_robots_are_faster_or_larger_run_with_the_others():
    worlds = [
        arena(),
        replace(arena(), robot_speed=20.0),
        replace(arena(), robot_radius=0.03),
        cup(),
    ]
    assert_all_single(
        worlds,
        TurnsAway(),
        simulate_many(worlds, TurnsAway(), seeds=2, digest=True, steps=400),
        steps=400,
    )


def test_memory_and_commands_must_keep_their_shapes():
    class Flat(TurnsAway):
        def act_many(self, observation, memory):
            return Commands(1.0), memory[:, 0]

    class Wide(TurnsAway):
        def act_many(self, observation, memory):
            return Commands(observation.beams[:, :0].sum(axis=1) + np.ones((1, 1))), memory

    assert (
        "returned memory has shape (1,), but its shape was (1, 1)"
        in simulate(arena(), Flat()).evidence.error
    )
    assert (
        "speed has shape (1, 1), but there are 1 robots" in simulate(arena(), Wide()).evidence.error
    )


def loops(world):
    return simulate(world, AlwaysTheSame(), steps=5000).verdict == "loop"


@pytest.mark.parametrize(
    ("speed", "verdict"),
    [(np.nan, "invalid-command"), ("fast", "crash"), ([1.0, 2.0], "invalid-command")],
)
def test_nonsense_gets_the_verdict_that_it_gets_alone(speed, verdict):
    class Nonsense(TurnsAway):
        def act_many(self, observation, memory):
            return Commands(speed), memory

    assert simulate(arena(), Nonsense()).verdict == verdict
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the warning that it is run one by one
        runs = simulate_many(arena(), Nonsense(), seeds=3)
    assert runs.verdicts.tolist() == [verdict] * 3


def test_observation_and_memory_are_not_to_be_written():
    class Writes(TurnsAway):
        def act_many(self, observation, memory):
            memory[:] = 1.0
            return Commands(1.0), memory

    episode = simulate(arena(), Writes())
    assert episode.verdict == "crash" and "read-only" in episode.evidence.error


def test_a_class_that_cannot_act_is_refused_with_both_ways_out(tmp_path):
    (tmp_path / "mine.py").write_text("class Mine:\n    def reset(self):\n        return ()\n")
    with raises(InvalidParameter, "not-a-controller", missing="act"):
        CONTROLLERS.get(f"{tmp_path / 'mine.py'}:Mine")


def test_the_columns_have_the_names_of_the_numbers():
    assert Observations._fields == Observation._fields and Commands._fields == Command._fields


def test_the_layout_of_columns_is_that_of_numbers():
    @dataclass(frozen=True)
    class Keeps(TurnsAway):
        senses = (
            "bump",
            "heading",
            "x",
            "y",
            "target_heading",
            "target_distance",
            "time_step",
            "top_speed",
        )

        def reset(self):
            return (0.0,) * (layout.OBS_SIZE - 1)

        def act_many(self, observation, memory):
            return Commands(1.0, 0.5), np.stack(
                [np.nan_to_num(column) for column in observation[1 : layout.OBS_SIZE]], axis=1
            )

    trace = simulate(arena(), Keeps(), steps=5, record=True).trace
    told = trace.states[-1, layout.STATE_MEMORY :].view(np.float64)
    assert (
        told[layout.OBS_X - 1] == trace.x[-1] and told[layout.OBS_TIME_STEP - 1] == trace.time_step
    )
