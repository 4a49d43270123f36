"""Runs from Python: verdicts, evidence, determinism, bad controllers."""

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from sim import Command, CompiledController, Observation, RunOptions, simulate, simulate_many
from sim.episode import prepare
from sim.episode.describe import describe_evidence
from tests.helpers.raising import raises
from tests.reference.sim import layout
from worldgen import (
    CellState,
    Event,
    InvalidParameter,
    InvalidWorld,
    Pose,
    Target,
    Timeline,
    World,
    generate,
)

TURN_RATE = 512 / 65536 * 2 * math.pi / 0.015  # rad/s: 512 heading units a step, 128 steps a turn


def arena(side=12, start=(0.35, 0.35, 0.0), target=(0.85, 0.85), walls=()):
    cells = np.zeros((side, side), bool)
    cells[[0, -1], :] = cells[:, [0, -1]] = True
    for iy, ix in walls:
        cells[iy, ix] = True
    return World(cells, Pose(*start), Target(*target, 0.05))


class GoToTarget:
    """Turns to the target and drives."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        turn = observation.target_heading - observation.heading
        turn = (turn + math.pi) % (2 * math.pi) - math.pi
        return Command(observation.top_speed, turn / observation.time_step), memory


class Circle:
    """Drives in a circle forever."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(0.5, TURN_RATE), memory


def cup():
    return arena(16, (0.75, 0.35, math.pi / 2), (0.75, 1.35), [(8, x) for x in range(3, 13)])


def test_a_robot_that_goes_to_the_target_reaches_it():
    episode = simulate(arena(), GoToTarget())
    assert (episode.verdict, episode.collisions) == ("reached", 0)


def test_the_path_of_a_straight_run_is_as_long_as_the_way():
    episode = simulate(arena(start=(0.25, 0.25, 0.0), target=(0.85, 0.25)), GoToTarget())
    assert episode.path_length == pytest.approx(0.6, abs=0.06)


def test_an_endless_circle_is_a_proved_loop():
    episode = simulate(arena(), Circle(), record=True)
    entry, period = episode.evidence.entry, episode.evidence.period
    states = episode.trace.states
    assert episode.verdict == "loop" and np.array_equal(states[entry], states[entry + period])


def test_the_loop_entry_is_the_first_repeated_state():
    episode = simulate(arena(), Circle(), record=True)
    entry, period = episode.evidence.entry, episode.evidence.period
    assert entry == 0 or not np.array_equal(
        episode.trace.states[entry - 1], episode.trace.states[entry + period - 1]
    )


def test_a_loop_that_is_too_long_to_be_recorded_is_not_proved_and_no_error(monkeypatch):
    proved = simulate(arena(), Circle(), steps=3000)
    monkeypatch.setattr("sim.runners.lattice.MAX_RECORDED", proved.evidence.period)
    assert (proved.verdict, simulate(arena(), Circle(), steps=3000).verdict) == ("loop", "stalled")


def test_a_controller_that_hides_memory_is_never_called_a_loop():
    class Hidden(Circle):
        def __init__(self):
            self.count = 0

        def act(self, observation, memory):
            self.count += 1
            return super().act(observation, memory)

    episode = simulate(arena(), Hidden(), steps=3000)
    assert (episode.verdict, episode.steps) == ("stalled", 3000)


class Counter:
    """Counts."""

    def __init__(self):
        self.count = 0


class Waits(Circle):
    """Waits for 200 steps without recording that in its memory, then drives to the target."""

    def __init__(self):
        self.counter = Counter()

    def act(self, observation, memory):
        self.counter.count += 1
        return (
            GoToTarget().act(observation, memory)
            if self.counter.count > 200
            else (Command(), memory)
        )


def test_memory_hidden_in_a_nested_object_is_no_proof_of_a_loop():
    assert simulate(arena(), Waits(), steps=3000).verdict != "loop"


def test_a_compiled_controller_that_writes_beyond_its_memory_crashes():
    def act(observation, memory, command):
        memory[0] += 1.0

    assert simulate(arena(), CompiledController("oob", act)).verdict == "crash"


def test_no_robot_outruns_its_top_speed():
    world = replace(arena(40, (0.35, 0.35, 0.0), (3.65, 0.35)), robot_speed=0.01)
    episode = simulate(world, GoToTarget(), steps=500)
    assert episode.path_length <= 0.01 * episode.time + 1e-9


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("controller", ["turn-left", "turn-right"])
def test_the_thesis_robots_are_trapped_in_front_of_a_long_wall(controller, motion):
    assert simulate(cup(), controller, motion=motion, steps=20_000).verdict == "loop"


