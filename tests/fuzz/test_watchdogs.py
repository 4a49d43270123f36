"""Watchdogs over proved runs: what they see, what counts as a miss, and wrong ones."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from fuzz.failure import Failure
from fuzz.watchdogs import WATCHDOGS, Drive, drives_of, judge, watchdog_named
from sim.controllers.base import Command
from sim.episode import simulate
from sim.options.run import RunOptions
from sim.verdict import Verdict
from tests.helpers.command_line import worldgen
from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter

CORPORA = Path(__file__).parents[2] / "corpora" / "failures"
WALLED = """
..........
.########.
.#......#.
.#.S....#.
.#......#.
.######.#.
.......G..
..........
"""
OPEN = """
..........
.S......G.
..........
"""


class ToAndFro:
    """Drives 10 steps one way and 10 steps the other way, endlessly: half a metre and back."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        count = memory[0]
        turn = math.pi if count % 10 == 9 else 0.0
        return Command(1.0, turn / observation.time_step), ((count + 1) % 20,)


class Rocking:
    """Drives ahead and backwards in turn."""

    def reset(self):
        return (1.0,)

    def act(self, _observation, memory):
        return Command(memory[0] / 10), (-memory[0],)


class Ahead:
    """Drives ahead."""

    def reset(self):
        return ()

    def act(self, _observation, memory):
        return Command(1.0), memory


def drive(text, controller):
    world = drawn(text)
    options = RunOptions("swept", 4_000, 0.05)
    return Drive("a run", world, simulate(world, controller(), options, record=True))


@pytest.fixture(scope="module")
def loop():
    made = drive(WALLED, ToAndFro)
    assert made.loops
    return made


@pytest.fixture(scope="module")
def arrival():
    made = drive(OPEN, Ahead)
    assert made.episode.verdict == Verdict.REACHED
    return made


def test_a_loop_is_seen_to_go_on_as_it_is_proved_to(loop):
    evidence = loop.episode.evidence
    seen = list(loop.observations(30.0))
    assert seen[-1].time >= loop.entry + 30.0
    for step in range(evidence.entry, len(seen) - evidence.period):
        later = seen[step + evidence.period]
        assert later._replace(time=0.0)[4:9] == seen[step]._replace(time=0.0)[4:9]
    times = [one.time for one in seen]
    assert times == sorted(set(times))


def test_a_loop_lasts_two_periods_at_least(loop):
    evidence = loop.episode.evidence
    assert len(list(loop.observations(1e-9))) == evidence.entry + 2 * evidence.period


def test_an_arrival_is_seen_once(arrival):
    seen = list(arrival.observations(30.0))
    assert len(seen) == arrival.episode.trace.steps
    assert seen[-1].target_distance <= arrival.world.target.radius + 0.06
    assert [one.x for one in seen] == arrival.episode.trace.x[1:].tolist()


def test_the_goal_is_the_waypoint_that_counts():
    world = drawn(OPEN)
    robot = world.robots[0]
    middle = replace(robot.target, x=0.5 * (world.start.x + world.target.x))
    world = replace(world, robots=(replace(robot, waypoints=(middle,)),))
    episode = simulate(world, Ahead(), RunOptions("swept", 4_000, 0.05), record=True)
    assert episode.verdict == Verdict.REACHED
    passed = episode.trace.passed.tolist()
    assert set(passed[1:-1]) == {0, 1}
    for seen, count in zip(
        Drive("a run", world, episode).observations(1.0), passed[1:], strict=True
    ):
        goal = robot.target if count else middle
        assert seen.target_distance == pytest.approx(math.hypot(goal.x - seen.x, goal.y - seen.y))


def test_beams_are_the_distances_to_the_walls(loop):
    trace = loop.episode.trace
    [first, *_] = loop.observations(1.0, beams=4)
    assert len(first.beams) == 4
    # The wall to the left or right of the start is one and a half cells away, or more.
    ahead = first.beams[0]
    assert ahead == pytest.approx(0.8 - trace.x[1], abs=2e-3)


def test_an_alarm_in_a_loop_is_a_catch_and_in_an_arrival_a_mistake(loop, arrival):
    [strict] = judge(["simple-progress+movement_time_allowance=0.2"], [loop, arrival])
    assert (strict.loops, strict.missed, strict.arrivals) == (1, (), 1)
    assert strict.interrupted == ("a run",)
    # The loop is half a metre long: the robot leaves each small disc again and again.
    [small] = judge(["simple-progress+required_movement_radius=0.2"], [loop, arrival])
    assert (small.missed, small.interrupted) == (("a run",), ())
    [usual] = judge(["simple-progress"], [loop, arrival])
    assert usual.missed == () and 9.0 <= usual.latencies[0] <= 10.5


def test_an_alarm_has_to_come_before_the_horizon(loop):
    [soon] = judge(["simple-progress"], [loop], horizon=5.0)
    assert soon.missed == ("a run",)


