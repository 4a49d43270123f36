"""Gymnasium environments: the checker's requirements, the effect of seeds, refused arguments."""

import copy
import math
import pickle
import re
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import worldgen.gym
from sim import Command, RobotOptions, simulate
from tests.helpers.raising import raises
from tests.sim.test_batch import burning
from tests.sim.test_episode import arena
from worldgen import InvalidParameter, Pose, Target, World, generate, read_world, write_world
from worldgen.difficulty import measure
from worldgen.plugins.installation import pip_install
from worldgen.timeline import CellState, Event, Timeline
from worldgen_plugins.for_gymnasium import Interface, NavigateEnv, NavigateVectorEnv
from worldgen_plugins.for_gymnasium.interface import SENSORS
from worldgen_plugins.for_gymnasium.options import REWARD, Options

# Gymnasium's own checks call reset() without a seed.
pytestmark = pytest.mark.usefixtures("same_system_seed")
DOCS = Path(__file__).parents[2] / "docs"
GUIDE = (DOCS / "tutorials" / "train-a-policy.md").read_text(encoding="utf-8")
REFERENCE = (DOCS / "reference" / "environments.md").read_text(encoding="utf-8")
PLAIN = ("target_direction", "target_distance", "bump")
ALL = (
    *PLAIN,
    "bump_direction",
    "signal",
    "signal_direction",
    "heading",
    "position",
    "odometry",
    "goal_direction",
    "tilt",
    "beams",
)
TRAPS = {"family": "trap", "params": {"size": 16}, "pool": 5, "sensors": PLAIN}


def make(**options):
    return gymnasium.make(worldgen.gym.ENVIRONMENT, **options)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"actions": "discrete", "distance": "way"},
        {
            "reverse": True,
            "sensors": ALL,
            "observation": "dict",
            "robot": {"sensor_noise": 0.5, "slip": 0.2},
        },
    ],
    ids=["usual", "discrete", "dict"],
)
def test_the_checker_has_nothing_to_say(options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make(pool=3, **options).unwrapped)


