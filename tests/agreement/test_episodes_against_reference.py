"""Whole runs of the core match the plain-Python reference bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from sim import CompiledController, RobotOptions, RunOptions, simulate
from sim._core import lib
from sim.episode import prepare
from sim.runners.core_calls import CoreEpisode, Driver, most_points
from tests.helpers.interpreted import ACTS
from tests.reference.sim import lattice_episode, lattice_state, recurrence
from tests.reference.sim.flat_arrays import COUNTS, arena_of, settings_of
from tests.sim.test_batch import burning
from tests.sim.test_episode import cup
from worldgen import generate
from worldgen.robot import Drive, Pose, Robot, Target

STEPS = 90


def box(length, width, ahead=0.0):
    """Return the corners of a rectangle whose middle is some way ahead of the axle."""
    return tuple((ahead + sx * length / 2, sy * width / 2) for sx, sy in _SIGNS)


_SIGNS = ((1, 1), (-1, 1), (-1, -1), (1, -1))
ROBOTS = {
    "plain": {},
    "slippery": {"slip": 0.3, "odometry_noise": 0.2},
    "heavy": {"acceleration": 0.4, "friction": 0.3, "turn_limit": 2.0, "wall_friction": 0.5},
    "blind": {"signal": "weakened", "sensor_noise": 0.1, "sensor_cells": 2, "smoke": 0.3},
    "pushed": {
        "pushes": (
            0.55,
            0.3,
            0.0,
            1.0,
            0.55,
            -0.9,
            0.4,
            0.0,
            2.0,
            0.0,
            5.0,
            -2.0,
            3.0,
            0.0,
            0.0,
            3.0,
        ),
        "push_places": (0.45, 0.35, 0.05, 0.03, 0.2, 0.65, 0.65, -0.31, 0.0, 0.0),
        "wall_friction": 0.2,
    },
    "drifting": {"drift": 0.2, "drift_heading": 2.0, "pushes": (1.0, 0.1, 0.1, 0.5)},
    "lured": {
        "decoys": (1.2, 0.4, 3.0, 0.2, 1.2, 0.5),
        "sensor_noise": 0.1,
        "signal": "weakened",
        "sensor_field": 3.0,
    },
}
GOALS = {
    "touch with a heading": {"heading": 1.2, "heading_tolerance": 0.9},
    "step": {"arrival": "step"},
    "step with a heading": {"arrival": "step", "heading": -2.9, "heading_tolerance": 1.5},
    "stop": {"arrival": "stop", "arrival_speed": 1.5, "arrival_turn_rate": 4.0},
    "stop at walls": {"arrival": "step", "contact": "stop"},
    "no contact": {"contact": "fail"},
}
WORLDS = {"cup": cup, "burning": burning, "trap": lambda: generate("trap", 3)}


def _points(run):
    return most_points(run.arena(), run.settings, STEPS)


def reference_run(run, recorded):
    """The same run in plain Python: robot, search, rows and path."""
    settings, scales = settings_of(run.settings)
    memory = np.array(run.controller.memory, np.float64)
    carriage = int(lib.wg_words_after_memory(run.settings))
    robot = lattice_state.new_robot(
        memory.size,
        run.events,
        run.settings.push_count,
        carriage=carriage,
        legs=int(lib.wg_most_legs(run.settings)),
    )
    room = lattice_state.new_room(memory.size, run.options.robot.beams, STEPS, carriage=carriage)
    rows = np.zeros((STEPS + 1 if recorded else 0, 6 + memory.size + carriage), np.int64)
    path = np.zeros((_points(run) if recorded else 0, 4), np.int64)
    act = ACTS[run.controller.act.name]
    with np.errstate(over="ignore"):
        lattice_episode.lattice_episode(
            arena_of(run.arena(), run.settings),
            settings,
            scales,
            act,
            memory,
            room,
            robot,
            rows,
            path,
        )
    return robot, room.search, rows, path


def core_run(run, recorded):
    """The same in the core."""
    episode = CoreEpisode(run.arena(), run.settings, Driver(run.controller, run.controller.memory))
    rows = np.zeros((STEPS + 1 if recorded else 0, 1 + episode.words), np.int64)
    path = np.zeros((_points(run) if recorded else 0, 4), np.int64)
    if recorded:
        rows[0, 1:] = episode.state_words()
        episode.record(rows[1:], path)
    episode.run_to_the_end()
    return episode, rows, path


def assert_the_same(run, *, recorded):
    robot, search, rows, path = reference_run(run, recorded)
    episode, own_rows, own_path = core_run(run, recorded)
    report = {name: int(getattr(episode.report, name)) % 2**64 for name in COUNTS}
    assert report == {
        name: int(count) % 2**64 for name, count in zip(COUNTS, robot.counts, strict=True)
    }
    assert [episode.report.path_length, episode.report.overlap] == robot.sums.tolist()
    assert (episode.state_words() == robot.state).all()
    assert (own_rows == rows).all() and (own_path == path).all()
    if run.settings.find_loop == lib.WG_SEEK_LOOP:
        logged = int(episode.report.steps) + (episode.report.ending in (lib.WG_LIMIT, lib.WG_LOOP))
        done = range(run.last_event_step + 1, logged)
        assert [int(episode.c.search.log[k]) for k in done] == [int(search.log[k]) for k in done]


def prepared(world, name, motion, robot, *, digest, task="target"):
    options = RunOptions(motion, STEPS, 0.1, 3, robot=RobotOptions(**robot), task=task)
    run = prepare(world, name, options)
    run.settings.steps = STEPS
    run.settings.digest = int(digest)
    run.settings.find_loop = run.search
    return run


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
@pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS)
def test_a_recorded_run_is_that_of_the_reference(world, robot, motion):
    assert_the_same(prepared(world(), "turn-random", motion, robot, digest=True), recorded=True)


def with_goal(world, **goal):
    """The world, with a larger target, so that more runs arrive, and another goal there."""
    return replace(world, target=replace(world.target, radius=4 * world.cell_size, **goal))


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("robot", ["plain", "heavy", "pushed"])
@pytest.mark.parametrize("goal", GOALS.values(), ids=GOALS)
def test_a_run_to_any_goal_is_that_of_the_reference(goal, robot, motion):
    for world in WORLDS.values():
        run = prepared(
            with_goal(world(), **goal), "turn-random", motion, ROBOTS[robot], digest=True
        )
        assert_the_same(run, recorded=True)


def test_the_runs_to_other_goals_arrive_loop_and_touch_walls():
    seen = set()
    for goal in GOALS.values():
        for world in WORLDS.values():
            for name in ("turn-random", "turn-left"):
                found = with_goal(world(), **goal)
                seen.add(
                    (goal.get("arrival"), simulate(found, name, steps=STEPS, time_step=0.1).verdict)
                )
    assert {(None, "contact"), (None, "reached"), ("step", "reached"), ("stop", "reached")} <= seen


WAYPOINTS = {
    "touch": {},
    "touch with a heading": {"heading": 1.2, "heading_tolerance": 1.5},
    "step": {"arrival": "step"},
    "stop": {"arrival": "stop", "arrival_speed": 1.5, "arrival_turn_rate": 4.0},
}


def with_waypoints(world, **goal):
    """The world, with three large waypoints around its start, so that runs pass some of them."""
    side = world.cell_size
    start = world.start
    places = ((2.0, 1.5), (-1.0, 2.0), (1.5, -1.0))
    width, height = world.width * side, world.height * side
    goals = tuple(
        Target(
            min(max(start.x + dx * side, 0.0), width),
            min(max(start.y + dy * side, 0.0), height),
            2.5 * side,
            **goal,
        )
        for dx, dy in places
    )
    return replace(world, robots=(replace(world.robots[0], waypoints=goals),), certificate=None)


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("robot", ["plain", "heavy", "pushed", "lured"])
@pytest.mark.parametrize("goal", WAYPOINTS.values(), ids=WAYPOINTS)
def test_a_run_through_waypoints_is_that_of_the_reference(goal, robot, motion):
    for world in WORLDS.values():
        run = prepared(
            with_waypoints(world(), **goal), "turn-random", motion, ROBOTS[robot], digest=True
        )
        assert_the_same(run, recorded=True)


def test_the_runs_through_waypoints_pass_some_and_arrive():
    passed = set()
    for goal in WAYPOINTS.values():
        for world in WORLDS.values():
            run = prepared(with_waypoints(world(), **goal), "turn-random", "swept", {}, digest=True)
            episode, rows, _ = core_run(run, recorded=True)
            passed.add(int(episode.report.goals))
            assert rows[int(episode.report.steps), -1] == min(int(episode.report.goals), 3)
    assert passed >= {2, 3}, passed


BODIES = {
    "rectangle": Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 0.1), footprint=box(0.12, 0.08, 0.01)),
    "fails at contact": Robot(
        Pose(0.0, 0.0), Target(0.0, 0.0, 0.1, contact="fail"), footprint=box(0.1, 0.1)
    ),
    "axle outside": Robot(
        Pose(0.0, 0.0),
        Target(0.0, 0.0, 0.1),
        footprint=((0.02, -0.03), (0.08, -0.03), (0.05, 0.04)),
    ),
    "car": Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 0.1), drive=Drive(0.15, True)),
    "long car": Robot(
        Pose(0.0, 0.0),
        Target(0.0, 0.0, 0.1),
        footprint=box(0.14, 0.06, 0.04),
        drive=Drive(0.2, steering_rate=3.0),
    ),
}


# In plain Python, every heading of a turn is tested, which takes long. The first three pairs run in the default
# tier, and with the gate each kind of robot and each world has run; the night runs all pairs.
_FIRST = [("cup", "plain"), ("cup", "pushed"), ("burning", "drifting")]
_GATE = [("trap", "slippery"), ("cup", "heavy"), ("burning", "blind"), ("cup", "lured")]
_PAIRS = [
    *_FIRST,
    *(pytest.param(*pair, marks=pytest.mark.gate) for pair in _GATE),
    *(
        pytest.param(world, robot, marks=pytest.mark.nightly)
        for world in WORLDS
        for robot in ROBOTS
        if (world, robot) not in {*_FIRST, *_GATE}
    ),
]


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(("world", "robot"), _PAIRS)
def test_a_run_of_a_body_or_a_car_is_that_of_the_reference(world, robot, body, motion):
    before = WORLDS[world]()
    own = BODIES[body]
    target = replace(before.target, contact=own.target.contact)
    driver = replace(own, start=before.start, target=target, speed=before.robot_speed)
    after = replace(before, robots=(driver,), certificate=None)
    assert_the_same(
        prepared(after, "turn-random", motion, ROBOTS[robot], digest=True), recorded=True
    )


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("body", ["rectangle", "car"])
def test_a_body_through_waypoints_is_that_of_the_reference(body, motion):
    for goal in WAYPOINTS.values():
        before = with_waypoints(cup(), **goal)
        driver = replace(
            BODIES[body],
            start=before.start,
            target=before.target,
            speed=before.robot_speed,
            waypoints=before.robots[0].waypoints,
        )
        after = replace(before, robots=(driver,), certificate=None)
        assert_the_same(
            prepared(after, "turn-random", motion, ROBOTS["plain"], digest=True), recorded=True
        )


@pytest.mark.parametrize("digest", [True, False])
@pytest.mark.parametrize("world", [cup, lambda: generate("corridor", 2, size=10)])
def test_a_run_that_covers_is_that_of_the_reference(world, digest):
    run = prepared(world(), "turn-random", "swept", {}, digest=digest, task="cover")
    assert_the_same(run, recorded=digest)


@pytest.mark.parametrize("name", ["turn-left", "turn-random", "q-learning"])
def test_a_plain_run_is_that_of_the_reference(name):
    assert_the_same(prepared(cup(), name, "swept", {}, digest=False), recorded=False)


def test_a_state_of_many_words_has_the_fingerprints_of_the_reference():
    run = prepared(cup(), "three-layer", "swept", {}, digest=False)
    assert len(run.controller.memory) > 32
    assert_the_same(run, recorded=False)


# Memories (a, b) that differ for every n, while the fingerprints of the states are equal: n adds to
# one product what it subtracts from the other.
_A, _B = recurrence.FACTORS_OF_FEW[5:7]
_WHOLE = 2**64


def _unfolded(word):
    return word ^ (word >> 32)


def colliding(period):
    """Memory after each step of a controller that counts to a period."""
    return [
        np.array([_unfolded(n * _B % _WHOLE), _unfolded(-n * _A % _WHOLE)], np.uint64).view(
            np.float64
        )
        for n in range(period)
    ]


class Collides:
    """Counts to a period in a memory all of whose states have the same fingerprint."""

    senses = ("bump",)

    def __init__(self, period):
        self._memories = [tuple(memory.tolist()) for memory in colliding(period)]
        self._after = {
            np.array(memory).tobytes(): self._memories[(n + 1) % period]
            for n, memory in enumerate(self._memories)
        }

    def reset(self):
        return self._memories[0]

    def act(self, observation, memory):
        return (0.0, 0.0, False), self._after[np.array(memory).tobytes()]


@pytest.mark.parametrize("period", [7, 1_000])
def test_equal_fingerprints_of_different_states_invent_no_loop(period):
    run = prepare(cup(), Collides(period), RunOptions("swept", STEPS))
    claimed = run.run(STEPS, find_loop=True, record=False)
    assert (claimed.ending, claimed.period) == ("loop", 1)
    assert run.prove(claimed.entry, claimed.period, record=False) is None


def _counts(observation, memory, command):
    memory[0] = (memory[0] + 1.0) % memory[1]


@pytest.mark.gate
def test_a_claim_is_proved_only_where_the_state_comes_back():
    controller = CompiledController("counts", _counts, (0.0, 7.0), senses=("bump",))
    run = prepare(cup(), controller, RunOptions("swept", STEPS))
    assert run.prove(3, 7, record=False) is not None
    assert run.prove(3, 5, record=False) is None