def test_equal_seeds_give_equal_digests_and_other_seeds_do_not():
    digests = [
        simulate(cup(), "turn-random", steps=3000, seed=seed).trace_digest for seed in (1, 1, 2)
    ]
    assert digests[0] == digests[1] != digests[2]


def test_a_digest_is_pinned_so_that_every_machine_gives_the_same():
    episode = simulate(cup(), "turn-right", steps=20_000)
    assert (episode.steps, episode.trace_digest) == PINNED


def test_the_recorded_words_give_the_digest_again():
    episode = simulate(cup(), "turn-left", record=True)
    assert episode.trace.digest() == episode.trace_digest


def test_a_compiled_and_a_python_controller_drive_the_same_way():
    def act(observation, memory, command):
        command[0] = 0.5
        command[1] = TURN_RATE

    one = simulate(arena(), CompiledController("circle", act, (0.0,)), record=True)
    two = simulate(arena(), Circle(), record=True)
    assert one.trace_digest == two.trace_digest


def test_a_fast_robot_tunnels_under_endpoint_and_not_under_swept():
    world = arena(24, (0.5, 1.15, 0.0), (2.05, 1.15), [(y, 12) for y in range(24)])
    verdicts = {
        m: simulate(world, GoToTarget(), motion=m, time_step=0.15).verdict
        for m in ("endpoint", "swept")
    }
    assert verdicts["endpoint"] == "tunnel" and verdicts["swept"] in ("loop", "stalled")


def test_fire_that_reaches_the_robot_burns_it():
    timeline = Timeline.of([Event(0.3, 7, 3, CellState.BURNING)])
    episode = simulate(replace(arena(start=(0.35, 0.35, 0.0)), timeline=timeline), Straight())
    assert (episode.verdict, episode.evidence.state) == ("burned", "burning")


def test_debris_that_falls_on_the_robot_is_told_from_fire():
    timeline = Timeline.of([Event(0.03, 3, 3, CellState.SOLID)])
    episode = simulate(replace(arena(), timeline=timeline), Circle())
    assert (episode.verdict, episode.evidence.state) == ("burned", "solid")


def test_a_loop_is_not_claimed_before_the_last_event():
    timeline = Timeline.of([Event(30.0, 9, 9, CellState.SOLID)])
    episode = simulate(replace(arena(), timeline=timeline), Circle())
    assert episode.verdict == "loop" and episode.evidence.entry * 0.015 >= 29.9


class Straight:
    """Drives ahead."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(1.0, 0.0), memory


class Faulty:
    """Raises an exception after a while."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        raise RuntimeError("no idea")


class Nonsense(Straight):
    """Commands nan."""

    def act(self, observation, memory):
        return Command(math.nan, 0.0), memory


class Growing(Straight):
    """Grows its memory."""

    def act(self, observation, memory):
        return Command(), (*memory, 1.0)


class Quitting(Straight):
    """Leaves Python."""

    def act(self, observation, memory):
        raise SystemExit(7)


class Forgetful(Straight):
    """Has no initial memory."""

    def reset(self):
        return None


@pytest.mark.parametrize(
    ("controller", "verdict"),
    [
        (Faulty(), "crash"),
        (Growing(), "invalid-command"),
        (Quitting(), "crash"),
        (Forgetful(), "invalid-command"),
        (Nonsense(), "invalid-command"),
    ],
)
@pytest.mark.parametrize("record", [False, True])
def test_a_broken_controller_has_a_verdict_of_its_own(controller, verdict, record):
    assert simulate(arena(), controller, record=record).verdict == verdict


def test_a_crash_names_the_line_and_an_invalid_command_its_fault():
    quit_at = next(
        k
        for k, line in enumerate(Path(__file__).read_text().splitlines(), 1)
        if "SystemExit(7)" in line
    )
    assert simulate(arena(), Quitting()).evidence.at == f"test_episode.py:{quit_at}"
    assert "speed or turn rate is not a finite number in step 1" in describe_evidence(
        simulate(arena(), Nonsense())
    )


def test_what_a_controller_prints_leaves_stdout_alone(capsys):
    class Chatty(Straight):
        """Prints."""

        def act(self, observation, memory):
            print("hello")
            return super().act(observation, memory)

    simulate(arena(), Chatty(), steps=3)
    assert capsys.readouterr() == ("", "hello\n" * 3)


