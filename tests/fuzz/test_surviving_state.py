"""Controllers that keep state from one run to the next: each run begins as the first one did."""

import json

import pytest

from fuzz.facts.proofs import certified
from fuzz.oracles import Trial
from fuzz.regression.answer import State, answer
from fuzz.triage.judging import failure_of
from sim import simulate
from sim.clock import controller_time
from sim.clock.controller_time import UNKNOWN_SOURCE
from sim.controllers import CONTROLLERS
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.halls import cup, hall
from worldgen import write_world

# Where the hits are counted, the line in reset() and the line before the class, if any.
PLACES = {
    "attribute": ("self.hits", "pass", ""),
    "class variable": ("Follower.hits", "pass", ""),
    "module variable": ("STATE['hits']", "pass", "STATE = {'hits': 0}"),
    "cleared attribute": ("self.hits", "self.hits = 0", ""),
}
SURVIVES = list(PLACES)[:3]

# Turns left and right alternately at its first bumps, later always left, and so loops behind a
# wall.
FOLLOWER = """
import math
from sim import Command

{before}

class Follower:
    hits = 0
    def reset(self):
        {clear}
        return (0.0,)
    def act(self, observation, memory):
        ahead = observation.target_heading - observation.heading
        if observation.bump:
            {hits} = min({hits} + 1, 40)
            side = 1.0 if {hits} % 2 or {hits} >= 40 else -1.0
            return Command(0.0, side * 1.5 / observation.time_step), (20.0,)
        if memory[0] > 0:
            return Command(observation.top_speed, 0.0), (memory[0] - 1,)
        turn = (ahead + math.pi) % math.tau - math.pi
        return Command(observation.top_speed, turn / observation.time_step), (0.0,)
"""

CIRCLE = """
import os, time
from sim import Command

class Circle:
    def reset(self{world}):
        {reset}
        return ()
    def act(self, observation, memory):
        {act}
        return Command(0.1, 512 / 65536 * 2 * 3.141592653589793 / 0.015), memory
"""


@pytest.fixture
def survivors(monkeypatch):
    found = {}
    monkeypatch.setattr(controller_time, "_survivors", found)
    return found


def follower(folder, place):
    hits, clear, before = PLACES[place]
    file = folder / "follower.py"
    file.write_text(FOLLOWER.format(hits=hits, clear=clear, before=before))
    return f"{file}:Follower"


def circle(folder, *, world="", reset="pass", act="pass"):
    file = folder / "circle.py"
    file.write_text(CIRCLE.format(world=world, reset=reset, act=act))
    return f"{file}:Circle"


def run(world, name):
    trial = Trial.recorded(world, name, Scenario(name).options(world))
    return trial.episode.verdict, trial.episode.trace_digest


@pytest.fixture(scope="module")
def worlds():
    return [certified(cup()), certified(cup(4))]


@pytest.mark.parametrize("place", PLACES)
def test_a_run_does_not_depend_on_the_runs_before_it(place, worlds, tmp_path, survivors):
    name = follower(tmp_path, place)
    first = [run(world, name) for world in worlds]
    backwards = [run(world, name) for world in reversed(worlds)]
    assert first == backwards[::-1]
    assert first[0][0] != "loop"


def test_state_is_the_same_wherever_it_is_kept(worlds, tmp_path, survivors):
    found = set()
    for number, place in enumerate(PLACES):
        folder = tmp_path / str(number)
        folder.mkdir()
        found.add(
            (
                run(worlds[1], follower(folder, place)),
                run(worlds[0], f"{folder}/follower.py:Follower"),
            )
        )
    assert len(found) == 1


@pytest.mark.parametrize("place", PLACES)
def test_what_survives_reset_is_named(place, worlds, tmp_path, survivors):
    name = follower(tmp_path, place)
    for world in worlds:
        run(world, name)
    expected = {
        "attribute": {"self.hits"},
        "cleared attribute": set(),
        "class variable": {"the variable Follower.hits"},
        "module variable": {"the variable STATE"},
    }
    assert set(survivors) == expected[place]


@pytest.mark.gate
def test_a_campaign_names_what_survives_and_all_of_its_failures_replay(tmp_path, survivors):
    name = follower(tmp_path, "attribute")
    out = tmp_path / "out"
    fuzz = ("fuzz", "--controller", name, "--units", 1, "--examples", 40, "--seed", 5)
    result = worldgen(*fuzz, "--no-shrink", "--workers", 1, "--json", "--out", out)
    assert json.loads(result.out)["survives_reset"] == ["self.hits"]
    assert json.loads((out / ".campaign/summary.json").read_text())["survives_reset"]
    files = sorted(out.glob("*.grid"))
    assert files and "loop" not in {file.name.split("-")[0] for file in files}
    assert worldgen("replay", *reversed(files)).code == worldgen("replay", files[-1]).code == 0