@pytest.mark.gate
def test_the_name_alone_finds_the_module():
    code = (
        "import gymnasium as g; "
        "print(g.make('worldgen.gym:worldgen/Navigate-v0').spec.max_episode_steps)"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.stdout + done.stderr == "1000\n"


def test_registering_imports_no_simulator():
    code = (
        "import worldgen.gym, sys; print(sorted({'numba', 'sim', 'fuzz', 'worldgen_plugins'} & "
        "set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout + done.stderr == "[]\n"


def test_without_gymnasium_the_import_says_how_to_get_it():
    code = "import sys; sys.modules['gymnasium'] = None; import worldgen.gym"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr.endswith(f"which is not installed; {pip_install('gym')}\n")


@pytest.mark.gate
@pytest.mark.parametrize(
    "block", [0, 2, 3, 4, 5], ids=["single", "options", "vector", "fleet", "policy"]
)
def test_an_example_of_the_guide_works(block):
    names = {"gymnasium": gymnasium, "best_action": lambda seen: 0}
    exec(re.findall(r"```python\n(.*?)```", GUIDE, re.DOTALL)[block], names)
    if "Policy" in names:
        assert simulate(generate("trap", seed=1), names["Policy"](), steps=50).steps == 50


def test_the_reference_names_every_option_and_sensor():
    assert all(
        f"`{name}`" in REFERENCE or f"`{name}=" in REFERENCE
        for name in (*Options.__annotations__, *SENSORS, *REWARD)
    )


def played(env, seed, steps=150):
    env.action_space.seed(0 if seed is None else seed)
    told = [env.reset(seed=seed)]
    for _ in range(steps):
        told.append(env.step(env.action_space.sample()))
        if told[-1][2] or told[-1][3]:
            told.append(env.reset())
    return [
        [part.tobytes() if isinstance(part, np.ndarray) else part for part in one] for one in told
    ]


def test_seeds_decide_worlds_and_states_to_the_bit():
    options = {**TRAPS, "robot": {"slip": 0.3}, "max_episode_steps": 40}
    assert played(make(**options), 7) == played(make(**options), 7)
    assert played(make(**options), 7) != played(make(**options), 8)


def test_episodes_are_in_different_worlds_of_the_pool():
    env = make(**TRAPS)
    told = [env.reset(seed=3 if k == 0 else None)[1]["world"] for k in range(40)]
    assert set(told) == {0, 1, 2, 3, 4}
    assert env.unwrapped.world == generate("trap", seed=told[-1], size=16)


@pytest.mark.parametrize(
    "copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))], ids=["deep", "pickle"]
)
def test_a_copy_goes_on_as_the_first(copied):
    env = make(**TRAPS, robot={"slip": 0.3})
    env.reset(seed=3)
    env.step(np.ones(2, np.float32))
    assert played(copied(env), None) == played(env, None)


def assert_same(one, other):
    assert type(one) is type(other)
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one:
            assert_same(one[name], other[name])
    elif one.dtype == object:
        for left, right in zip(one, other, strict=True):
            assert (left is None and right is None) or left.tobytes() == right.tobytes()
    else:
        assert one.dtype == other.dtype and one.tobytes() == other.tobytes()


def files(tmp_path):
    """Worlds of different sizes, one that burns, and one in which the robot arrives immediately."""
    there = World(np.zeros((5, 9), bool), Pose(0.25, 0.25, 0.0), Target(0.25, 0.2, 0.1))
    worlds = [
        generate("trap", seed=1, size=12),
        burning(),
        there,
        generate("maze", seed=2, size=14),
    ]
    for k, world in enumerate(worlds):
        write_world(world, tmp_path / f"{k}.grid")
    return str(tmp_path)


@pytest.mark.gate
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("actions", ["continuous", "discrete"])
def test_the_vector_environment_is_the_single_ones_to_the_bit(mode, actions, tmp_path):
    common = {
        "worlds": files(tmp_path),
        "sensors": ALL,
        "robot": {"odometry_noise": 0.1},
        "actions": actions,
    }
    name, common = worldgen.gym.ENVIRONMENT, {**common, "max_episode_steps": 60}
    ours = gymnasium.make_vec(name, 6, "vector_entry_point", autoreset_mode=mode, **common)
    theirs = gymnasium.make_vec(name, 6, "sync", vector_kwargs={"autoreset_mode": mode}, **common)
    assert ours.metadata["autoreset_mode"] is theirs.metadata["autoreset_mode"] is mode
    assert (
        ours.observation_space == theirs.observation_space
        and ours.action_space == theirs.action_space
    )
    ours.action_space.seed(5)
    for one, other in zip(ours.reset(seed=11), theirs.reset(seed=11), strict=True):
        assert_same(one, other)
    for _ in range(400):
        actions = ours.action_space.sample()
        for one, other in zip(ours.step(actions), theirs.step(actions), strict=True):
            assert_same(one, other)


def test_the_next_step_is_the_usual_mode_and_a_thousand_steps_the_usual_limit():
    env = gymnasium.make_vec(
        worldgen.gym.ENVIRONMENT, 3, "vector_entry_point", world=arena(), sensors=PLAIN
    )
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    env.reset(seed=1)
    stand = np.zeros((3, 2), np.float32)
    over = [env.step(stand)[3].all() for _ in range(1001)]
    assert over == [False] * 999 + [True, False]


def test_minus_one_is_no_limit_as_in_make():
    env = gymnasium.make_vec(
        worldgen.gym.ENVIRONMENT, 2, "vector_entry_point", max_episode_steps=-1, **TRAPS
    )
    env.reset(seed=1)
    assert not any(env.step(np.zeros((2, 2), np.float32))[3].any() for _ in range(1100))


def test_without_autoreset_a_mask_says_who_begins_again():
    env = NavigateVectorEnv(3, max_episode_steps=2, autoreset_mode="Disabled", **TRAPS)
    first, _ = env.reset(seed=4)
    ahead = np.ones((3, 2), np.float32)
    env.step(ahead)
    last = env.step(ahead)[0]
    with pytest.raises(gymnasium.error.ResetNeeded, match="the episode of robot 0 is over"):
        env.step(ahead)
    again, told = env.reset(
        seed=[4, None, 9], options={"reset_mask": np.array([True, False, True])}
    )
    assert (
        (again[0] == first[0]).all()
        and (again[1] == last[1]).all()
        and told["_world"].tolist() == [1, 0, 1]
    )


def test_what_is_returned_is_not_changed_later():
    env = NavigateVectorEnv(4, **TRAPS)
    env.reset(seed=0)
    told = [env.step(env.action_space.sample()) for _ in range(3)]
    kept = [[part.copy() for part in one[:4]] for one in told]
    told[-1][0][:] = 7.0
    env.step(env.action_space.sample())
    assert all(
        (a == b).all()
        for one, two in zip(told[:-1], kept, strict=False)
        for a, b in zip(one, two, strict=False)
    )


@pytest.mark.parametrize(
    "form", [lambda path: path, str, read_world], ids=["path", "text", "world"]
)
def test_a_reset_takes_another_world_or_file_and_keeps_it(form, tmp_path):
    env, other = make(**TRAPS).unwrapped, arena()
    write_world(other, tmp_path / "w.grid")
    env.reset(seed=1)
    assert env.world != other
    env.reset(options={"world": form(tmp_path / "w.grid")})
    env.reset()
    assert env.world == other
    env.reset(options={"family": "trap", "params": {"size": 16}})
    assert env.world.provenance.family == "trap"


@pytest.mark.parametrize("options", [{"world": arena()}, TRAPS], ids=["world", "family"])
def test_a_reset_option_that_is_none_says_nothing(options):
    env = NavigateEnv(**{**options, "sensors": PLAIN})
    env.reset(seed=1)
    before = env.world
    env.reset(
        seed=1,
        options={"world": None, "worlds": None, "family": None, "difficulty": None, "pool": None},
    )
    assert env.world == before


@pytest.mark.gate
def test_a_curriculum_asks_for_harder_worlds():
    env = NavigateEnv(
        family="trap", params={"size": 20}, difficulty=(0.1, 0.3), pool=2, sensors=PLAIN
    )
    for low, high in ((0.1, 0.3), (0.5, 0.9)):
        env.reset(seed=1, options={"difficulty": (low, high)})
        assert low <= measure(env.world).difficulty <= high


def test_the_reward_is_what_the_document_says():
    reward = {"progress": 3.0, "time": -0.5, "contact": -2.0, "reached": 10.0}
    env = NavigateEnv(
        world=arena(), sensors=("target_distance", "bump"), extent=100.0, reward=reward
    )
    far = env.reset(seed=0)[0][0] * 100.0
    for _ in range(40):
        (near, bump), got, *_ = env.step(np.array([0.0, 1.0], np.float32))
        assert got == pytest.approx(3.0 * (far - near * 100.0) - 0.5 * 0.015 - 2.0 * bump, abs=1e-4)
        far = near * 100.0
    assert bump == 1.0


def test_arriving_and_burning_end_an_episode():
    env = NavigateEnv(
        world=World(np.zeros((9, 20), bool), Pose(0.45, 0.45, 0.0), Target(1.2, 0.45, 0.1))
    )
    env.reset(seed=0)
    told = [env.step(np.array([0.0, 1.0], np.float32)) for _ in range(25)]
    end = next(k for k, one in enumerate(told) if one[2])
    assert (
        told[end][4] == {"is_success": True}
        and told[end][1] > 1.0
        and not told[end - 1][4]["is_success"]
    )
    fire = Timeline.of([Event(0.1, 3, 3, CellState.BURNING)])
    env = NavigateEnv(world=replace(arena(), timeline=fire), reward={"burned": -50.0})
    env.reset(seed=0)
    told = [env.step(np.zeros(2, np.float32)) for _ in range(6)]
    assert [one[2] for one in told] == [False] * 5 + [True]
    assert told[5][1] < -49.0 and told[5][4] == {"is_success": False}


class GoesAndTurns:
    """A controller that drives to the target, and takes up the heading that the goal asks for."""

    senses = ("target_distance", "target_heading", "heading", "goal_heading", "time_step")

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        is_there = memory[0] > 0.0 or observation.target_distance < 0.03
        aim = observation.goal_heading if is_there else observation.target_heading
        turn = math.remainder(aim - observation.heading, math.tau) / observation.time_step
        return Command(0.0 if is_there else 0.5, max(-9.0, min(9.0, turn))), (float(is_there),)


@pytest.mark.parametrize("arrival", ["touch", "step", "stop"])
def test_an_episode_ends_when_its_robot_arrives_as_the_goal_asks(arrival):
    goal = Target(1.2, 0.45, 0.1, heading=-2.0, heading_tolerance=0.05, arrival=arrival)
    world = World(np.zeros((9, 20), bool), Pose(0.45, 0.45, 0.0), goal)
    run = simulate(world, GoesAndTurns(), steps=900, record=True)
    assert run.verdict == "reached"
    # The commands of its steps, as actions.
    turns = np.angle(np.exp(1j * np.diff(run.trace.heading))) / 0.015 / 10.0
    speeds = run.trace.states[1:, 3].view(np.int64) / (65536 * 1024) * 0.1 / 0.015 / 2.0
    env = NavigateEnv(world=world, sensors=("goal_direction",), turn_rate=10.0)
    seen, _ = env.reset(seed=3)
    for k in range(run.steps):
        off = -2.0 - run.trace.heading[k]
        assert seen == pytest.approx((math.cos(off), math.sin(off)), abs=1e-3)
        seen, _, over, _, told = env.step(np.array([turns[k], speeds[k]], np.float32))
        if over:
            break
    # A step's end shows after the action that led there, and a stop after the action itself.
    assert told["is_success"] and k + 1 == (run.steps if arrival == "stop" else run.steps - 1)


@pytest.mark.parametrize("distance", ["straight", "way"])
def test_a_tour_is_rewarded_for_its_progress_through_its_waypoints(distance):
    world = World(np.zeros((9, 40), bool), Pose(0.45, 0.45, 0.0), Target(0.45, 0.45, 0.1))
    waypoints = (Target(2.45, 0.45, 0.1), Target(1.45, 0.45, 0.1))
    world = replace(world, robots=[replace(world.robots[0], waypoints=waypoints)])
    reward = dict.fromkeys(("time", "contact", "reached", "burned"), 0.0)
    env = NavigateEnv(
        world=world, sensors=("target_distance",), turn_rate=400.0, distance=distance, reward=reward
    )
    first, _ = env.reset(seed=1)
    assert first[0] == pytest.approx(0.2, abs=1e-3)
    # Ahead to the first, and back through the second to the target.
    total, last, over, turn = 0.0, 0.0, False, 0.0
    while not over:
        _, gained, over, _, told = env.step(np.array([turn, 1.0], np.float32))
        assert gained > -1e-4
        total += gained
        passed = env.unwrapped._lockstep.crew.passed[0]
        turn = math.pi / 0.015 / 400.0 if passed == 1 and last == 0 else 0.0
        last = passed
    assert told["is_success"] and total == pytest.approx(4.0 - 0.1, abs=0.05)


def test_a_tilted_floor_is_sensed_relative_to_the_robot():
    world = World(np.zeros((9, 20), bool), Pose(0.45, 0.45, 0.5), Target(1.2, 0.45, 0.1))
    tilted = {"drift": 0.5, "drift_heading": 1.5}
    for env in (
        NavigateEnv(world=world, sensors=("tilt",), robot=tilted),
        NavigateVectorEnv(worlds=[world], num_envs=1, sensors=("tilt",), robot=tilted),
    ):
        seen = np.ravel(env.reset(seed=1)[0])
        share = 0.5 / world.robot_speed
        assert seen == pytest.approx((share * math.cos(1.0), share * math.sin(1.0)), abs=5e-3)


def test_each_robot_senses_the_heading_of_its_own_goal():
    headings = (None, 0.5, 2.0)
    goals = [Target(1.2, 0.45, 0.1, heading=heading) for heading in headings]
    worlds = [World(np.zeros((9, 20), bool), Pose(0.45, 0.45, 0.0), goal) for goal in goals]
    envs = NavigateVectorEnv(worlds=worlds, num_envs=8, sensors=("goal_direction", "bump"))
    seen, told = envs.reset(seed=1)
    assert set(told["world"].tolist()) == {0, 1, 2}
    for row, number in zip(seen, told["world"], strict=True):
        heading = headings[int(number)]
        expected = (0.0, 0.0) if heading is None else (math.cos(heading), math.sin(heading))
        assert row[:2] == pytest.approx(expected, abs=1e-3)


def test_a_wall_that_may_not_be_touched_ends_an_episode():
    goal = Target(0.25, 0.45, 0.1, contact="fail")
    env = NavigateEnv(world=World(np.zeros((9, 20), bool), Pose(1.45, 0.45, 0.0), goal))
    env.reset(seed=0)
    told = [env.step(np.array([0.0, 1.0], np.float32)) for _ in range(25)]
    end = next(k for k, one in enumerate(told) if one[2])
    assert end > 3 and told[end][4] == {"is_success": False}


def test_the_shortest_way_leads_round_the_walls():
    walls = np.zeros((20, 30), bool)
    walls[:16, 15] = True
    world = World(walls, Pose(1.2, 0.3, 0.0), Target(2.0, 0.3, 0.1))
    away = {}
    for distance in ("straight", "way"):
        env = NavigateEnv(world=world, distance=distance, sensors=PLAIN)
        env.reset(seed=0)
        away[distance] = float(env._lockstep.crew.distance[0])
    assert away["straight"] == pytest.approx(0.8) and 2.8 < away["way"] < 3.2


@pytest.mark.parametrize("render_mode", ["rgb_array", "ansi"])
def test_frames_show_the_way_so_far(render_mode):
    env = gymnasium.make_vec(
        worldgen.gym.ENVIRONMENT,
        2,
        "vector_entry_point",
        world=arena(),
        sensors=PLAIN,
        render_mode=render_mode,
    )
    single = make(world=arena(), sensors=PLAIN, render_mode=render_mode)
    env.reset(seed=0)
    single.reset(seed=0)
    before = single.render()
    for _ in range(30):
        env.step(np.tile(np.array([0.0, 1.0], np.float32), (2, 1)))
        single.step(np.array([0.0, 1.0], np.float32))
    assert not np.array_equal(before, single.render())
    assert all(np.array_equal(frame, single.render()) for frame in env.render())


def test_a_policy_as_a_controller_sees_and_does_what_the_environment_does():
    own = Interface(
        sensors=ALL,
        turn_rate=9.0,
        reverse=True,
        extent=3.0,
        robot=RobotOptions(beams=7, beam_noise=0.1),
    )

    class Policy:
        senses, needs, seen = own.senses, own.needs, []

        def reset(self):
            return ()

        def act(self, observation, memory):
            self.seen.append(own.observe(observation))
            return own.command(turns(self.seen[-1]), observation), memory

    world = generate("trap", seed=1)
    env = NavigateEnv(
        world=world,
        sensors=ALL,
        turn_rate=9.0,
        reverse=True,
        extent=3.0,
        robot={**own.needs.changed()},
    )
    seen, told = env.reset(seed=2)
    simulate(world, Policy(), steps=101, seed=told["run_seed"], time_step=0.015)
    for other in Policy.seen[:100]:
        assert seen.tobytes() == other.tobytes()
        seen = env.step(turns(seen))[0]


def turns(seen):
    return np.array(
        [np.clip(3.0 * seen[1] - 0.7 * seen[3], -1, 1), 0.9 - 1.2 * seen[3]], np.float32
    )


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (
            {"sensor": ()},
            {"code": "unknown-name", "name": "sensor", "noun": "option", "near": "sensors"},
        ),
        ({"sensors": ("radar",)}, {"code": "unknown-name", "name": "radar"}),
        ({"sensors": "bump"}, {"code": "wrong-type"}),
        ({"sensors": ("bump", "bump")}, {"code": "twice"}),
        ({"actions": "both"}, {"code": "unknown-name"}),
        ({"actions": "discrete", "reverse": True}, {"code": "conflict"}),
        ({"observation": "flat"}, {"code": "unknown-name"}),
        ({"distance": "air"}, {"code": "unknown-name"}),
        ({"turn_rate": 0}, {"code": "out-of-range", "name": "turn_rate"}),
        ({"extent": np.nan}, {"code": "out-of-range", "name": "extent"}),
        ({"robot": 3}, {"code": "wrong-type", "given": "3"}),
        ({"robot": {"wings": 2}}, {"code": "unknown-name", "name": "wings"}),
        ({"time_step": 0.0}, {"code": "out-of-range", "low": 0.001, "high": 10}),
        (
            {"reward": {"joy": 1}},
            {"code": "unknown-name", "name": "joy", "noun": "part of the reward"},
        ),
        ({"reward": {"time": np.nan}}, {"code": "not-a-number", "name": "time"}),
        ({"family": "labyrinth"}, {"code": "unknown-name", "name": "labyrinth"}),
        ({"family": "maze", "world": arena()}, {"code": "conflict", "named": "world and family"}),
        (
            {"world": arena(), "pool": 3},
            {"code": "conflict", "only_for_family": "pool", "named": "world"},
        ),
        ({"world": 3}, {"code": "wrong-type", "given": "3"}),
        ({"worlds": []}, {"code": "wrong-type"}),
        ({"pool": 0}, {"code": "out-of-range", "name": "pool", "low": 1, "high": 1000000}),
        ({"params": 3}, {"code": "wrong-type", "given": "3"}),
        ({"difficulty": (0.6, 0.2)}, {"code": "out-of-range"}),
        ({"difficulty": 0.5}, {"code": "out-of-range"}),
        ({"render_mode": "human"}, {"code": "unknown-name", "render_mode": "human"}),
    ],
    ids=str,
)
def test_options_that_mean_nothing_are_refused_in_a_sentence(options, expected):
    with raises(InvalidParameter, **expected):
        NavigateEnv(**options)