def test_a_start_inside_a_wall_is_refused_with_the_way_out():
    with raises(InvalidWorld, "start-in-wall"):
        simulate(arena(start=(0.05, 0.05, 0.0)), "turn-left")


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"motion": "swpet"}, {"code": "unknown-name", "name": "swpet", "near": "swept"}),
        ({"steps": 0}, {"code": "out-of-range", "name": "steps"}),
        ({"time_step": math.nan}, {"code": "not-finite", "name": "time_step"}),
        ({"seed": -1}, {"code": "out-of-range", "name": "seed", "value": -1}),
        ({"motion": "stepped"}, {"code": "motion-is-the-thesis-robots", "name": "stepped"}),
    ],
)
def test_bad_options_are_refused(settings, expected):
    with raises(InvalidParameter, **expected):
        simulate(arena(), GoToTarget(), RunOptions(**settings))


@pytest.mark.parametrize("motion", ["swept", "endpoint", "stepped"])
@pytest.mark.parametrize("speed", [1e4, 1e8])
def test_a_step_of_thousands_of_cells_is_refused(motion, speed):
    with raises(InvalidParameter, "step-too-long", most=1000):
        simulate(replace(arena(), robot_speed=speed), "turn-left", motion=motion)


def test_a_step_below_the_lattice_is_refused():
    with raises(InvalidParameter, "step-too-short", least="1/1024"):
        simulate(replace(arena(), robot_speed=1e-6), "turn-left")


@pytest.mark.parametrize("radius", [5.0, 2000.0])
def test_a_giant_robot_is_refused_at_once(radius):
    with raises(InvalidWorld, "start-in-wall"):
        simulate(replace(arena(), robot_radius=radius), "turn-left")


def test_an_endpoint_far_outside_the_grid_is_no_place_to_go():
    world = arena(24, (0.5, 1.15, 0.0), (2.05, 1.15), [(y, 12) for y in range(24)])
    episode = simulate(
        replace(world, robot_speed=600.0), GoToTarget(), motion="endpoint", record=True
    )
    assert (episode.trace.x < 2.4).all() and (episode.trace.y < 2.4).all()


def test_a_function_that_numba_cannot_compile_is_refused():
    def act(observation, memory, command):
        command[0] = {}.get("speed")

    with raises(InvalidParameter, "does-not-compile"):
        simulate(arena(), CompiledController("bad", act))


def test_without_numba_a_function_of_one_s_own_names_the_extra(monkeypatch):
    def act(observation, memory, command):
        command[0] = 1.0

    monkeypatch.setitem(sys.modules, "numba", None)
    with raises(InvalidParameter, "package-missing", function="act"):
        simulate(arena(), CompiledController("mine", act))


def test_what_numba_does_not_know_is_named():
    def act(observation, memory, command):
        command[0] = float(observation[0] > 1.0)

    with raises(InvalidParameter, "does-not-compile"):
        simulate(arena(), CompiledController("bad", act))


PINNED = (1500, "8bbf36a0d28ce3da")


@pytest.mark.nightly
def test_a_compiled_controller_sees_what_it_asks_for_and_nan_for_the_rest():
    def act(observation, memory, command):
        memory[:] = observation

    def seen(senses):
        controller = CompiledController("eyes", act, (0.0,) * layout.OBS_SIZE, senses=senses)
        return (
            simulate(arena(), controller, steps=1, record=True)
            .trace.states[1, layout.STATE_MEMORY :]
            .view(float)
        )

    everything, little = seen(Observation._fields), seen(("bump", "target_heading"))
    assert not np.isnan(everything).any()
    assert little[layout.OBS_TARGET_HEADING] == everything[layout.OBS_TARGET_HEADING]
    assert np.isnan(little[[layout.OBS_SIGNAL, layout.OBS_SIGNAL_HEADING, layout.OBS_RANDOM]]).all()


def test_a_sense_that_there_is_not_is_refused():
    with raises(InvalidParameter, "unknown-name", name="nose", sense="smell"):
        CompiledController("nose", lambda observation, memory, command: None, senses=("smell",))


@pytest.mark.parametrize("motion", ["swept", "stepped"])
def test_a_run_without_digest_is_the_same_run(motion):
    run = prepare(cup(), "turn-left", RunOptions(motion=motion))
    with_it, without = (
        run.run(3000, find_loop=True, record=False, digest=digest) for digest in (True, False)
    )
    assert replace(without, digest=with_it.digest) == with_it and without.digest != with_it.digest