def test_turning_is_progress_for_the_checker_of_poses(loop):
    [pose] = judge(["pose-progress"], [loop])
    assert pose.missed == ("a run",)


def test_oscillation_is_two_changes_of_sign_near_one_place(loop, arrival):
    assert judge(["oscillation"], [loop])[0].missed == ("a run",)  # it never drives backwards
    rocking = drive(WALLED, Rocking)
    assert rocking.loops and judge(["oscillation"], [rocking])[0].missed == ()
    assert judge(["oscillation"], [arrival])[0].interrupted == ()


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("Mine = 3", "not-a-watchdog"),
        ("class Mine:\n def reset(self): pass", "not-a-watchdog"),
        ("class Mine:\n def reset(self): pass\n def step(self, o): return None", "not-a-bool"),
        ("class Mine:\n def reset(self): pass\n def step(self, o): return 1 / 0", "code-failed"),
        ("class Mine:\n def reset(self): pass\n def step(self, o): return 'no'", "not-a-bool"),
        (
            "class Mine:\n needs = 3\n def reset(self): pass\n def step(self, o): return False",
            "wrong-needs",
        ),
    ],
)
def test_a_wrong_watchdog_is_refused(tmp_path, loop, body, code):
    file = tmp_path / "mine.py"
    file.write_text(body + "\n")
    with raises(InvalidParameter, code):
        judge([f"{file}:Mine"], [loop])


def test_a_name_sets_fields_and_a_wrong_one_is_refused():
    assert watchdog_named("simple-progress+movement_time_allowance=3").movement_time_allowance == 3
    for name in ("pose-progress+required_movement_angle", "oscillation+x_only_threshold"):
        with raises(InvalidParameter, "code-failed") as caught:
            watchdog_named(f"{name}=-1")
        assert "is below 0" in str(caught.value)
    with raises(InvalidParameter, "unknown-name"):
        watchdog_named("simple-progress+allowance=3")
    with raises(InvalidParameter, "unknown-name"):
        watchdog_named("simple")


def test_the_registered_ones_are_watchdogs():
    assert set(WATCHDOGS) == {"oscillation", "pose-progress", "simple-progress"}
    for name in WATCHDOGS:
        watchdog_named(name).reset()


def test_a_loop_of_the_thesis_simulator_counts_but_has_no_beams(tmp_path):
    file = CORPORA.parent / "thesis-faults" / "thesis-1-loop-104.grid"
    drives, left_out = drives_of([("thesis", Failure.read(file))], 0)
    assert left_out == 0 and [drive.loops for drive in drives] == [True]
    [result] = judge(["simple-progress"], drives)
    assert result.loops == 1 and result.missed == ()
    (tmp_path / "sees.py").write_text(
        "from sim import RobotOptions\n"
        "class Sees:\n"
        " needs = RobotOptions(beams=4)\n"
        " def reset(self): pass\n"
        " def step(self, observation): return len(observation.beams) == 4\n"
    )
    assert judge([f"{tmp_path / 'sees.py'}:Sees"], drives)[0].loops == 0


def test_natural_runs_are_those_of_the_failures_controller_and_the_same_each_time():
    failure = Failure.read(CORPORA / "bug2" / "swept" / "returns-to-a-wall-2.grid")
    runs = [drives_of([("one", failure)], 3)[0] for _ in range(2)]
    digests = [[drive.episode.trace_digest for drive in drives] for drives in runs]
    assert digests[0] == digests[1] and len(digests[0]) > 1
    # The failure's own run, and arrivals of the same controller.
    assert [drive.loops for drive in runs[0]] == [True, *[False] * (len(runs[0]) - 1)]


@pytest.mark.gate
def test_the_command_prints_a_table_and_json():
    failure = CORPORA / "bug2" / "swept" / "returns-to-a-wall-2.grid"
    words = ("simple-progress,pose-progress", failure, "--worlds", 6)
    result = worldgen("watchdog", *words)
    assert result.code == 0
    lines = result.out.splitlines()
    assert lines[0].startswith("watchdog") and lines[1].startswith("simple-progress")
    facts = json.loads(worldgen("watchdog", *words, "--json").out)
    again = json.loads(worldgen("watchdog", *words, "--json").out)
    assert facts == again
    simple, pose = facts["watchdogs"]
    assert simple["loops"] == pose["loops"] > 0 and simple["arrivals"] > 0
    assert len(simple["latencies"]) + len(simple["missed"]) == simple["loops"]


def test_the_command_refuses_a_wrong_name_before_it_runs(tmp_path):
    result = worldgen("watchdog", "simple-progres", tmp_path)
    assert result.code == 2 and "did you mean" in result.err
    own = tmp_path / "mine.py"
    own.write_text("class Progress:\n    pass\n")
    result = worldgen("watchdog", f"{own}:Progres", tmp_path)
    assert f"worldgen watchdog {own}:Progress {tmp_path}" in result.err