def test_changing_worlds_have_no_shortest_way():
    with raises(InvalidParameter, "world-changes"):
        NavigateEnv(world=burning(), distance="way").reset()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"num_envs": 0}, {"code": "out-of-range", "name": "num_envs", "low": 1}),
        ({"autoreset_mode": "Never"}, {"code": "unknown-name"}),
        (
            {"max_episode_steps": 2.5},
            {"code": "not-a-whole-number", "name": "max_episode_steps", "value": "2.5"},
        ),
    ],
    ids=str,
)
def test_options_of_the_vector_environment_are_checked_likewise(options, expected):
    with raises(InvalidParameter, **expected):
        NavigateVectorEnv(**options)


@pytest.mark.parametrize(
    ("action", "expected"),
    [
        (np.array([np.nan, 0.0]), {"code": "not-finite"}),
        (np.zeros(3), {"code": "wrong-shape", "count": 1}),
        (np.array(["a", "b"]), {"code": "wrong-shape", "dtype": "<U1"}),
    ],
    ids=str,
)
def test_actions_that_are_none_are_refused(action, expected):
    env = NavigateEnv(world=arena(), sensors=PLAIN)
    with pytest.raises(gymnasium.error.ResetNeeded, match="call reset"):
        env.step(action)
    env.reset(seed=0)
    with raises(InvalidParameter, **expected):
        env.step(action)


@pytest.mark.parametrize(
    ("action", "expected"),
    [
        (5, {"code": "out-of-range", "last": 4}),
        (-1, {"code": "out-of-range", "last": 4}),
        (0.5, {"code": "wrong-shape", "dtype": "float64"}),
    ],
)
def test_discrete_actions_that_are_none_are_refused(action, expected):
    env = NavigateEnv(world=arena(), sensors=PLAIN, actions="discrete")
    env.reset(seed=0)
    with raises(InvalidParameter, **expected):
        env.step(action)


def test_resets_that_mean_nothing_are_refused():
    env = NavigateVectorEnv(2, **TRAPS)
    with raises(InvalidParameter, "unknown-name", name="word", noun="reset option", near="world"):
        env.reset(options={"word": arena()})
    mask = np.array([True, False])
    with raises(InvalidParameter, "conflict"):
        env.reset(options={"reset_mask": mask})
    env.reset(seed=0)
    with raises(InvalidParameter, "conflict"):
        env.reset(options={"world": arena(), "reset_mask": mask})
    with raises(InvalidParameter, "wrong-shape", count=2):
        env.reset(options={"reset_mask": ~(mask | True)})
    with raises(InvalidParameter, "wrong-count", count=2):
        env.reset(seed=[1])