@pytest.mark.gate
def test_a_loop_too_long_to_record_is_proved_all_the_same():
    def act(observation, memory, command):
        memory[0] = memory[0] + 1.0 if memory[0] < 4_500_000.0 else 8.0

    counter = CompiledController("counter", act, (0.0,), senses=("bump",))
    episode = simulate(arena(), counter, steps=20_000_000)
    assert (episode.verdict, episode.evidence.entry, episode.evidence.period) == (
        "loop",
        8,
        4_499_993,
    )
    with raises(InvalidParameter, "run-too-long", most=4_000_000):
        simulate(arena(), counter, steps=20_000_000, record=True)


def drive(observation, memory, command):
    command[layout.CMD_SPEED] = 1e9


@pytest.mark.parametrize("radius", [0.02, 0.03, 0.035, 0.05, 0.07, 0.14])
@pytest.mark.parametrize("degrees", [1, 4, 15])
def test_a_disc_that_touches_a_wall_at_a_shallow_angle_slides_on_for_the_rest_of_its_way(
    radius, degrees
):
    down = math.radians(degrees)
    for height in (0.0, 0.3, 0.7):
        start = Pose(0.6, radius + height * 0.03 * math.sin(down), -down)
        world = World(np.zeros((12, 12), bool), start, Target(0.1, 1.1, 0.01), robot_radius=radius)
        trace = simulate(
            world, CompiledController("go", drive, (), 1e9), steps=1, record=True
        ).trace
        assert trace.x[1] - trace.x[0] == pytest.approx(
            0.03 * math.cos(down), abs=4e-4
        )  # 4 lattice units


@pytest.mark.parametrize("radius", [0.05, 0.07, 0.1])
@pytest.mark.parametrize("cells", [3, 50, 200])
def test_along_floor_and_ceiling_a_disc_gets_as_far_as_the_wall_ahead(radius, cells):
    ends = []
    for y in (radius, 0.5 - radius):
        start = Pose(round(12 - min(cells * 0.08, 11.0) - radius, 3), y, 0.0)
        world = World(np.zeros((5, 120), bool), start, Target(0.3, 0.25, 0.01), robot_radius=radius)
        world = replace(world, robot_speed=cells * 0.1 / 0.015)
        trace = simulate(
            world, CompiledController("go", drive, (), 1e9), steps=1, record=True
        ).trace
        assert trace.x[1] == pytest.approx(12 - radius, abs=2e-4) and trace.bump[1]
        ends.append(trace.x[1])
    assert ends[0] == ends[1]


def test_a_cell_that_shuts_and_opens_again_stops_a_robot_of_any_speed():
    for speed in (2.0, 30.0):
        door = [Event(0.0, 11, 29, CellState.SOLID), Event(0.85, 11, 29, CellState.FREE)]
        world = replace(
            arena(60, (0.55, 2.95, 0.0), (5.45, 5.45)),
            timeline=Timeline.of(door),
            robot_speed=speed,
        )
        trace = simulate(
            world, CompiledController("go", drive, (), 1e9), steps=40, record=True
        ).trace
        assert trace.x.max() == pytest.approx(1.1 - 0.07, abs=1e-3)


@pytest.mark.gate
@pytest.mark.parametrize(
    "error",
    [
        RuntimeError,
        *(
            pytest.param(error, marks=pytest.mark.nightly)
            for error in (AssertionError, MemoryError)
        ),
    ],
)
def test_a_compiled_controller_may_raise_anything(error):
    def act(observation, memory, command):
        memory[0] += 1.0
        if memory[0] > 2.0:
            raise error("enough")

    raises = CompiledController("raises", act, (0.0,))
    assert simulate(arena(), raises).evidence.error == f"{error.__name__}: enough"
    assert simulate_many(arena(), raises, seeds=2).verdicts.tolist() == ["crash", "crash"]


def test_a_compiled_controller_that_draws_from_numpy_is_refused():
    def act(observation, memory, command):
        command[layout.CMD_SPEED] = np.random.random()

    with raises(InvalidParameter, "draws-outside-seed"):
        simulate(arena(), CompiledController("dice", act))


@pytest.mark.parametrize("late", [1e6, 1e9])
def test_events_may_be_far_apart(late):
    timeline = Timeline.of([Event(0.1, 8, 8, CellState.SOLID), Event(late, 8, 8, CellState.FREE)])
    assert simulate(replace(arena(), timeline=timeline), "turn-left", steps=50).steps == 50