def test_a_command_names_what_survives(worlds, tmp_path, survivors):
    name = follower(tmp_path, "attribute")
    write_world(worlds[0], tmp_path / "w.grid")
    before = worldgen("run", tmp_path / "w.grid", "--controller", name)
    run(worlds[1], name)
    after = worldgen("run", tmp_path / "w.grid", "--controller", name)
    assert before.out == after.out
    assert "survives reset(): self.hits" in after.err


def test_only_the_controller_that_keeps_state_is_said_to(worlds, tmp_path):
    keeps = follower(tmp_path, "attribute")
    clears = circle(tmp_path)
    for world in worlds:
        run(world, keeps)
    write_world(hall(), tmp_path / "w.grid")
    assert "survives" not in worldgen("run", tmp_path / "w.grid", "--controller", clears).err
    # Files of both in one command: the message names one.
    files = []
    for number, name in enumerate([keeps, clears]):
        failure = failure_of(worlds[0], Scenario(name))
        files.append(tmp_path / f"{number}.grid")
        failure.write(files[-1])
    (line,) = [x for x in worldgen("replay", "--trust", *files).err.splitlines() if "survives" in x]
    assert keeps in line and clears not in line


def test_state_that_reset_clears_may_prove_a_loop(tmp_path, survivors):
    name = circle(tmp_path, reset="self.old = 0.0", act="self.old = 0.0")
    assert [simulate(hall(), name).verdict for _ in range(2)] == ["loop", "loop"]
    assert not survivors


def test_a_plan_that_a_planner_keeps_is_no_leftover_of_a_run(worlds, tmp_path, survivors):
    name = circle(tmp_path, world=", world", reset="self.plan = world.target.x")
    world = [hall(target=(x, 1.45)) for x in (2.45, 2.55)]
    assert [simulate(one, name).verdict for one in world] == ["loop", "loop"]
    assert not survivors


def test_what_differs_in_every_instance_is_no_leftover_of_a_run(tmp_path, survivors):
    name = circle(tmp_path, reset="self.began = time.perf_counter_ns()")
    assert [simulate(hall(), name).verdict for _ in range(2)] == ["loop", "loop"]
    assert not survivors


def test_runs_that_differ_by_unseen_state_are_no_failure(worlds, tmp_path, monkeypatch, survivors):
    monkeypatch.setenv("RUNS_OF_CIRCLE", "0")
    count = "os.environ['RUNS_OF_CIRCLE'] = str(int(os.environ['RUNS_OF_CIRCLE']) + 1)"
    speed = "return Command(int(os.environ['RUNS_OF_CIRCLE']) / 1000, 2.0), memory"
    steady = circle(tmp_path)
    failure = failure_of(worlds[0], Scenario(steady))
    CONTROLLERS.forget(str(tmp_path / "circle.py"))
    name = circle(tmp_path, reset=count, act=speed)
    differences = {}
    monkeypatch.setattr(controller_time, "_differences", differences)
    assert failure_of(worlds[0], Scenario(name)) is None
    assert set(differences) == {UNKNOWN_SOURCE}
    now = answer(failure, name)
    assert now.state is State.UNPROVED
    assert "its runs differ although the input is the same" in now.words


COUNTED = """
import functools
with open({mark!r}, "a") as file:
    file.write("loaded\\n")
del file
from helper import TABLE
from sim import Command

CALLS = []
SHARED = dict(calls=CALLS)

@functools.cache
def side(bumps):
    return 1.0 if len(CALLS) % 3 else -1.0

class Robot:
    bumps = 0
    def reset(self, seen={{}}):
        self.table = TABLE
        return (0.0,)
    def act(self, observation, memory):
        if observation.bump:
            CALLS.append(1)
            TABLE["bumps"] = TABLE.get("bumps", 0) + 1
            Robot.bumps += 1
            assert SHARED["calls"] is CALLS and len(CALLS) == Robot.bumps == TABLE["bumps"]
        turn = observation.target_heading - observation.heading + side(Robot.bumps) / (1 + len(CALLS))
        return Command(observation.top_speed, turn), (0.0,)
"""


def loads_for_equal_runs(folder, helper):
    """Run the controller above three times with a helper module; return how often it was loaded."""
    mark = folder / "mark"
    (folder / "helper.py").write_text(helper)
    (folder / "counted.py").write_text(COUNTED.format(mark=str(mark)))
    name = f"{folder}/counted.py:Robot"
    world = certified(cup())
    runs = [Trial.recorded(world, name, Scenario(name).options(world)).episode for _ in range(3)]
    assert len({run.trace.digest() for run in runs}) == 1
    assert runs[0].verdict != "crash"
    return mark.read_text().count("loaded")


def test_variables_are_set_back_without_loading_the_file_again(tmp_path):
    assert loads_for_equal_runs(tmp_path, "TABLE = {}\n") == 1


def test_variables_that_cannot_be_copied_are_renewed_by_loading_the_file_again(tmp_path):
    helper = "import threading\nTABLE, LOCK = {}, threading.Lock()\n"
    assert loads_for_equal_runs(tmp_path, helper) > 1