def test_what_a_class_raises_is_told_in_one_line_of_bounded_length():
    class Shouts:
        def reset(self):
            return ()

        def act(self, observation, memory):
            raise GeneratorExit("no\n" * 10_000)

    error = simulate(arena(), Shouts()).evidence.error
    assert error.startswith("GeneratorExit: no no") and "\n" not in error and len(error) == 500


def _jot(observation, memory, command):
    """Drives ahead after counting five steps in which it senses nothing."""
    jotted = observation[layout.OBS_SIGNAL]
    observation[layout.OBS_SIGNAL] = 1.0 if math.isnan(jotted) else jotted + 1.0
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED] if jotted > 5.0 else 0.0


def test_an_observation_is_no_memory():
    jot = CompiledController("jot", _jot, senses=("top_speed",))
    run = prepare(arena(), jot, RunOptions())
    assert (
        run.run(100, find_loop=False, record=False).path_length == 0.0
    )  # its counter would make a reported loop wrong


class Follower:
    """Plans a path of two points in ``reset``, around the wall of ``planned_world``, and follows
    it.
    """

    def reset(self, world):
        assert world.certificate is None and world.provenance is None and world.failure is None
        top = 0.5 + float(np.argmin(world.walls[:, 10])) * world.cell_size
        return (1.05, top, world.target.x, world.target.y, 0.0)

    def act(self, observation, memory):
        goal = 2 * int(memory[4])
        x, y = memory[goal] - observation.x, memory[goal + 1] - observation.y
        reached = memory[4] == 0.0 and math.hypot(x, y) < 0.1
        turn = math.remainder(math.atan2(y, x) - observation.heading, 2.0 * math.pi)
        speed = 1.0 if abs(turn) < 0.2 else 0.0
        return Command(speed, turn / observation.time_step), (
            *memory[:4],
            1.0 if reached else memory[4],
        )


def planned_world():
    walls = np.zeros((30, 20), bool)
    walls[:20, 10] = True
    return World(
        walls,
        start=Pose(0.5, 0.5, 0.0),
        target=Target(1.5, 0.5, 0.05),
        cell_size=0.1,
        robot_radius=0.07,
    )


def test_a_class_whose_reset_takes_the_world_plans_in_it():
    assert simulate(planned_world(), Follower(), steps=3000).verdict == "reached"


def test_a_planner_sees_the_same_world_with_and_without_its_proof():
    world = generate("rooms", 3, size=24)
    bare = replace(world, certificate=None, provenance=None)
    first, second = (simulate(one, Follower(), steps=200, record=True) for one in (world, bare))
    assert first.verdict != "crash" and first.trace_digest == second.trace_digest


@pytest.mark.parametrize(
    ("controller", "options", "decides"),
    [
        ("bug2", {}, True),
        ("turn-random", {}, True),
        ("bug2", {"drift": 0.1}, True),
        ("turn-right", {"slip": 0.1}, False),
        ("odometry-bug", {}, True),
        ("odometry-bug", {"drift": 0.1}, False),
        ("odometry-bug", {"odometry_noise": 0.1}, False),
        ("bug2", {"odometry_noise": 0.1}, True),
    ],
)
def test_a_trace_says_whether_its_states_decide_what_comes_next(controller, options, decides):
    trace = simulate(
        generate("trap", 3), controller, record=True, seed=1, steps=400, **options
    ).trace
    assert trace.complete is decides


def test_the_states_of_a_controller_that_reads_the_clock_do_not_decide_what_comes_next():
    world = generate("trap", 3)
    assert not simulate(world, Timed(), record=True, steps=50).trace.complete
    assert simulate(world, Untimed(), record=True, steps=50).trace.complete


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize(
    ("asked", "turned"), [(3.0, 3.0), (7.0, math.pi), (-4.0, math.pi), (-3.0, -3.0)]
)
def test_a_step_turns_by_at_most_half_a_turn_as_the_help_says(asked, turned, motion):
    spin = Spins(asked)
    trace = simulate(generate("trap", 3), spin, record=True, steps=2, motion=motion).trace
    change = trace.heading[1] - trace.heading[0]
    assert abs(math.remainder(change - turned, math.tau)) < 1e-4
    assert "at\n            most half a turn" in Command.__doc__


@dataclass(frozen=True)
class Spins:
    asked: float
    senses = ("x",)

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(0.0, self.asked / observation.time_step), memory


class Untimed:
    senses = ("x",)

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(observation.top_speed, 0.1), memory


class Timed(Untimed):
    senses = ("x", "time")
